# Debian packages by CPack: the libraries, what developers need, the programs, and the Python package.
# tools/package makes them.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The bullet_ccd authors")
set(CPACK_PACKAGE_CONTACT "The bullet_ccd authors <bullet_ccd@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_ALL libraries dev tools)

set(_libraries "libbullet-ccd0 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_NAME libbullet-ccd0)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION
    "Shared libraries of bullet_ccd, and the program that reads mesh files for them.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libbullet-ccd-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "${_libraries}, libeigen3-dev, libtbb-dev, liburdfdom-dev, libbullet-dev, libqhull-dev, \
libtinyxml2-dev, nlohmann-json3-dev, libpng-dev, libtinygltf-dev, coinor-libclp-dev, liborocos-kdl-dev, libyaml-cpp-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers of bullet_ccd, and its files for CMake and pkg-config.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME bullet-ccd-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "${_libraries}")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION
    "The programs grasp, bullet-ccd and make_objects, with hands and household objects.")
if(BULLET_CCD_PYTHON)
    list(APPEND CPACK_COMPONENTS_ALL python)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-bullet-ccd)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${_libraries}, python3, python3-numpy")
    set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The package bullet_ccd for Python 3.")
endif()

# What the programs need beside our own libraries is found by dpkg-shlibdeps.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
foreach(_target bullet_ccd_core bullet_ccd_reduce bullet_ccd_io bullet_ccd_bullet bullet_ccd_bullet_float64 grasp grasp_sim)
    if(TARGET ${_target})
        get_target_property(_folder ${_target} BINARY_DIR)
        list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${_folder}")
    endif()
endforeach()
include(CPack)

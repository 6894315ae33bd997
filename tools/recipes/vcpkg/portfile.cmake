# The checkout that this recipe stands in; a registry takes the archive of a release instead.
set(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../..")
set(precision none)
if("bullet" IN_LIST FEATURES)
    set(precision single)
endif()
vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        -DBULLET_CCD_BULLET_PRECISION=${precision}
        -DBULLET_CCD_IO=OFF
        -DBULLET_CCD_GRASP=OFF
        -DBULLET_CCD_TOOLS=OFF
        -DBULLET_CCD_TESTS=OFF
        -DBULLET_CCD_BENCHMARKS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/bullet_ccd)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")

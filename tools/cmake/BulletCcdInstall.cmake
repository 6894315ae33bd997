# Installation: libraries, public headers, the package configuration and its components.
#
# Every component has its own export set, so that who asks for `core` needs no Bullet. What was built
# is installed: a component whose library was not built (tools/demo builds only what it needs) is left
# out with a note, and find_package() says that it is missing.
include(CMakePackageConfigHelpers)

set(_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/bullet_ccd")
set(_components core reduce io ompl bullet bullet_float64 grasp grasp_sim grasp_task)
set(_target_core bullet_ccd_core)
set(_target_reduce bullet_ccd_reduce)
set(_target_io bullet_ccd_io)
set(_target_ompl bullet_ccd_ompl)
set(_target_bullet bullet_ccd_bullet)
set(_target_bullet_float64 bullet_ccd_bullet_float64)
set(_target_grasp grasp)
set(_target_grasp_task grasp_task)
set(_target_grasp_sim grasp_sim)
# Names behind the namespace: bullet_ccd::core, grasp::grasp, grasp::task, grasp::sim.
foreach(_component core reduce io ompl bullet bullet_float64)
    set(_namespace_${_component} bullet_ccd::)
    set(_export_name_${_component} ${_component})
endforeach()
set(_namespace_grasp grasp::)
set(_export_name_grasp grasp)
set(_namespace_grasp_task grasp::)
set(_export_name_grasp_task task)
set(_namespace_grasp_sim grasp::)
set(_export_name_grasp_sim sim)

# For builds without CMake: `pkg-config --cflags --libs bullet_ccd-core`, one file per component.
set(_pc_requires_core "eigen3")
set(_pc_private_core "tbb")
set(_pc_requires_reduce "bullet_ccd-core")
set(_pc_private_reduce "qhull_r tbb")
set(_pc_libraries_reduce " -lmeshoptimizer")
set(_pc_requires_io "bullet_ccd-core")
set(_pc_private_io "urdfdom tinyxml2")
set(_pc_requires_ompl "bullet_ccd-core ompl")
set(_pc_private_ompl "tbb")
set(_pc_requires_bullet "bullet_ccd-core bullet")
set(_pc_requires_bullet_float64 "bullet_ccd-core bullet-float64")
set(_pc_requires_grasp "bullet_ccd-io")
set(_pc_private_grasp "qhull_r clp orocos_kdl libpng tinyxml2 yaml-cpp tbb")
set(_pc_requires_grasp_task "bullet_ccd-grasp_sim bullet_ccd-ompl")
set(_pc_requires_grasp_sim "bullet_ccd-grasp bullet_ccd-bullet_float64")
function(bullet_ccd_pkg_config component target file_variable)
    set(_file "bullet_ccd-${component}.pc")
    # Relative to the file, so that the tree can be moved.
    set(_prefix "\${pcfiledir}")
    string(REGEX MATCHALL "[^/]+" _parts "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
    foreach(_part IN LISTS _parts)
        string(APPEND _prefix "/..")
    endforeach()
    file(GENERATE OUTPUT "${PROJECT_BINARY_DIR}/${_file}" CONTENT "prefix=${_prefix}

Name: bullet_ccd-${component}
Description: ${PROJECT_DESCRIPTION} (${component})
Version: ${PROJECT_VERSION}
Requires: ${_pc_requires_${component}}
Requires.private: ${_pc_private_${component}}
Cflags: -std=c++20 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16 -I\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}/bullet-ccd
Libs: -L\${prefix}/${CMAKE_INSTALL_LIBDIR} -l$<TARGET_FILE_BASE_NAME:${target}>
Libs.private:${_pc_libraries_${component}}
")
    set(_folder "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
    install(FILES "${PROJECT_BINARY_DIR}/${_file}" DESTINATION "${_folder}" COMPONENT dev)
    set(${file_variable} "${_folder}/${_file}" PARENT_SCOPE)
endfunction()

add_custom_target(libraries COMMENT "All libraries that can be installed")
# Who builds the programs and installs must not get a library that an older tree has left behind.
if(TARGET programs)
    add_dependencies(programs libraries)
endif()
foreach(_component IN LISTS _components)
    set(_target ${_target_${_component}})
    if(NOT TARGET ${_target})
        continue()
    endif()
    add_dependencies(libraries ${_target})
    set_target_properties(${_target} PROPERTIES EXPORT_NAME ${_export_name_${_component}})
    install(TARGETS ${_target} EXPORT bullet_ccd_${_component}
            ARCHIVE COMPONENT dev OPTIONAL
            LIBRARY COMPONENT libraries NAMELINK_COMPONENT dev OPTIONAL
            FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/bullet-ccd" COMPONENT dev)
    set(_targets_file "bullet_ccd_${_component}Targets.cmake")
    install(EXPORT bullet_ccd_${_component} NAMESPACE ${_namespace_${_component}}
            FILE ${_targets_file} DESTINATION "${_config_dir}" COMPONENT dev)
    bullet_ccd_pkg_config(${_component} ${_target} _pc_file)
    install(CODE "
        if(NOT EXISTS \"$<TARGET_FILE:${_target}>\")
            message(STATUS \"Not built, so not installed: component ${_component}\")
            file(REMOVE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${_config_dir}/${_targets_file}\"
                        \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${_pc_file}\")
        endif()" COMPONENT dev)
endforeach()

if(TARGET bullet_ccd_mesh_reader)
    install(TARGETS bullet_ccd_mesh_reader
            RUNTIME DESTINATION "${CMAKE_INSTALL_LIBEXECDIR}/bullet_ccd" COMPONENT libraries OPTIONAL)
endif()

configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/bullet_ccdConfig.cmake.in"
                              "${PROJECT_BINARY_DIR}/bullet_ccdConfig.cmake"
                              INSTALL_DESTINATION "${_config_dir}"
                              PATH_VARS CMAKE_INSTALL_LIBEXECDIR)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/bullet_ccdConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_SOURCE_DIR}/docs/glossary.md" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT dev)
install(FILES "${PROJECT_BINARY_DIR}/bullet_ccdConfig.cmake"
              "${PROJECT_BINARY_DIR}/bullet_ccdConfigVersion.cmake"
              "${CMAKE_CURRENT_LIST_DIR}/FindBulletPrecision.cmake"
        "${CMAKE_CURRENT_LIST_DIR}/FindOmpl.cmake"
        DESTINATION "${_config_dir}" COMPONENT dev)

# A program that links both precisions is refused when it is configured: CMake says that the
# property of one does not agree with the other's.
set(_precision_bullet single)
set(_precision_bullet_float64 double)
foreach(_component bullet bullet_float64)
    if(TARGET ${_target_${_component}})
        set_target_properties(${_target_${_component}} PROPERTIES
            INTERFACE_BULLET_CCD_PRECISION ${_precision_${_component}}
            COMPATIBLE_INTERFACE_STRING BULLET_CCD_PRECISION)
    endif()
endforeach()

# Completion by bash, which looks for a file with the name of the program.
if(BULLET_CCD_TOOLS)
    foreach(_program grasp bullet-ccd)
        install(FILES "${PROJECT_SOURCE_DIR}/tools/bullet_ccd_completion" RENAME ${_program}
                DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT tools)
    endforeach()
    # Manual pages, made by tools/package: the target exists everywhere, and does nothing without help2man.
    find_program(HELP2MAN_PROGRAM help2man)
    mark_as_advanced(HELP2MAN_PROGRAM)
    set(_manuals "${PROJECT_BINARY_DIR}/manuals")
    add_custom_target(manuals)
    if(HELP2MAN_PROGRAM)
        add_custom_command(OUTPUT "${_manuals}/stamp"
                           COMMAND ${CMAKE_COMMAND} -E rm -rf "${_manuals}"
                           COMMAND "${PROJECT_SOURCE_DIR}/tools/manual" $<TARGET_FILE:bullet_ccd_cli> "${_manuals}"
                           COMMAND "${PROJECT_SOURCE_DIR}/tools/manual" $<TARGET_FILE:grasp_program> "${_manuals}"
                           COMMAND ${CMAKE_COMMAND} -E touch "${_manuals}/stamp"
                           DEPENDS bullet_ccd_cli grasp_program "${PROJECT_SOURCE_DIR}/tools/manual"
                           COMMENT "Writing manual pages" VERBATIM)
        add_custom_target(manual_pages DEPENDS "${_manuals}/stamp")
        add_dependencies(manuals manual_pages)
    endif()
    install(DIRECTORY "${_manuals}/" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT tools OPTIONAL
            FILES_MATCHING PATTERN "*.1")
endif()

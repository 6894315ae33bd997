# Bullet in one or both precisions, from its pkg-config files (the packaged CMake configuration has
# no imported targets). Components: single, double; targets BulletPrecision::single and ::double.
include(FindPackageHandleStandardArgs)
find_package(PkgConfig REQUIRED QUIET)

set(_bullet_pc_single bullet)
set(_bullet_pc_double bullet-float64)
foreach(_component IN LISTS BulletPrecision_FIND_COMPONENTS)
    pkg_check_modules(BULLET_PC_${_component} QUIET IMPORTED_TARGET ${_bullet_pc_${_component}})
    if(BULLET_PC_${_component}_FOUND)
        set(BulletPrecision_${_component}_FOUND TRUE)
        if(NOT TARGET BulletPrecision::${_component})
            add_library(BulletPrecision::${_component} INTERFACE IMPORTED)
            target_link_libraries(BulletPrecision::${_component}
                                  INTERFACE PkgConfig::BULLET_PC_${_component})
        endif()
        set(BulletPrecision_VERSION "${BULLET_PC_${_component}_VERSION}")
    endif()
endforeach()
find_package_handle_standard_args(BulletPrecision HANDLE_COMPONENTS
    REQUIRED_VARS BulletPrecision_VERSION VERSION_VAR BulletPrecision_VERSION)

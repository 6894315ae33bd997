# OMPL as the target Ompl::ompl. Its own configuration and its pkg-config file add /usr/include and
# -std=c++14 to what uses it.
find_path(OMPL_INCLUDE_FOLDER ompl/config.h PATH_SUFFIXES ompl-1.7 ompl-1.6 ompl-1.5)
find_library(OMPL_LIBRARY ompl)
mark_as_advanced(OMPL_INCLUDE_FOLDER OMPL_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Ompl REQUIRED_VARS OMPL_LIBRARY OMPL_INCLUDE_FOLDER)
if(Ompl_FOUND AND NOT TARGET Ompl::ompl)
    add_library(Ompl::ompl UNKNOWN IMPORTED)
    set_target_properties(Ompl::ompl PROPERTIES
        IMPORTED_LOCATION "${OMPL_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OMPL_INCLUDE_FOLDER}")
endif()

# Helpers that every room uses, so that warnings and numerics are set in one place.

# Options of our own targets only; never global, so that a parent project keeps its own.
function(bullet_ccd_target_options target)
    target_compile_features(${target} PUBLIC cxx_std_20)
    # -ffp-contract=off: the same bits with and without FMA, so that results can be compared.
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
                                             -ffp-contract=off)
    target_include_directories(
        ${target} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>"
                         "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/bullet-ccd>")
    if(BULLET_CCD_ASSERTIONS)
        target_compile_definitions(${target} PRIVATE BULLET_CCD_ASSERTIONS)
        target_compile_options(${target} PRIVATE -UNDEBUG)
    endif()
endfunction()

# For targets with many files: parses Eigen and the given headers once; nothing where precompiled
# headers are off.
function(bullet_ccd_precompile target)
    if(BULLET_CCD_PRECOMPILED_HEADERS)
        target_precompile_headers(${target} PRIVATE <Eigen/Geometry> <algorithm> <functional> <map>
                                  <memory> <string> <vector> ${ARGN})
        bullet_ccd_precompiled_options(${target})
    endif()
endfunction()

function(bullet_ccd_precompiled_options target)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        # For ccache; and GCC 12 sees overlaps in std::string where that is precompiled.
        target_compile_options(${target} PRIVATE -fpch-preprocess -Wno-restrict -Wno-array-bounds
                                                 -Wno-stringop-overflow -Wno-stringop-overread)
    endif()
endfunction()

# Where the time of a query goes: optimised fully even where the preset asks for less. These files
# have flags of their own, so they cannot share precompiled headers.
function(bullet_ccd_hot)
    if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
        set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -O3)
        set_source_files_properties(${ARGN} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
endfunction()

# Test programs share one set of precompiled headers.
function(bullet_ccd_share_test_headers target)
    if(NOT BULLET_CCD_PRECOMPILED_HEADERS)
        return()
    endif()
    if(NOT TARGET bullet_ccd_test_headers)
        set(_source "${PROJECT_BINARY_DIR}/test_headers.cpp")
        file(CONFIGURE OUTPUT "${_source}" CONTENT "")
        add_library(bullet_ccd_test_headers OBJECT "${_source}")
        target_link_libraries(bullet_ccd_test_headers PRIVATE bullet_ccd::core GTest::gmock)
        bullet_ccd_target_options(bullet_ccd_test_headers)
        target_compile_options(bullet_ccd_test_headers PRIVATE -O1)
        bullet_ccd_precompile(bullet_ccd_test_headers <gmock/gmock.h> <gtest/gtest.h>)
    endif()
    target_precompile_headers(${target} REUSE_FROM bullet_ccd_test_headers)
    bullet_ccd_precompiled_options(${target})
endfunction()

# A library with its alias. HEADERS are the public ones: they are installed, and each must compile by
# itself. All other headers are private. STATIC: whatever BUILD_SHARED_LIBS says, for what is not
# installed.
# bullet_ccd_library(name [STATIC] ALIAS ns::name SOURCES ... HEADERS ... LINK ... LINK_PRIVATE ...)
function(bullet_ccd_library name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "STATIC" "ALIAS" "SOURCES;HEADERS;LINK;LINK_PRIVATE")
    set(_kind)
    if(arg_STATIC)
        set(_kind STATIC)
    endif()
    add_library(${name} ${_kind} ${arg_SOURCES})
    add_library(${arg_ALIAS} ALIAS ${name})
    target_sources(${name} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}"
                                  FILES ${arg_HEADERS})
    target_link_libraries(${name} PUBLIC ${arg_LINK} PRIVATE ${arg_LINK_PRIVATE})
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON
                                             VERIFY_INTERFACE_HEADER_SETS ON
                                             CXX_VISIBILITY_PRESET hidden
                                             VISIBILITY_INLINES_HIDDEN ON
                                             DEFINE_SYMBOL ""
                                             VERSION ${PROJECT_VERSION}
                                             SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
    bullet_ccd_target_options(${name})
endfunction()

# One GoogleTest program; every test becomes a ctest test.
# bullet_ccd_test(name SOURCES ... LINK ...)
function(bullet_ccd_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    add_executable(${name} ${arg_SOURCES})
    target_link_libraries(${name} PRIVATE ${arg_LINK} GTest::gmock GTest::gtest_main)
    bullet_ccd_target_options(${name})
    # What is tested is compiled as elsewhere; of the tests themselves the time is in compiling.
    target_compile_options(${name} PRIVATE -O1)
    bullet_ccd_share_test_headers(${name})
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 900)
endfunction()

# All targets of a folder and the folders below it.
function(bullet_ccd_targets_below folder result)
    get_property(_targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
    get_property(_folders DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
    foreach(_folder IN LISTS _folders)
        bullet_ccd_targets_below("${_folder}" _below)
        list(APPEND _targets ${_below})
    endforeach()
    set(${result} "${_targets}" PARENT_SCOPE)
endfunction()

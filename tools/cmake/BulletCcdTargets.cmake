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
                                                 -Wno-stringop-overflow -Wno-stringop-overread
                                                 -Wno-maybe-uninitialized)
    endif()
endfunction()

# Sets `result` to files to compile in place of the given sources of a target. Where
# BULLET_CCD_JOIN_SOURCES asks for it, the sources of one folder are included by one file: headers are
# parsed and templates instantiated once per folder instead of once per file. Names in anonymous
# namespaces must therefore be unique in their folder. Files with options of their own stay alone, and
# those whose property SKIP_UNITY_BUILD_INCLUSION is set. ALL_BUT_CORE leaves the core as it is: how its
# functions are inlined is part of what its benchmarks have measured. (CMake's own unity builds include
# by absolute paths, so that no two working trees would share what ccache has compiled.)
function(bullet_ccd_join result target)
    if(NOT BULLET_CCD_JOIN_SOURCES
       OR (BULLET_CCD_JOIN_SOURCES STREQUAL "ALL_BUT_CORE" AND target STREQUAL "bullet_ccd_core"))
        set(${result} ${ARGN} PARENT_SCOPE)
        return()
    endif()
    set(_alone)
    set(_folders)
    foreach(_source IN LISTS ARGN)
        cmake_path(ABSOLUTE_PATH _source NORMALIZE OUTPUT_VARIABLE _path)
        get_source_file_property(_options "${_source}" COMPILE_OPTIONS)
        get_source_file_property(_definitions "${_source}" COMPILE_DEFINITIONS)
        get_source_file_property(_skipped "${_source}" SKIP_UNITY_BUILD_INCLUSION)
        cmake_path(IS_PREFIX PROJECT_SOURCE_DIR "${_path}" _ours)
        if(_options OR _definitions OR _skipped OR NOT _ours OR _source MATCHES "[$]<")
            list(APPEND _alone "${_source}")
            continue()
        endif()
        cmake_path(RELATIVE_PATH _path BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
        cmake_path(GET _path PARENT_PATH _folder)
        string(MAKE_C_IDENTIFIER "${_folder}" _folder)
        list(APPEND _folders ${_folder})
        list(APPEND _sources_${_folder} "${_path}")
        set(_only_${_folder} "${_source}")
    endforeach()
    list(REMOVE_DUPLICATES _folders)

    # GCC takes an included file for a header, where a class must not have members of local types.
    set(_pragma "")
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        set(_pragma "#pragma GCC diagnostic ignored \"-Wsubobject-linkage\"\n")
    endif()
    # Parts of similar length, so that the processors have something to share.
    set(_most 12)
    set(_joined)
    foreach(_folder IN LISTS _folders)
        list(LENGTH _sources_${_folder} _count)
        if(_count EQUAL 1)
            list(APPEND _alone "${_only_${_folder}}")
            continue()
        endif()
        math(EXPR _parts "(${_count} + ${_most} - 1) / ${_most}")
        math(EXPR _length "(${_count} + ${_parts} - 1) / ${_parts}")
        foreach(_part RANGE 1 ${_parts})
            math(EXPR _begin "(${_part} - 1) * ${_length}")
            list(SUBLIST _sources_${_folder} ${_begin} ${_length} _members)
            list(TRANSFORM _members REPLACE "(.+)" "#include \"\\1\"")
            list(JOIN _members "\n" _text)
            set(_file "${CMAKE_CURRENT_BINARY_DIR}/joined/${target}_${_folder}_${_part}.cpp")
            file(CONFIGURE OUTPUT "${_file}" CONTENT "${_pragma}${_text}\n" @ONLY)
            list(APPEND _joined "${_file}")
        endforeach()
    endforeach()
    set(${result} ${_joined} ${_alone} PARENT_SCOPE)
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
    bullet_ccd_join(_sources ${name} ${arg_SOURCES})
    add_library(${name} ${_kind} ${_sources})
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

# Tests of a GoogleTest program: one ctest test per shard of it, with a report in test_reports/ that
# tools/check counts the tests from. (A ctest test per GoogleTest test would start thousands of
# processes, each of which prepares what all tests of the program share.)
# bullet_ccd_add_gtest(program [SHARDS n])
function(bullet_ccd_add_gtest program)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "SHARDS" "")
    if(NOT arg_SHARDS)
        set(arg_SHARDS 1)
    endif()
    foreach(_shard RANGE 1 ${arg_SHARDS})
        set(_test ${program})
        if(arg_SHARDS GREATER 1)
            string(APPEND _test .${_shard})
        endif()
        math(EXPR _index "${_shard} - 1")
        add_test(NAME ${_test}
                 COMMAND "${PROJECT_SOURCE_DIR}/tests/run_gtest.py"
                         "${PROJECT_BINARY_DIR}/test_reports/${_test}.xml" 900
                         $<TARGET_FILE:${program}>)
        # The script stops a program that hangs; this is for a script that hangs.
        set_tests_properties(${_test} PROPERTIES TIMEOUT 1000 ENVIRONMENT
            "GTEST_TOTAL_SHARDS=${arg_SHARDS};GTEST_SHARD_INDEX=${_index};BULLET_CCD_CACHE=")
    endforeach()
endfunction()

# One GoogleTest program. EXTENDED: it is built and run by default with BULLET_CCD_EXTENDED only.
# bullet_ccd_test(name [EXTENDED] [SHARDS n] SOURCES ... LINK ...)
function(bullet_ccd_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "EXTENDED" "SHARDS" "SOURCES;LINK")
    bullet_ccd_join(_sources ${name} ${arg_SOURCES})
    add_executable(${name} ${_sources})
    target_link_libraries(${name} PRIVATE ${arg_LINK} GTest::gmock GTest::gtest_main)
    bullet_ccd_target_options(${name})
    # What is tested is compiled as elsewhere; of the tests themselves the time is in compiling.
    target_compile_options(${name} PRIVATE -O1)
    bullet_ccd_share_test_headers(${name})
    if(arg_EXTENDED AND NOT BULLET_CCD_EXTENDED)
        set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    else()
        bullet_ccd_add_gtest(${name} SHARDS ${arg_SHARDS})
    endif()
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

/// Every public header includes this one first. It checks the language and Eigen's alignment, and
/// names the attribute of symbols that a shared library exports.
#pragma once

#if __cplusplus < 202002L
#error \
    "bullet_ccd needs C++20: compile with -std=c++20. (A CMake target that links to \
bullet_ccd::core is compiled so.)"
#endif

#include <Eigen/Core>

// Programs and the library hand Eigen::Isometry3d to each other. Eigen aligns it by 16 to 64 bytes,
// depending on the instruction set, so -march=native would change the layout of structures that the
// library was compiled with. Therefore the alignment is fixed.
#if EIGEN_MAX_STATIC_ALIGN_BYTES != 16
#error \
    "bullet_ccd needs Eigen's types aligned by 16 bytes, whatever the instruction set is: compile \
with -DEIGEN_MAX_STATIC_ALIGN_BYTES=16. (A CMake target that links to bullet_ccd::core is compiled so.)"
#endif

/// Marks what is visible outside of a shared library; everything else is hidden. Headers that are
/// not installed use it for functions that other libraries and programs of this project call.
#define BULLET_CCD_API __attribute__((visibility("default")))

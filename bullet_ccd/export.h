/// What every public header includes first: it checks the language and Eigen's alignment, and names
/// the attribute of what a shared library shows.
#pragma once

#if __cplusplus < 202002L
#error \
    "bullet_ccd needs C++20: compile with -std=c++20. (A CMake target that links to \
bullet_ccd::core is compiled so.)"
#endif

#include <Eigen/Core>

// Eigen::Isometry3d is a part of what programs and the library hand to each other, and Eigen aligns
// it by 16 to 64 bytes, as the instructions allow. So -march=native would change the layout of
// structures that the library was compiled with; therefore the alignment is fixed.
#if EIGEN_MAX_STATIC_ALIGN_BYTES != 16
#error \
    "bullet_ccd needs Eigen's types aligned by 16 bytes, whatever the instruction set is: compile \
with -DEIGEN_MAX_STATIC_ALIGN_BYTES=16. (A CMake target that links to bullet_ccd::core is compiled so.)"
#endif

/// Marks what is visible outside of a shared library; everything else is hidden. Headers that are
/// not installed use it for what other libraries and the programs of this project call.
#define BULLET_CCD_API __attribute__((visibility("default")))

/// NumPy arrays and other Python objects as what the library takes, with errors that name the
/// argument, and the way back.
#pragma once

#include "bullet_ccd/motion/rigid_motion.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <string>
#include <vector>

namespace bullet_ccd::python
{
namespace py = pybind11;

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// An array of real numbers, contiguous and in double precision; a copy only where it has to be.
/// Throws TypeError for anything but real numbers.
[[nodiscard]] DoubleArray doublesOf(const py::handle& value, const char* name);

/// The same of integers.
[[nodiscard]] IndexArray indicesOf(const py::handle& value, const char* name);

/// Throws ValueError "<name>: expected shape <expected>, but got <shape>" unless the array has it.
/// @param sizes -1 stands for any size
void checkShape(const py::array& array, std::vector<py::ssize_t> sizes, const char* name);

/// Three numbers.
[[nodiscard]] Eigen::Vector3d vectorOf(const py::handle& value, const char* name);

/// n x 3 numbers.
[[nodiscard]] std::vector<Eigen::Vector3d> placesOf(const py::handle& value, const char* name);

/// A 4 x 4 homogeneous matrix as a pose; None is the identity. That its rotation is one is checked
/// by the queries.
[[nodiscard]] Eigen::Isometry3d poseOf(const py::handle& value, const char* name);

/// One pose, or an array of n of them. None is the identity.
[[nodiscard]] std::vector<Eigen::Isometry3d> posesOf(const py::handle& value, const char* name);

/// A Motion, a pose (a body at rest there) or None (at rest at the origin).
[[nodiscard]] RigidMotion motionOf(const py::handle& value, const char* name);

/// Copies, which the caller may change.
[[nodiscard]] DoubleArray arrayOf(const Eigen::Vector3d& vector);
[[nodiscard]] DoubleArray arrayOf(const Eigen::Matrix3d& matrix);
[[nodiscard]] DoubleArray arrayOf(const Eigen::Isometry3d& pose);

/// A read-only view of memory that `owner` keeps alive: no copy.
template <class Number>
[[nodiscard]] py::array viewOf(const Number* data,
                               py::ssize_t rows,
                               py::ssize_t columns,
                               const py::handle& owner)
{
    py::array_t<Number> view({rows, columns}, data, owner);
    view.attr("flags").attr("writeable") = false;
    return view;
}
}  // namespace bullet_ccd::python

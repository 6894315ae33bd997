#include "python/src/arrays.h"

#include <algorithm>
#include <utility>

namespace bullet_ccd::python
{
namespace
{
/// The value as an array whose elements are of one of the kinds (NumPy's letters).
py::array arrayOfKind(const py::handle& value,
                      const std::string& kinds,
                      const char* what,
                      const char* name)
{
    const py::array array = py::array::ensure(value);
    if (!array)
    {
        PyErr_Clear();
    }
    // An empty list has no numbers that could be of a wrong kind.
    if (!array || (array.size() > 0 && kinds.find(array.dtype().kind()) == std::string::npos))
    {
        throw py::type_error(
            std::string(name) + ": expected an array of " + what + ", but got " +
            (array && array.dtype().kind() != 'O'
                 ? "elements of type " + std::string(py::str(array.dtype()))
                 : "an object of type " +
                       std::string(py::str(py::type::of(value).attr("__name__")))));
    }
    return array;
}

std::string shapeText(const std::vector<py::ssize_t>& sizes)
{
    if (sizes.empty())
    {
        return "()";
    }
    std::string text = "(";
    for (const py::ssize_t size : sizes)
    {
        text += size < 0 ? "n" : std::to_string(size);
        text += ", ";
    }
    text.resize(text.size() - (sizes.size() > 1 ? 2 : 1));
    return text + ")";
}

Eigen::Isometry3d poseAt(const double* rows, const std::string& name)
{
    using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
    Eigen::Isometry3d pose;
    pose.matrix() = Eigen::Map<const RowMajor>(rows);
    if (pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    {
        throw py::value_error(name + ": the last row of a pose must be 0, 0, 0, 1");
    }
    return pose;
}
}  // namespace

DoubleArray doublesOf(const py::handle& value, const char* name)
{
    return arrayOfKind(value, "fiu", "real numbers", name);
}

IndexArray indicesOf(const py::handle& value, const char* name)
{
    return arrayOfKind(value, "iu", "integers", name);
}

void checkShape(const py::array& array, std::vector<py::ssize_t> sizes, const char* name)
{
    const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
    const bool fits = std::ranges::equal(shape,
                                         sizes,
                                         [](py::ssize_t is, py::ssize_t wanted)
                                         { return wanted < 0 || is == wanted; });
    if (!fits)
    {
        throw py::value_error(std::string(name) + ": expected an array of shape " +
                              shapeText(sizes) + ", but got " + shapeText(shape));
    }
}

Eigen::Vector3d vectorOf(const py::handle& value, const char* name)
{
    const DoubleArray array = doublesOf(value, name);
    checkShape(array, {3}, name);
    return {array.at(0), array.at(1), array.at(2)};
}

std::vector<Eigen::Vector3d> placesOf(const py::handle& value, const char* name)
{
    const DoubleArray array = doublesOf(value, name);
    checkShape(array, {-1, 3}, name);
    std::vector<Eigen::Vector3d> places;
    for (py::ssize_t i = 0; i < array.shape(0); ++i)
    {
        places.emplace_back(Eigen::Map<const Eigen::Vector3d>(array.data(i)));
    }
    return places;
}

Eigen::Isometry3d poseOf(const py::handle& value, const char* name)
{
    if (value.is_none())
    {
        return Eigen::Isometry3d::Identity();
    }
    const DoubleArray array = doublesOf(value, name);
    checkShape(array, {4, 4}, name);
    return poseAt(array.data(), name);
}

std::vector<Eigen::Isometry3d> posesOf(const py::handle& value, const char* name)
{
    if (value.is_none())
    {
        return {Eigen::Isometry3d::Identity()};
    }
    const DoubleArray array = doublesOf(value, name);
    if (array.ndim() == 2)
    {
        return {poseOf(array, name)};
    }
    checkShape(array, {-1, 4, 4}, name);
    std::vector<Eigen::Isometry3d> poses;
    for (py::ssize_t i = 0; i < array.shape(0); ++i)
    {
        poses.push_back(poseAt(array.data(i), name + ("[" + std::to_string(i) + "]")));
    }
    return poses;
}

RigidMotion motionOf(const py::handle& value, const char* name)
{
    if (py::isinstance<RigidMotion>(value))
    {
        return value.cast<RigidMotion>();
    }
    return restAt(poseOf(value, name));
}

DoubleArray arrayOf(const Eigen::Vector3d& vector)
{
    return DoubleArray(3, vector.data());
}

DoubleArray arrayOf(const Eigen::Matrix3d& matrix)
{
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = matrix;
    return DoubleArray({3, 3}, rows.data());
}

DoubleArray arrayOf(const Eigen::Isometry3d& pose)
{
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = pose.matrix();
    return DoubleArray({4, 4}, rows.data());
}
}  // namespace bullet_ccd::python

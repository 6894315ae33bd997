// The compiled half of the Python package bullet_ccd. What users see is documented in
// python/bullet_ccd/_core.pyi, which tests compare with what is here.
#include "python/src/module.h"

#include <string>

namespace bullet_ccd::python
{
namespace
{
namespace py = pybind11;

/// What pickle and copy ask of an object. Their own ways would make objects without a C++ half, or
/// end the interpreter (the old protocols of pickle).
py::tuple reduceOf(const py::object& self, int /*protocol*/)
{
    const py::object type = py::type::of(self);
    if (!py::hasattr(type, "__setstate__"))
    {
        throw py::type_error("a " + std::string(py::str(type.attr("__name__"))) +
                             " can neither be copied nor pickled: make it again");
    }
    return py::make_tuple(py::module_::import("copyreg").attr("__newobj__"),
                          py::make_tuple(type),
                          self.attr("__getstate__")());
}

/// Where a C++ half is asked for that was never made, pybind11 would make one of memory as it is.
void* refuseUnmade(std::size_t /*size*/)
{
    throw py::type_error("this object was never made: call its type, not __new__()");
}

void guardObjects(const py::module_& module)
{
    for (const auto& [name, member] : module.attr("__dict__").cast<py::dict>())
    {
        if (py::isinstance<py::type>(member))
        {
            const auto type = py::reinterpret_borrow<py::object>(member);
            py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(type.ptr()))->operator_new =
                &refuseUnmade;
            type.attr("__reduce_ex__") = py::cpp_function(&reduceOf, py::is_method(type));
            type.attr("__reduce__") = py::cpp_function(
                [](const py::object& self) { return reduceOf(self, 2); }, py::is_method(type));
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::python

PYBIND11_MODULE(_core, module)
{
    module.doc() = "The compiled half of bullet_ccd; import bullet_ccd instead.";
    module.attr("__version__") = BULLET_CCD_VERSION;
    bullet_ccd::python::addMeshes(module);
    bullet_ccd::python::addQueries(module);
    bullet_ccd::python::addConvexShapes(module);
    bullet_ccd::python::addRobots(module);
    bullet_ccd::python::addTrajectories(module);
    bullet_ccd::python::addDeformables(module);
    bullet_ccd::python::addModels(module);
    bullet_ccd::python::addGrasps(module);
    bullet_ccd::python::addTrials(module);
    bullet_ccd::python::addTasks(module);
    bullet_ccd::python::guardObjects(module);
}

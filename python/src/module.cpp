// The compiled half of the Python package bullet_ccd. What users see is documented in
// python/bullet_ccd/_core.pyi, which tests compare with what is here.
#include "python/src/module.h"

PYBIND11_MODULE(_core, module)
{
    module.doc() = "The compiled half of bullet_ccd; import bullet_ccd instead.";
    module.attr("__version__") = BULLET_CCD_VERSION;
    bullet_ccd::python::addMeshes(module);
    bullet_ccd::python::addQueries(module);
    bullet_ccd::python::addRobots(module);
    bullet_ccd::python::addGrasps(module);
}

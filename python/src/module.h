/// The parts of the module bullet_ccd._core, in the order in which they are added.
#pragma once

#include <pybind11/pybind11.h>

namespace bullet_ccd::python
{
void addMeshes(pybind11::module_& module);
void addQueries(pybind11::module_& module);
void addConvexShapes(pybind11::module_& module);
void addRobots(pybind11::module_& module);
void addTrajectories(pybind11::module_& module);
void addDeformables(pybind11::module_& module);
void addModels(pybind11::module_& module);
void addGrasps(pybind11::module_& module);
void addTrials(pybind11::module_& module);
void addTasks(pybind11::module_& module);
}  // namespace bullet_ccd::python

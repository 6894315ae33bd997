#include "bullet_ccd/bullet_ccd.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <pybind11/stl.h>
#include <tbb/parallel_for.h>
#include <thread>
#include <vector>

namespace bullet_ccd::python
{
namespace
{
/// A surface that one thread at a time moves or asks.
struct Surface
{
    DeformableSurface model;
    std::mutex mutex;
    double deviation = 0.0;
    bool selfCollision = true;
};

std::unique_ptr<Surface> makeSurface(const SsvTree& mesh,
                                     bool selfCollision,
                                     bool weldDuplicates,
                                     const std::vector<std::array<std::int32_t, 2>>& seams)
{
    const py::gil_scoped_release release;
    return std::unique_ptr<Surface>(new Surface{
        .model = DeformableSurface(mesh.mesh(), {.weldDuplicates = weldDuplicates, .seams = seams}),
        .mutex = {},
        .selfCollision = selfCollision});
}

void setStep(Surface& surface, const py::object& start, const py::object& end)
{
    const std::vector<Eigen::Vector3d> from = placesOf(start, "start");
    const std::vector<Eigen::Vector3d> to = placesOf(end, "end");
    const py::gil_scoped_release release;
    const std::lock_guard lock(surface.mutex);
    surface.model.setStep(from, to);
    surface.deviation = 0.0;
}

void setMotion(Surface& surface, const SsvTree& mesh, const py::object& motion)
{
    const RigidMotion moves = motionOf(motion, "motion");
    const py::gil_scoped_release release;
    const RigidStep step = rigidStep(mesh.mesh(), moves);
    const std::lock_guard lock(surface.mutex);
    surface.model.setStep(step.start, step.end);
    surface.deviation = step.deviation;
}

/// What contacts of surfaces and of single features have in common; one row for each.
py::dict answerArrays(const std::vector<DeformableContact>& contacts)
{
    const auto count = static_cast<py::ssize_t>(contacts.size());
    py::array_t<std::uint8_t> status(count);
    py::array_t<double> time(count);
    py::array_t<double> gap(count);
    py::array_t<double> normal({count, py::ssize_t{3}});
    py::array_t<double> weights({count, py::ssize_t{4}});
    for (py::ssize_t i = 0; i < count; ++i)
    {
        const DeformableContact& contact = contacts[static_cast<std::size_t>(i)];
        status.mutable_at(i) = static_cast<std::uint8_t>(contact.status);
        time.mutable_at(i) = contact.time;
        gap.mutable_at(i) = contact.gap;
        std::copy_n(contact.normal.data(), 3, normal.mutable_data(i, 0));
        std::copy_n(contact.weights.data(), 4, weights.mutable_data(i, 0));
    }
    py::dict arrays;
    arrays["status"] = status;
    arrays["time"] = time;
    arrays["gap"] = gap;
    arrays["normal"] = normal;
    arrays["weights"] = weights;
    return arrays;
}

py::dict contactArrays(const std::vector<DeformableContact>& contacts)
{
    const auto count = static_cast<py::ssize_t>(contacts.size());
    py::array_t<bool> isEdgeEdge(count);
    py::array_t<std::int32_t> bodyA(count);
    py::array_t<std::int32_t> bodyB(count);
    py::array_t<std::int32_t> vertices({count, py::ssize_t{4}});
    for (py::ssize_t i = 0; i < count; ++i)
    {
        const DeformableContact& contact = contacts[static_cast<std::size_t>(i)];
        isEdgeEdge.mutable_at(i) = contact.kind == ElementaryKind::EdgeEdge;
        bodyA.mutable_at(i) = contact.bodyA;
        bodyB.mutable_at(i) = contact.bodyB;
        std::copy_n(contact.vertices.data(), 4, vertices.mutable_data(i, 0));
    }
    py::dict arrays = answerArrays(contacts);
    arrays["is_edge_edge"] = isEdgeEdge;
    arrays["body_a"] = bodyA;
    arrays["body_b"] = bodyB;
    arrays["vertices"] = vertices;
    return arrays;
}

/// Holds each surface once, in an order that all threads keep.
std::vector<std::unique_lock<std::mutex>> lockAll(std::vector<Surface*> surfaces)
{
    std::ranges::sort(surfaces, std::less<>());
    surfaces.erase(std::unique(surfaces.begin(), surfaces.end()), surfaces.end());
    std::vector<std::unique_lock<std::mutex>> locks;
    for (Surface* surface : surfaces)
    {
        locks.emplace_back(surface->mutex);
    }
    return locks;
}

py::tuple deformableContactsOf(const std::vector<std::shared_ptr<Surface>>& surfaces,
                               bool firstOnly,
                               double tolerance,
                               double minimumSeparation,
                               ElementaryDepth depth,
                               std::int64_t maxIterations,
                               double timeLimit,
                               int jobs)
{
    std::vector<Surface*> all;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
    {
        if (surfaces[i] == nullptr)
        {
            throw py::type_error("surfaces[" + std::to_string(i) +
                                 "]: expected a DeformableSurface, but got None");
        }
        all.push_back(surfaces[i].get());
    }
    if (jobs < 0)
    {
        throw py::value_error("jobs: " + std::to_string(jobs) +
                              " is no number of threads: give 0 for one per core, or more");
    }
    DeformableOptions options{
        .tolerance = tolerance,
        .minimumSeparation = minimumSeparation,
        .depth = depth,
        .maxIterations = maxIterations,
        .threads =
            jobs > 0 ? jobs : static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
        .stop = stopAfter(timeLimit)};
    DeformableResult result;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        options.stop.isCancelled = &stop;
        const auto locks = lockAll(all);
        std::vector<DeformableBody> bodies;
        for (const Surface* surface : all)
        {
            bodies.push_back({.surface = &surface->model,
                              .selfCollision = surface->selfCollision,
                              .deviation = surface->deviation});
        }
        DeformableWorkspace scratch;
        result = firstOnly ? deformableToi(bodies, options, scratch)
                           : deformableContacts(bodies, options, scratch);
    };
    runInterruptibly(work);
    return py::make_tuple(result.status, result.time, contactArrays(result.contacts));
}

FourPoints fourPoints(const DoubleArray& array, py::ssize_t row)
{
    FourPoints points;
    std::copy_n(array.data(row), 12, points.data()->data());
    return points;
}

py::dict elementaryToiOf(const py::object& start,
                         const py::object& end,
                         bool edgeEdge,
                         double tolerance,
                         double minimumSeparation,
                         ElementaryDepth depth,
                         std::int64_t maxIterations)
{
    const DoubleArray from = doublesOf(start, "start");
    checkShape(from, {-1, 4, 3}, "start");
    const DoubleArray to = doublesOf(end, "end");
    checkShape(to, {from.shape(0), 4, 3}, "end");
    const py::ssize_t count = from.shape(0);
    const ElementaryOptions options{.tolerance = tolerance,
                                    .minimumSeparation = minimumSeparation,
                                    .depth = depth,
                                    .maxIterations = maxIterations};
    std::vector<DeformableContact> answers(static_cast<std::size_t>(count));
    const auto work = [&](const std::atomic<bool>& stop)
    {
        tbb::parallel_for(py::ssize_t{0},
                          count,
                          [&](py::ssize_t i)
                          {
                              if (stop)
                              {
                                  return;
                              }
                              const ElementaryPair pair{.kind = edgeEdge
                                                                    ? ElementaryKind::EdgeEdge
                                                                    : ElementaryKind::VertexFace,
                                                        .start = fourPoints(from, i),
                                                        .end = fourPoints(to, i)};
                              const ElementaryResult result = elementaryToi(pair, options);
                              answers[static_cast<std::size_t>(i)] = {.kind = pair.kind,
                                                                      .status = result.status,
                                                                      .time = result.time,
                                                                      .gap = result.gap,
                                                                      .normal = result.normal,
                                                                      .weights = result.weights};
                          });
    };
    runInterruptibly(work);
    py::dict arrays = answerArrays(answers);
    py::array_t<bool> isContact(count);
    for (py::ssize_t i = 0; i < count; ++i)
    {
        isContact.mutable_at(i) =
            bullet_ccd::isContact(answers[static_cast<std::size_t>(i)].status);
    }
    arrays["is_contact"] = isContact;
    return arrays;
}
}  // namespace

void addDeformables(py::module_& module)
{
    py::enum_<ElementaryDepth>(module, "Depth")
        .value("TOLERANCE", ElementaryDepth::Tolerance)
        .value("DECIDE", ElementaryDepth::Decide)
        .value("EXACT", ElementaryDepth::Exact);
    py::class_<Surface, std::shared_ptr<Surface>>(module, "DeformableSurface")
        .def(py::init(&makeSurface),
             py::arg("mesh").none(false),
             py::kw_only(),
             py::arg("self_collision") = true,
             py::arg("weld_duplicates") = false,
             py::arg("seams") = py::list())
        .def("set_step", &setStep, py::arg("start"), py::arg("end"))
        .def("set_motion", &setMotion, py::arg("mesh").none(false), py::arg("motion"));
    const DeformableOptions options;
    module.def("deformable_contacts",
               &deformableContactsOf,
               py::arg("surfaces"),
               py::kw_only(),
               py::arg("first_only") = false,
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("depth") = options.depth,
               py::arg("max_iterations") = options.maxIterations,
               py::arg("time_limit") = std::numeric_limits<double>::infinity(),
               py::arg("jobs") = 0);
    module.def("elementary_toi",
               &elementaryToiOf,
               py::arg("start"),
               py::arg("end"),
               py::kw_only(),
               py::arg("edge_edge") = false,
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("depth") = options.depth,
               py::arg("max_iterations") = options.maxIterationsOfPair);
}
}  // namespace bullet_ccd::python

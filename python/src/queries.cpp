#include "bullet_ccd/bullet_ccd.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"
#include "python/src/pickled.h"
#include "python/src/robots.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <pybind11/stl.h>
#include <span>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <utility>

namespace bullet_ccd::python
{
namespace
{
ToiWorkspace& workspace()
{
    thread_local ToiWorkspace work;
    return work;
}

RigidBody bodyOf(const SsvTree& tree, const RigidMotion& motion)
{
    return {.tree = &tree, .motion = motion};
}

ToiResult toi(const SsvTree& meshA,
              const SsvTree& meshB,
              const py::object& motionA,
              const py::object& motionB,
              double tolerance,
              double minimumSeparation,
              ToiStrategy strategy,
              std::int64_t maxIterations,
              bool anyWithin,
              double timeLimit)
{
    const RigidBody a = bodyOf(meshA, motionOf(motionA, "motion_a"));
    const RigidBody b = bodyOf(meshB, motionOf(motionB, "motion_b"));
    return askInterruptibly(stopAfter(timeLimit),
                            [&](const StopCondition& stop)
                            {
                                const ToiOptions options{.tolerance = tolerance,
                                                         .minimumSeparation = minimumSeparation,
                                                         .anyWithin = anyWithin,
                                                         .strategy = strategy,
                                                         .maxIterations = maxIterations,
                                                         .stop = stop};
                                return rigidToi(a, b, options, workspace());
                            });
}

/// Many motions: n of them, or one for all queries.
struct Motions
{
    std::vector<RigidMotion> items;

    [[nodiscard]] const RigidMotion& at(std::size_t i) const
    {
        return items[items.size() == 1 ? 0 : i];
    }
};

/// The number of queries that lists of this many entries make. A list of one counts for all.
std::size_t commonSize(std::initializer_list<std::pair<const char*, std::size_t>> sizes)
{
    std::pair<const char*, std::size_t> most = {"", 1};
    for (const auto& [name, size] : sizes)
    {
        if (size != 1 && most.second != 1 && size != most.second)
        {
            throw py::value_error(std::string(name) + ": " + std::to_string(size) +
                                  " entries, but " + most.first + " has " +
                                  std::to_string(most.second));
        }
        if (size != 1)
        {
            most = {name, size};
        }
    }
    return most.second;
}

template <class Make>
Motions motionsBetween(const py::object& start, const py::object& end, const Make& make)
{
    const std::vector<Eigen::Isometry3d> starts = posesOf(start, "start");
    const std::vector<Eigen::Isometry3d> ends = posesOf(end, "end");
    const std::size_t count = commonSize({{"start", starts.size()}, {"end", ends.size()}});
    Motions motions;
    for (std::size_t i = 0; i < count; ++i)
    {
        motions.items.push_back(
            make(starts[starts.size() == 1 ? 0 : i], ends[ends.size() == 1 ? 0 : i]));
    }
    return motions;
}

std::vector<Eigen::Vector3d> vectorsOf(const py::handle& value, const char* name)
{
    const DoubleArray array = doublesOf(value, name);
    if (array.ndim() == 1)
    {
        return {vectorOf(array, name)};
    }
    checkShape(array, {-1, 3}, name);
    std::vector<Eigen::Vector3d> vectors(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < vectors.size(); ++i)
    {
        vectors[i] = Eigen::Map<const Eigen::Vector3d>(array.data(static_cast<py::ssize_t>(i)));
    }
    return vectors;
}

Motions twists(const py::object& pose,
               const py::object& velocity,
               const py::object& angularVelocity)
{
    const std::vector<Eigen::Isometry3d> poses = posesOf(pose, "pose");
    const std::vector<Eigen::Vector3d> v = vectorsOf(velocity, "velocity");
    const std::vector<Eigen::Vector3d> w = vectorsOf(angularVelocity, "angular_velocity");
    const std::size_t count = commonSize(
        {{"pose", poses.size()}, {"velocity", v.size()}, {"angular_velocity", w.size()}});
    Motions motions;
    for (std::size_t i = 0; i < count; ++i)
    {
        motions.items.push_back({.X_W0 = poses[poses.size() == 1 ? 0 : i],
                                 .v_W = v[v.size() == 1 ? 0 : i],
                                 .w_W = w[w.size() == 1 ? 0 : i]});
    }
    return motions;
}

Motions motionsOf(const py::object& value, const char* name)
{
    if (py::isinstance<Motions>(value))
    {
        return value.cast<Motions>();
    }
    if (py::isinstance<RigidMotion>(value))
    {
        return {.items = {value.cast<RigidMotion>()}};
    }
    Motions motions;
    for (const Eigen::Isometry3d& pose : posesOf(value, name))
    {
        motions.items.push_back(restAt(pose));
    }
    return motions;
}

/// An array with a number of each result.
template <class T, class Result, class Part>
py::array_t<T> column(const std::vector<Result>& results, const Part& part)
{
    py::array_t<T> array(static_cast<py::ssize_t>(results.size()));
    for (std::size_t i = 0; i < results.size(); ++i)
    {
        array.mutable_at(static_cast<py::ssize_t>(i)) =
            static_cast<T>(std::invoke(part, results[i]));
    }
    return array;
}

/// The same of a vector: three numbers a row.
template <class Result>
py::array_t<double> rows(const std::vector<Result>& results, Eigen::Vector3d Result::*part)
{
    py::array_t<double> array({static_cast<py::ssize_t>(results.size()), py::ssize_t{3}});
    for (std::size_t i = 0; i < results.size(); ++i)
    {
        std::copy_n(
            (results[i].*part).data(), 3, array.mutable_data(static_cast<py::ssize_t>(i), 0));
    }
    return array;
}

/// One array per part that all kinds of results have.
template <class Result>
py::dict commonArraysOf(const std::vector<Result>& results)
{
    py::dict arrays;
    arrays["status"] = column<std::uint8_t>(results, &Result::status);
    arrays["time"] = column<double>(results, &Result::time);
    arrays["triangle_a"] = column<std::int32_t>(results, &Result::triangleA);
    arrays["triangle_b"] = column<std::int32_t>(results, &Result::triangleB);
    arrays["point_a"] = rows(results, &Result::pointA);
    arrays["point_b"] = rows(results, &Result::pointB);
    arrays["normal"] = rows(results, &Result::normal);
    return arrays;
}

/// Answers many queries on all cores.
/// @param ask  of the two bodies, and when to stop
template <class Result, class Ask>
std::vector<Result> answerAll(const SsvTree& meshA,
                              const SsvTree& meshB,
                              const py::object& motionsA,
                              const py::object& motionsB,
                              double timeLimit,
                              const Ask& ask)
{
    const Motions a = motionsOf(motionsA, "motions_a");
    const Motions b = motionsOf(motionsB, "motions_b");
    const std::size_t count =
        commonSize({{"motions_a", a.items.size()}, {"motions_b", b.items.size()}});
    StopCondition condition = stopAfter(timeLimit);
    std::vector<Result> results(count);
    const auto work = [&](const std::atomic<bool>& stop)
    {
        condition.isCancelled = &stop;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count),
                          [&](const tbb::blocked_range<std::size_t>& range)
                          {
                              for (std::size_t i = range.begin(); i != range.end() && !stop; ++i)
                              {
                                  results[i] = ask(
                                      bodyOf(meshA, a.at(i)), bodyOf(meshB, b.at(i)), condition);
                              }
                          });
    };
    runInterruptibly(work);
    return results;
}

py::dict toiBatch(const SsvTree& meshA,
                  const SsvTree& meshB,
                  const py::object& motionsA,
                  const py::object& motionsB,
                  double tolerance,
                  double minimumSeparation,
                  ToiStrategy strategy,
                  std::int64_t maxIterations,
                  bool anyWithin,
                  double timeLimit)
{
    const auto ask = [&](const RigidBody& a, const RigidBody& b, const StopCondition& stop)
    {
        const ToiOptions options{.tolerance = tolerance,
                                 .minimumSeparation = minimumSeparation,
                                 .anyWithin = anyWithin,
                                 .strategy = strategy,
                                 .maxIterations = maxIterations,
                                 .stop = stop};
        return rigidToi(a, b, options, workspace());
    };
    const auto results = answerAll<ToiResult>(meshA, meshB, motionsA, motionsB, timeLimit, ask);
    py::dict arrays = commonArraysOf(results);
    arrays["is_contact"] =
        column<bool>(results, [](const ToiResult& each) { return isContact(each.status); });
    arrays["gap"] = column<double>(results, &ToiResult::gap);
    return arrays;
}

/// A distance at fixed poses, in W.
struct Distance
{
    double distance = 0.0;
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    Eigen::Vector3d pointA;
    Eigen::Vector3d pointB;
};

Distance distance(const SsvTree& meshA,
                  const SsvTree& meshB,
                  const py::object& poseA,
                  const py::object& poseB,
                  double upperBound,
                  double timeLimit)
{
    const Eigen::Isometry3d X_WA = poseOf(poseA, "pose_a");
    const Eigen::Isometry3d X_WB = poseOf(poseB, "pose_b");
    const TrianglePair pair = answerWithin(
        timeLimit,
        [&](const StopCondition& stop)
        {
            const DistanceBounds bounds =
                distanceBounds(meshA, meshB, X_WB.inverse() * X_WA, upperBound, stop);
            if (!bounds.isComplete)
            {
                throw QueryStopped("distance: stopped before the nearest pair was known");
            }
            return bounds.nearest;
        });
    return {.distance = pair.distance,
            .triangleA = pair.triangleA,
            .triangleB = pair.triangleB,
            .pointA = X_WB * pair.pointA,
            .pointB = X_WB * pair.pointB};
}

std::vector<Contact> contacts(const SsvTree& meshA,
                              const SsvTree& meshB,
                              const py::object& poseA,
                              const py::object& poseB,
                              double threshold,
                              double timeLimit)
{
    const Eigen::Isometry3d X_WA = poseOf(poseA, "pose_a");
    const Eigen::Isometry3d X_WB = poseOf(poseB, "pose_b");
    if (!(threshold > 0.0 && std::isfinite(threshold)))
    {
        throw py::value_error("threshold: " + std::to_string(threshold) +
                              " is no distance above 0 m");
    }
    return answerWithin(timeLimit,
                        [&](const StopCondition& stop)
                        { return findContacts(meshA, X_WA, meshB, X_WB, threshold, stop); });
}

/// The first contact among many bodies, which are named by their indices.
struct FirstContact : ToiResult
{
    std::int32_t bodyA = kNone;
    std::int32_t bodyB = kNone;
};

FirstContact firstContactOf(
    const Obstacles& bodies,
    const std::optional<std::vector<std::pair<std::int32_t, std::int32_t>>>& pairs,
    double tolerance,
    double minimumSeparation,
    std::int64_t maxIterations,
    double timeLimit)
{
    std::vector<MovingBody> moving;
    for (const RigidBody& body : bodiesOf(bodies, "bodies"))
    {
        moving.push_back(movingBody(body));
    }
    const auto count = static_cast<std::int32_t>(moving.size());
    std::vector<BodyPair> tested;
    if (pairs)
    {
        for (const auto& [a, b] : *pairs)
        {
            if (a < 0 || b < 0 || a >= count || b >= count || a == b)
            {
                throw py::value_error("pairs: (" + std::to_string(a) + ", " + std::to_string(b) +
                                      ") does not name two of the " + std::to_string(count) +
                                      " bodies");
            }
            tested.push_back({.bodyA = a, .bodyB = b});
        }
    }
    else
    {
        for (std::int32_t a = 0; a < count; ++a)
        {
            for (std::int32_t b = a + 1; b < count; ++b)
            {
                tested.push_back({.bodyA = a, .bodyB = b});
            }
        }
    }
    const FirstContactResult result =
        askInterruptibly(stopAfter(timeLimit),
                         [&](const StopCondition& stop)
                         {
                             const ToiOptions options{.tolerance = tolerance,
                                                      .minimumSeparation = minimumSeparation,
                                                      .maxIterations = maxIterations,
                                                      .stop = stop};
                             return firstContact(moving, tested, options, workspace());
                         });
    FirstContact first{result};
    if (result.pair != kNone)
    {
        first.bodyA = tested[static_cast<std::size_t>(result.pair)].bodyA;
        first.bodyB = tested[static_cast<std::size_t>(result.pair)].bodyB;
    }
    return first;
}

LeastDistanceResult leastDistanceOf(const SsvTree& meshA,
                                    const SsvTree& meshB,
                                    const py::object& motionA,
                                    const py::object& motionB,
                                    double tolerance,
                                    double enough,
                                    double timeLimit)
{
    const RigidBody a = bodyOf(meshA, motionOf(motionA, "motion_a"));
    const RigidBody b = bodyOf(meshB, motionOf(motionB, "motion_b"));
    return askInterruptibly(
        stopAfter(timeLimit),
        [&](const StopCondition& stop)
        {
            return leastDistance(
                a, b, {.tolerance = tolerance, .enough = enough, .stop = stop}, workspace());
        });
}

py::dict leastDistanceBatch(const SsvTree& meshA,
                            const SsvTree& meshB,
                            const py::object& motionsA,
                            const py::object& motionsB,
                            double tolerance,
                            double enough,
                            double timeLimit)
{
    const auto ask = [&](const RigidBody& a, const RigidBody& b, const StopCondition& stop)
    {
        return leastDistance(
            a, b, {.tolerance = tolerance, .enough = enough, .stop = stop}, workspace());
    };
    const auto results =
        answerAll<LeastDistanceResult>(meshA, meshB, motionsA, motionsB, timeLimit, ask);
    py::dict arrays = commonArraysOf(results);
    arrays["distance"] = column<double>(results, &LeastDistanceResult::distance);
    arrays["found"] = column<double>(results, &LeastDistanceResult::found);
    return arrays;
}

void addQueryResults(py::module_& module)
{
    py::class_<LeastDistanceResult>(module, "LeastDistance")
        .def(pickled<LeastDistanceResult,
                     &LeastDistanceResult::status,
                     &LeastDistanceResult::distance,
                     &LeastDistanceResult::found,
                     &LeastDistanceResult::time,
                     &LeastDistanceResult::triangleA,
                     &LeastDistanceResult::triangleB,
                     &LeastDistanceResult::pointA,
                     &LeastDistanceResult::pointB,
                     &LeastDistanceResult::normal>())
        .def_readonly("status", &LeastDistanceResult::status)
        .def_readonly("distance", &LeastDistanceResult::distance)
        .def_readonly("found", &LeastDistanceResult::found)
        .def_readonly("time", &LeastDistanceResult::time)
        .def_readonly("triangle_a", &LeastDistanceResult::triangleA)
        .def_readonly("triangle_b", &LeastDistanceResult::triangleB)
        .def_property_readonly(
            "point_a", [](const LeastDistanceResult& least) { return arrayOf(least.pointA); })
        .def_property_readonly(
            "point_b", [](const LeastDistanceResult& least) { return arrayOf(least.pointB); })
        .def_property_readonly(
            "normal", [](const LeastDistanceResult& least) { return arrayOf(least.normal); });
    py::enum_<ToiStatus>(module, "Status")
        .value("SEPARATED", ToiStatus::Separated)
        .value("HIT", ToiStatus::Hit)
        .value("OVERLAPPING", ToiStatus::Overlapping)
        .value("TOUCHING_LEAVING", ToiStatus::TouchingLeaving)
        .value("TOUCHING_PRESSING", ToiStatus::TouchingPressing)
        .value("ITERATION_LIMIT", ToiStatus::IterationLimit)
        .value("STOPPED", ToiStatus::Stopped);
    py::enum_<ToiStrategy>(module, "Strategy")
        .value("BEST_FIRST", ToiStrategy::BestFirst)
        .value("INTERVAL", ToiStrategy::Interval)
        .value("C2A", ToiStrategy::C2A);
    py::class_<ToiResult>(module, "ToiResult")
        .def(pickled<ToiResult,
                     &ToiResult::status,
                     &ToiResult::time,
                     &ToiResult::gap,
                     &ToiResult::triangleA,
                     &ToiResult::triangleB,
                     &ToiResult::pointA,
                     &ToiResult::pointB,
                     &ToiResult::normal,
                     &ToiResult::counters>())
        .def_readonly("status", &ToiResult::status)
        .def_property_readonly("is_contact",
                               [](const ToiResult& result) { return isContact(result.status); })
        .def_readonly("time", &ToiResult::time)
        .def_readonly("gap", &ToiResult::gap)
        .def_readonly("triangle_a", &ToiResult::triangleA)
        .def_readonly("triangle_b", &ToiResult::triangleB)
        .def_property_readonly("point_a",
                               [](const ToiResult& result) { return arrayOf(result.pointA); })
        .def_property_readonly("point_b",
                               [](const ToiResult& result) { return arrayOf(result.pointB); })
        .def_property_readonly("normal",
                               [](const ToiResult& result) { return arrayOf(result.normal); })
        .def_property_readonly("node_pairs",
                               [](const ToiResult& result) { return result.counters.nodePairs; })
        .def_property_readonly(
            "triangle_pairs", [](const ToiResult& result) { return result.counters.trianglePairs; })
        .def("__repr__",
             [](const ToiResult& result)
             {
                 return py::str("<bullet_ccd.ToiResult {}, time {}, gap {}>")
                     .format(py::cast(result.status).attr("name"), result.time, result.gap);
             });
    py::class_<Distance>(module, "Distance")
        .def(pickled<Distance,
                     &Distance::distance,
                     &Distance::triangleA,
                     &Distance::triangleB,
                     &Distance::pointA,
                     &Distance::pointB>())
        .def_readonly("distance", &Distance::distance)
        .def_readonly("triangle_a", &Distance::triangleA)
        .def_readonly("triangle_b", &Distance::triangleB)
        .def_property_readonly("point_a", [](const Distance& pair) { return arrayOf(pair.pointA); })
        .def_property_readonly("point_b",
                               [](const Distance& pair) { return arrayOf(pair.pointB); });
    py::class_<Contact>(module, "Contact")
        .def(pickled<Contact,
                     &Contact::gap,
                     &Contact::triangleA,
                     &Contact::triangleB,
                     &Contact::pointA,
                     &Contact::pointB,
                     &Contact::normal>())
        .def_readonly("gap", &Contact::gap)
        .def_readonly("triangle_a", &Contact::triangleA)
        .def_readonly("triangle_b", &Contact::triangleB)
        .def_property_readonly("point_a",
                               [](const Contact& contact) { return arrayOf(contact.pointA); })
        .def_property_readonly("point_b",
                               [](const Contact& contact) { return arrayOf(contact.pointB); })
        .def_property_readonly("normal",
                               [](const Contact& contact) { return arrayOf(contact.normal); });
}

void addMotions(py::module_& module)
{
    py::class_<Motions>(module, "Motions")
        .def(pickled<Motions, &Motions::items>())
        .def(py::init([](std::vector<RigidMotion> items) { return Motions{std::move(items)}; }),
             py::arg("motions"))
        .def_static(
            "between",
            [](const py::object& start, const py::object& end)
            { return motionsBetween(start, end, motionBetween); },
            py::arg("start"),
            py::arg("end"))
        .def_static(
            "screw",
            [](const py::object& start, const py::object& end)
            { return motionsBetween(start, end, screwBetween); },
            py::arg("start"),
            py::arg("end"))
        .def_static("twists",
                    &twists,
                    py::arg("pose"),
                    py::kw_only(),
                    py::arg("velocity") = py::make_tuple(0.0, 0.0, 0.0),
                    py::arg("angular_velocity") = py::make_tuple(0.0, 0.0, 0.0))
        .def("__len__", [](const Motions& motions) { return motions.items.size(); })
        .def("__getitem__",
             [](const Motions& motions, py::ssize_t i)
             {
                 const auto count = static_cast<py::ssize_t>(motions.items.size());
                 i = i < 0 ? i + count : i;
                 if (i < 0 || i >= count)
                 {
                     throw py::index_error("motion index out of range");
                 }
                 return motions.items[static_cast<std::size_t>(i)];
             });
}
}  // namespace

void addQueries(py::module_& module)
{
    addQueryResults(module);
    addMotions(module);
    const ToiOptions options;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    module.attr("DEFAULT_TOLERANCE") = kDefaultTolerance;
    const auto addToi =
        [&](const char* name, const auto& query, const char* motionA, const char* motionB)
    {
        module.def(name,
                   query,
                   py::arg("mesh_a").none(false),
                   py::arg("mesh_b").none(false),
                   py::arg(motionA) = py::none(),
                   py::arg(motionB) = py::none(),
                   py::kw_only(),
                   py::arg("tolerance") = options.tolerance,
                   py::arg("minimum_separation") = options.minimumSeparation,
                   py::arg("strategy") = options.strategy,
                   py::arg("max_iterations") = options.maxIterations,
                   py::arg("any_within") = options.anyWithin,
                   py::arg("time_limit") = kInfinity);
    };
    addToi("toi", &toi, "motion_a", "motion_b");
    addToi("toi_batch", &toiBatch, "motions_a", "motions_b");
    const auto addAtPoses = [&](const char* name, const auto& query, const auto& last)
    {
        module.def(name,
                   query,
                   py::arg("mesh_a").none(false),
                   py::arg("mesh_b").none(false),
                   py::arg("pose_a") = py::none(),
                   py::arg("pose_b") = py::none(),
                   py::kw_only(),
                   last,
                   py::arg("time_limit") = kInfinity);
    };
    addAtPoses("distance", &distance, py::arg("upper_bound") = kInfinity);
    const auto addLeast =
        [&](const char* name, const auto& query, const char* motionA, const char* motionB)
    {
        module.def(name,
                   query,
                   py::arg("mesh_a").none(false),
                   py::arg("mesh_b").none(false),
                   py::arg(motionA) = py::none(),
                   py::arg(motionB) = py::none(),
                   py::kw_only(),
                   py::arg("tolerance") = options.tolerance,
                   py::arg("enough") = kInfinity,
                   py::arg("time_limit") = kInfinity);
    };
    addLeast("least_distance", &leastDistanceOf, "motion_a", "motion_b");
    addLeast("least_distance_batch", &leastDistanceBatch, "motions_a", "motions_b");
    addAtPoses("contacts", &contacts, py::arg("threshold"));
    py::class_<FirstContact, ToiResult>(module, "FirstContact")
        .def(pickled<FirstContact,
                     &FirstContact::status,
                     &FirstContact::time,
                     &FirstContact::gap,
                     &FirstContact::triangleA,
                     &FirstContact::triangleB,
                     &FirstContact::pointA,
                     &FirstContact::pointB,
                     &FirstContact::normal,
                     &FirstContact::counters,
                     &FirstContact::bodyA,
                     &FirstContact::bodyB>())
        .def_readonly("body_a", &FirstContact::bodyA)
        .def_readonly("body_b", &FirstContact::bodyB);
    module.def("first_contact",
               &firstContactOf,
               py::arg("bodies"),
               py::arg("pairs") = py::none(),
               py::kw_only(),
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("max_iterations") = options.maxIterations,
               py::arg("time_limit") = kInfinity);
}
}  // namespace bullet_ccd::python

#include "grasp/sim/settle.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/quality/object_mass.h"
#include "grasp/sim/trial_world.h"
#include "grasp/squeeze/squeeze.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kRate = 240.0;               // steps per second
constexpr double kSkin = 1e-3;                // [m]
constexpr double kLook = 0.5;                 // how often poses are compared [s]
constexpr double kRest = 1e-3;                // that nothing moves by in that time [m]
constexpr int kTries = 300;                   // of places with room

double uniform(std::mt19937_64& random, double low, double high)
{
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1.0p-53;
}

/// Where an object is let go: its circle about z.
struct Place
{
    Eigen::Vector2d center;
    double radius;
    double top;
};

std::vector<Eigen::Isometry3d> placesOf(std::span<const GraspObject* const> objects,
                                        const ClutterOptions& options)
{
    std::mt19937_64 random(options.seed);
    std::vector<Place> taken;
    std::vector<Eigen::Isometry3d> X_WO;
    for (const GraspObject* object : objects)
    {
        const Eigen::AlignedBox3d box = bounds(object->tree.mesh());
        Place best{.center = {}, .radius = 0.5 * box.sizes().head<2>().norm(), .top = 0.0};
        double lowest = std::numeric_limits<double>::infinity();
        for (int i = 0; i < kTries && lowest > options.height; ++i)
        {
            const Eigen::Vector2d center(uniform(random, options.from.x(), options.to.x()),
                                         uniform(random, options.from.y(), options.to.y()));
            double height = options.height;
            for (const Place& other : taken)
            {
                const bool isNear =
                    (other.center - center).norm() < other.radius + best.radius + options.distance;
                height = isNear ? std::max(height, other.top) : height;
            }
            if (height < lowest)
            {
                lowest = height;
                best.center = center;
            }
        }
        const double bottom = lowest + 2.0 * kSkin;
        best.top = bottom + box.sizes().z();
        taken.push_back(best);
        Eigen::Isometry3d X(Eigen::Translation3d(best.center.x(), best.center.y(), bottom));
        X.rotate(Eigen::AngleAxisd(uniform(random, 0.0, 2.0 * std::numbers::pi),
                                   Eigen::Vector3d::UnitZ()));
        X.translate(Eigen::Vector3d(-box.center().x(), -box.center().y(), -box.min().z()));
        X_WO.push_back(X);
    }
    return X_WO;
}
}  // namespace

SettledObjects settle(std::span<const GraspObject* const> objects,
                      std::span<const RigidBody> obstacles,
                      const ClutterOptions& options)
{
    require(!objects.empty(), "settle: there are no objects");
    require((options.to - options.from).minCoeff() > 0.0 && std::isfinite(options.height),
            "settle: the rectangle has no area: give two opposite corners");
    // The world of trials: the first object is the one that hands would hold; the hand is nothing.
    HandModel nothing;
    nothing.robot.tree.links.push_back({.name = "nothing"});
    nothing.linkTrees.push_back(nullptr);
    const std::vector<Eigen::Isometry3d> start = placesOf(objects, options);
    const Eigen::Isometry3d X_OW = start.front().inverse();
    TrialWorld world(nothing,
                     *objects.front(),
                     {.mass = massOf(*objects.front()).mass,
                      .friction = options.friction,
                      .margin = 0.5 * kSkin,
                      .stiffness = kSkinStiffness,
                      .spinDamping = options.spinDamping},
                     X_OW,
                     {0.0});
    for (std::size_t i = 1; i < objects.size(); ++i)
    {
        world.addBody(objects[i]->tree, X_OW * start[i], massOf(*objects[i]).mass);
    }
    for (const RigidBody& obstacle : obstacles)
    {
        world.addBody(*obstacle.tree, X_OW * obstacle.motion.X_W0, 0.0);
    }
    const auto poses = [&]
    {
        std::vector<Eigen::Isometry3d> X_WO{start.front() * world.objectPose()};
        for (std::size_t i = 1; i < objects.size(); ++i)
        {
            X_WO.push_back(start.front() * world.bodyPose(i - 1));
        }
        return X_WO;
    };
    SettledObjects settled{.X_WO = start};
    while (!settled.atRest && settled.seconds < options.longest)
    {
        for (int i = 0; i < kLook * kRate; ++i)
        {
            world.step(1.0 / kRate,
                       X_OW.linear() * Eigen::Vector3d(0.0, 0.0, -kStandardGravity),
                       Eigen::Vector3d::Zero());
        }
        settled.seconds += kLook;
        const std::vector<Eigen::Isometry3d> now = poses();
        settled.atRest = true;
        for (std::size_t i = 0; i < now.size(); ++i)
        {
            const Eigen::Isometry3d way = settled.X_WO[i].inverse() * now[i];
            const double moved = way.translation().norm() +
                                 objects[i]->radius * Eigen::AngleAxisd(way.linear()).angle();
            settled.atRest = settled.atRest && moved < kRest;
        }
        settled.X_WO = now;
    }
    return settled;
}
}  // namespace bullet_ccd::grasp

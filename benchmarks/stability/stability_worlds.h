/// Hands of a few links in Bullet worlds that hold, squeeze, pinch and hit: what a long or hard
/// grasp asks of a simulation.
#pragma once

#include "benchmarks/reference/audit/mesh_audit.h"
#include "benchmarks/reference/bullet/scene.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A world in which something is held or hit, and what is to be watched in it.
struct Trial
{
    explicit Trial(reference::Kind kind) : scene(kind) {}

    reference::Scene scene;
    btRigidBody* object = nullptr;  ///< what is held; null: nothing is
    /// Sets motors and gravity for the step that begins at `time` [s].
    std::function<void(double time, double timeStep)> control = [](double, double) {};
    /// True once something has passed through something else.
    std::function<bool()> isThrough = [] { return false; };
    /// Every body as a mesh; pairs that a joint connects are ignored.
    reference::AuditScene audit;
    std::vector<const btCollisionObject*> audited;  ///< one entry a body of `audit`
    std::vector<std::unique_ptr<const reference::AuditMesh>> meshes;
    double readyAt = 0.0;  ///< grip and weight are there, and rest is expected [s]
};

/// An experiment: the same for all kinds of worlds.
struct StabilityWorld
{
    std::string name;
    std::string group;  ///< "hold", "squeeze", "thin" or "light"
    std::string title;
    double seconds = 1.0;    ///< of simulated time
    bool isPassive = false;  ///< no motors: energy can only fall
    /// Those that can differ: where nothing is fast and shapes are Bullet's own, ours and both ways
    /// into a world are the same.
    std::vector<reference::Kind> kinds = {reference::Kind::Stock,
                                          reference::Kind::StockCcd,
                                          reference::Kind::Action,
                                          reference::Kind::World};
    std::function<std::unique_ptr<Trial>(reference::Kind)> make;
};

/// All of them. Shapes are Bullet's own (boxes, a cylinder) or triangle meshes: GImpact in stock
/// worlds, btCcdMeshShape in ours.
[[nodiscard]] const std::vector<StabilityWorld>& stabilityWorlds();
}  // namespace bullet_ccd::benchmarks

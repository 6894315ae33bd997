#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <cstdio>

int main()  // when does a tumbling cube hit a thin plate?
{
    using namespace bullet_ccd;
    const SsvTree cube = buildSsvTree(makeBox({0.05, 0.05, 0.05}));
    const SsvTree plate = buildSsvTree(makeBox({1.0, 1.0, 0.0005}));
    RigidBody falling{.tree = &cube};  // its motion covers t in [0, 1]
    falling.motion.X_W0.translation().z() = 1.0;
    falling.motion.v_W = {0.5, 0.0, -30.0};  // metres a step: far beyond the plate
    falling.motion.w_W = {0.0, 12.0, 3.0};   // radians a step: two turns

    ToiWorkspace work;
    const ToiResult hit = rigidToi(falling, {.tree = &plate}, {.tolerance = 1e-6}, work);
    std::printf("contact at t = %.9f, gap %.1e m\n", hit.time, hit.gap);
    return hit.status == ToiStatus::Hit ? 0 : 1;
}

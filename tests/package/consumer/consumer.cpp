// The umbrella headers of all components.
#include <bullet_ccd/bullet.h>
#include <bullet_ccd/bullet_ccd.h>
#include <bullet_ccd/io.h>

#include <grasp/grasp.h>
#include <grasp/sim/hand_simulation.h>
#include <memory>

int main()
{
    using namespace bullet_ccd;
    const auto ball = std::make_shared<const SsvTree>(buildSsvTree(makeSphere(0.1, 2)));
    RigidBody moving{.tree = ball.get()};
    moving.motion.X_W0.translation().x() = -1.0;
    moving.motion.v_W.x() = 2.0;
    ToiWorkspace work;
    const ToiResult hit = rigidToi(moving, {.tree = ball.get()}, {.tolerance = 1e-6}, work);
    const btCcdMeshShape shape(ball);
    const grasp::MakeCloseHand engine = grasp::simulatedClosing();
    return hit.status == ToiStatus::Hit && shape.isConcave() && engine ? 0 : 1;
}

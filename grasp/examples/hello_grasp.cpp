#include <bullet_ccd/io/mesh_file.h>

#include <cstdio>
#include <grasp/closing/closing.h>
#include <grasp/hand/hand_model.h>
#include <grasp/planner/grasp_planner.h>

int main(int count, char** files)  // hello_grasp HAND.urdf OBJECT.obj: the grasps of 20 candidates
{
    using namespace bullet_ccd::grasp;
    const HandModel hand = loadHand(count > 2 ? files[1] : "hand.urdf");
    const GraspObject object = makeGraspObject(
        "object", bullet_ccd::loadMeshFile(count > 2 ? files[2] : "object.obj").mesh);
    bool found = false;
    for (const Grasp& grasp :
         planGrasps(hand, object, {.candidates = 20}, [] { return kinematicClosing(); }))
    {
        if (grasp.quality.forceClosure)  // best first: pose, joints and contacts are in the record
        {
            std::printf(
                "epsilon %.4f, %zu contacts\n", grasp.quality.epsilon, grasp.contacts.size());
            found = true;
        }
    }
    return found ? 0 : 1;
}

#include "grasp/grasp_types.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace bullet_ccd::grasp
{
GraspObject makeGraspObject(std::string name, TriangleMesh mesh)
{
    checkMesh(mesh, name);
    const Eigen::Vector3d center = massProperties(mesh).center;
    const bool watertight = isWatertight(mesh);
    double radius = 0.0;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        radius = std::max(radius, (vertex - center).norm());
    }
    return {.name = std::move(name),
            .tree = buildSsvTree(std::move(mesh)),
            .centerOfMass = center,
            .radius = radius,
            .watertight = watertight};
}

double lowestHeight(const SsvTree& tree, const Eigen::Isometry3d& X_W, const Eigen::Vector3d& up)
{
    double lowest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& vertex : tree.mesh().vertices)
    {
        lowest = std::min(lowest, up.dot(X_W * vertex));
    }
    return lowest;
}

const char* epsilonClass(double epsilon)
{
    constexpr double kFair = 0.05;
    constexpr double kFirm = 0.2;
    return epsilon >= kFirm ? "firm" : epsilon >= kFair ? "fair" : "marginal";
}

const char* toString(RejectReason reason)
{
    switch (reason)
    {
        case RejectReason::None:
            return "none";
        case RejectReason::OverlapAtStart:
            return "overlap at start";
        case RejectReason::SelfOverlap:
            return "self overlap";
        case RejectReason::NoApproachHit:
            return "no approach hit";
        case RejectReason::TooFewContacts:
            return "too few contacts";
        case RejectReason::NoForceClosure:
            return "no force closure";
        case RejectReason::Penetration:
            return "penetration";
        case RejectReason::IterationLimit:
            return "iteration limit";
        case RejectReason::Obstacle:
            return "obstacle in the way";
        case RejectReason::OutOfReach:
            return "out of reach";
    }
    BULLET_CCD_ASSERT(false);
    return "unknown";
}
}  // namespace bullet_ccd::grasp

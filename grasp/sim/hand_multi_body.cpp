#include "grasp/sim/hand_multi_body.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/math/check.h"
#include "grasp/hand/least_inertia.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace bullet_ccd::grasp
{
namespace
{
struct Inertial
{
    Eigen::Isometry3d X_LI = Eigen::Isometry3d::Identity();
    double mass = kLeastLinkMass;
    Eigen::Vector3d moments = Eigen::Vector3d::Constant(kLeastLinkMoment);
};

Inertial inertialOf(const Link& link)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(link.inertia);
    Inertial inertial;
    inertial.X_LI.linear() = principal.eigenvectors();
    if (inertial.X_LI.linear().determinant() < 0.0)
    {
        inertial.X_LI.linear().col(2) *= -1.0;
    }
    inertial.X_LI.translation() = link.centerOfMass;
    inertial.mass = std::max(link.mass, kLeastLinkMass);
    inertial.moments = principal.eigenvalues().cwiseMax(kLeastLinkMoment);
    return inertial;
}

/// The joint above `link` with both frames moved to the inertial ones.
void setUpLink(btMultiBody& body,
               const KinematicTree& tree,
               std::size_t index,
               const std::vector<Inertial>& inertials)
{
    const Link& link = tree.links[index];
    const Inertial& child = inertials[index];
    const Inertial& parent = inertials[static_cast<std::size_t>(link.parent)];
    const Eigen::Isometry3d X_PI = parent.X_LI.inverse() * link.X_PL0;  // joint in the parent's I
    const Eigen::Matrix3d toChild = child.X_LI.linear().transpose();

    const int bulletLink = static_cast<int>(index) - 1;
    const int bulletParent = static_cast<int>(link.parent) - 1;
    const btQuaternion turn =
        btCcdToBullet(Eigen::Quaterniond(toChild * X_PI.linear().transpose()));
    const btVector3 pivot = btCcdToBullet(Eigen::Vector3d(X_PI.translation()));
    const btVector3 center = btCcdToBullet(Eigen::Vector3d(toChild * child.X_LI.translation()));
    const btVector3 axis = btCcdToBullet(Eigen::Vector3d(toChild * link.joint.axis));
    const btVector3 moments = btCcdToBullet(child.moments);
    switch (link.joint.type)
    {
        case JointType::Spherical:
            BULLET_CCD_ASSERT(false);  // no hand is read with one
            break;
        case JointType::Fixed:
            body.setupFixed(bulletLink, child.mass, moments, bulletParent, turn, pivot, center);
            break;
        case JointType::Revolute:
            body.setupRevolute(
                bulletLink, child.mass, moments, bulletParent, turn, axis, pivot, center);
            break;
        case JointType::Prismatic:
            body.setupPrismatic(
                bulletLink, child.mass, moments, bulletParent, turn, axis, pivot, center, false);
            break;
    }
    // Which links can touch is the hand's to say; setupFixed() excludes the parent on its own.
    body.getLink(bulletLink).m_flags = 0;
}
}  // namespace

HandMultiBody makeHandMultiBody(const HandModel& hand)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<Inertial> inertials;
    for (const Link& link : tree.links)
    {
        inertials.push_back(inertialOf(link));
    }

    HandMultiBody result;
    result.body = std::make_unique<btMultiBody>(static_cast<int>(tree.size()) - 1,
                                                inertials.front().mass,
                                                btCcdToBullet(inertials.front().moments),
                                                true,
                                                false);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        setUpLink(*result.body, tree, i, inertials);
    }
    result.body->finalizeMultiDof();

    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        result.X_LI.push_back(inertials[i].X_LI);
        result.meshes.emplace_back();
        result.shapes.emplace_back();
        result.colliders.emplace_back();
        if (hand.linkTrees[i] == nullptr)
        {
            continue;
        }
        // Not owned: the hierarchy belongs to the hand.
        const std::shared_ptr<const SsvTree> shared(hand.linkTrees[i], [](const SsvTree*) {});
        const int bulletLink = static_cast<int>(i) - 1;
        result.meshes[i] = std::make_unique<btCcdMeshShape>(shared);
        result.shapes[i] = std::make_unique<btCompoundShape>(false, 1);
        result.shapes[i]->addChildShape(btCcdToBullet(inertials[i].X_LI.inverse()),
                                        result.meshes[i].get());
        result.colliders[i] =
            std::make_unique<btMultiBodyLinkCollider>(result.body.get(), bulletLink);
        result.colliders[i]->setCollisionShape(result.shapes[i].get());
        if (bulletLink < 0)
        {
            result.body->setBaseCollider(result.colliders[i].get());
        }
        else
        {
            result.body->getLink(bulletLink).m_collider = result.colliders[i].get();
        }
    }
    return result;
}
}  // namespace bullet_ccd::grasp

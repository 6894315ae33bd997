#include "benchmarks/reference/bullet/mechanics.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

/// A rigid piece: a body or a link.
struct Piece
{
    double mass;
    Vector3d inertia;  // diagonal, in its own axes
    Eigen::Isometry3d X_WB;
    Vector3d v_W;
    Vector3d w_W;
};

Piece pieceOf(const btRigidBody& body)
{
    const btVector3 inverse = body.getInvInertiaDiagLocal();
    return {.mass = double(body.getMass()),
            .inertia = {1.0 / double(inverse.x()),
                        1.0 / double(inverse.y()),
                        1.0 / double(inverse.z())},
            .X_WB = btCcdToEigen(body.getWorldTransform()),
            .v_W = btCcdToEigen(body.getLinearVelocity()),
            .w_W = btCcdToEigen(body.getAngularVelocity())};
}

void appendPieces(btMultiBody& body, std::vector<Piece>& pieces)
{
    // Bullet gives the velocities of every link in its own axes, the base first.
    std::vector<btVector3> spins(std::size_t(body.getNumLinks()) + 1);
    std::vector<btVector3> velocities(spins.size());
    body.compTreeLinkVelocities(spins.data(), velocities.data());
    for (int link = body.hasFixedBase() ? 0 : -1; link < body.getNumLinks(); ++link)
    {
        const bool base = link < 0;
        const btMatrix3x3 axes = body.localFrameToWorld(link, btMatrix3x3::getIdentity());
        const btTransform pose(axes, body.localPosToWorld(link, btVector3(0, 0, 0)));
        pieces.push_back(
            {.mass = double(base ? body.getBaseMass() : body.getLinkMass(link)),
             .inertia = btCcdToEigen(base ? body.getBaseInertia() : body.getLinkInertia(link)),
             .X_WB = btCcdToEigen(pose),
             .v_W = btCcdToEigen(axes * velocities[std::size_t(link + 1)]),
             .w_W = btCcdToEigen(axes * spins[std::size_t(link + 1)])});
    }
}

std::vector<Piece> piecesOf(Scene& scene)
{
    std::vector<Piece> pieces;
    const btCollisionObjectArray& objects = scene.world().getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btRigidBody* body = btRigidBody::upcast(objects[i]);
        if (body != nullptr && !body->isStaticOrKinematicObject())
        {
            pieces.push_back(pieceOf(*body));
        }
        const auto* collider = btMultiBodyLinkCollider::upcast(objects[i]);
        if (collider != nullptr && collider->m_link < 0)
        {
            appendPieces(*collider->m_multiBody, pieces);
        }
    }
    return pieces;
}
}  // namespace

Momentum momentumOf(Scene& scene)
{
    Momentum sum;
    for (const Piece& piece : piecesOf(scene))
    {
        const Vector3d linear = piece.mass * piece.v_W;
        const Eigen::Matrix3d axes = piece.X_WB.linear();
        const Vector3d spin = axes * piece.inertia.asDiagonal() * axes.transpose() * piece.w_W;
        const Vector3d orbit = piece.X_WB.translation().cross(linear);
        sum.linear += linear;
        sum.angular += orbit + spin;
        sum.linearScale += linear.norm();
        sum.angularScale += orbit.norm() + spin.norm();
    }
    return sum;
}

double energyOf(Scene& scene, double gravity)
{
    double energy = 0.0;
    for (const Piece& piece : piecesOf(scene))
    {
        const Vector3d spin = piece.X_WB.linear().transpose() * piece.w_W;
        energy += 0.5 * piece.mass * piece.v_W.squaredNorm() +
                  0.5 * spin.dot(piece.inertia.cwiseProduct(spin)) +
                  piece.mass * gravity * piece.X_WB.translation().z();
    }
    return energy;
}
}  // namespace bullet_ccd::reference

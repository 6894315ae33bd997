#include "grasp/force/contact_models.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
void requireNumber(double value, const char* name)
{
    require(std::isfinite(value) && value >= 0.0,
            std::string("contact law: ") + name + " is " + std::to_string(value) +
                ": give a finite number from 0");
}

/// Largest force along each tangential coordinate where the normal part is 1; a model uses the
/// first.
Eigen::Vector3d frictionScales(const ContactLaw& law)
{
    return {law.friction, law.friction, law.friction * law.torsion};
}

/// The coordinates after the normal, in three numbers: 0 for what does not exist.
Eigen::Vector3d tangential(const LocalForce& v)
{
    Eigen::Vector3d rest = Eigen::Vector3d::Zero();
    for (Eigen::Index k = 1; k < v.size(); ++k)
    {
        rest[k - 1] = v[k];
    }
    return rest;
}

LocalForce unitNormalForce(const ContactLaw& law)
{
    return LocalForce::Unit(coordinateCount(law), 0);
}
}  // namespace

ContactLaw simplified(const ContactLaw& law)
{
    requireNumber(law.friction, "friction");
    requireNumber(law.torsion, "torsion");
    ContactLaw result = law;
    if (result.model == ContactModel::SoftFinger && law.torsion == 0.0)
    {
        result.model = ContactModel::HardFinger;
    }
    if (law.friction == 0.0)
    {
        result.model = ContactModel::Frictionless;
    }
    return result;
}

Eigen::Index coordinateCount(const ContactLaw& law)
{
    switch (law.model)
    {
        case ContactModel::Frictionless:
            return 1;
        case ContactModel::HardFinger:
            return 3;
        case ContactModel::SoftFinger:
            return 4;
    }
    return 0;
}

ContactBasis contactBasis(const GraspContact& contact,
                          const ContactLaw& law,
                          const Eigen::Vector3d& reference,
                          double torqueScale)
{
    const Eigen::Vector3d tangentA = contact.normal.unitOrthogonal();
    const std::array<Eigen::Vector3d, 3> axes = {
        contact.normal, tangentA, contact.normal.cross(tangentA)};
    const Eigen::Vector3d arm = (contact.point - reference) / torqueScale;
    ContactBasis basis(6, coordinateCount(law));
    for (Eigen::Index k = 0; k < std::min<Eigen::Index>(3, basis.cols()); ++k)
    {
        const Eigen::Vector3d& axis = axes[static_cast<std::size_t>(k)];
        basis.col(k) << axis, arm.cross(axis);
    }
    if (law.model == ContactModel::SoftFinger)
    {
        basis.col(3) << Eigen::Vector3d::Zero(), contact.normal / torqueScale;
    }
    return basis;
}

double coneSupport(const ContactLaw& law, const LocalForce& direction)
{
    return direction[0] + tangential(direction).cwiseProduct(frictionScales(law)).norm();
}

LocalForce coneSupportPoint(const ContactLaw& law, const LocalForce& direction)
{
    LocalForce force = unitNormalForce(law);
    const Eigen::Vector3d scales = frictionScales(law);
    const Eigen::Vector3d ellipsoid = tangential(direction).cwiseProduct(scales);
    const double length = ellipsoid.norm();
    for (Eigen::Index k = 1; length > 0.0 && k < force.size(); ++k)
    {
        force[k] = ellipsoid[k - 1] * scales[k - 1] / length;
    }
    return force;
}

double slipMargin(const ContactLaw& law, const LocalForce& force)
{
    if (law.model == ContactModel::Frictionless)
    {
        return force[0];
    }
    Eigen::Vector3d rest = tangential(force);
    if (law.model == ContactModel::SoftFinger)
    {
        rest[2] /= law.torsion;
    }
    return law.friction * force[0] - rest.norm();
}

Eigen::MatrixXd coneEdges(const ContactLaw& law, int edges)
{
    require(edges >= 3, "contact law: a pyramid needs at least 3 edges");
    const bool soft = law.model == ContactModel::SoftFinger;
    const auto rings = soft ? std::array{0.0, 1.0, -1.0} : std::array{0.0, 0.0, 0.0};
    const Eigen::Index ringCount = soft ? 3 : 1;
    if (law.model == ContactModel::Frictionless)
    {
        return Eigen::MatrixXd::Ones(1, 1);
    }
    Eigen::MatrixXd result = unitNormalForce(law).replicate(1, ringCount * edges + (soft ? 2 : 0));
    for (Eigen::Index column = 0; column < ringCount * edges; ++column)
    {
        const double latitude =
            rings[static_cast<std::size_t>(column / edges)] * std::numbers::pi / 4.0;
        const double phi = 2.0 * std::numbers::pi * static_cast<double>(column % edges) / edges;
        const double radius = law.friction * std::cos(latitude);
        result(1, column) = radius * std::cos(phi);
        result(2, column) = radius * std::sin(phi);
        if (soft)
        {
            result(3, column) = law.friction * law.torsion * std::sin(latitude);
        }
    }
    if (soft)
    {
        result(3, result.cols() - 2) = law.friction * law.torsion;
        result(3, result.cols() - 1) = -law.friction * law.torsion;
    }
    return result;
}

void requireValidContacts(std::span<const GraspContact> contacts)
{
    constexpr double kUnitTolerance = 1e-6;
    for (std::size_t i = 0; i < contacts.size(); ++i)
    {
        const std::string where = "contact " + std::to_string(i);
        require(contacts[i].point.allFinite(),
                where + ": its point is not finite: give coordinates in metres");
        const double length = contacts[i].normal.norm();
        require(std::abs(length - 1.0) <= kUnitTolerance,
                where + ": its normal has length " + std::to_string(length) +
                    ": give a unit vector into the object");
    }
}
}  // namespace bullet_ccd::grasp

/// What acts on the joints of a hand in a Bullet world: drives with limited effort, stops, and the
/// couplings of mimic joints.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
/// The island that the multibody is in; -1 without any collider. Bullet asks the collider of one
/// link, and forgets the constraint if that link has none.
[[nodiscard]] inline int islandOf(const btMultiBody& body)
{
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultiBodyLinkCollider* collider = body.getLink(i).m_collider;
        if (collider != nullptr && collider->getIslandTag() >= 0)
        {
            return collider->getIslandTag();
        }
    }
    return body.getBaseCollider() != nullptr ? body.getBaseCollider()->getIslandTag() : -1;
}

/// A constraint of one multibody that is in the island of its body.
template <typename Base>
class WithinBody : public Base
{
public:
    using Base::Base;
    int getIslandIdA() const override { return islandOf(*this->m_bodyA); }
    int getIslandIdB() const override { return islandOf(*this->m_bodyA); }
};

/// What drives a joint. Revolute joints have radians and newton metres, prismatic ones metres and
/// newtons.
struct DriveSettings
{
    double effort = 0.0;     ///< largest torque or force
    double stiffness = 0.0;  ///< torque per error of position
    double damping = 0.0;    ///< torque per speed
    double maxSpeed = 0.0;   ///< at which it moves towards its target, above 0
};

/// Torque = stiffness (target - position) - damping speed, within the effort, taken at the end of
/// the step (implicitly), so it is stable for any stiffness. Far from the target the damping is as
/// much larger as keeps a joint that nothing holds back from exceeding its speed; one that is
/// blocked presses by the whole torque.
class JointDrive : public WithinBody<btMultiBodyJointMotor>
{
public:
    JointDrive(btMultiBody* body, int link) : WithinBody(body, link, 0.0, 0.0) {}

    void set(const DriveSettings& settings, double target)
    {
        m_settings = settings;
        m_target = target;
    }
    /// Of the last step [N m or N].
    [[nodiscard]] double torque() { return getAppliedImpulse(0) / m_timeStep; }

    /// To be called before every step, as its limit is an impulse.
    void prepare(double timeStep)
    {
        m_timeStep = timeStep;
        setMaxAppliedImpulse(m_settings.effort * timeStep);
    }

    void createConstraintRows(btMultiBodyConstraintArray& rows,
                              btMultiBodyJacobianData& data,
                              const btContactSolverInfo& info) override
    {
        const double error = m_target - m_bodyA->getJointPos(m_linkA);
        const double pull = m_settings.stiffness * error;
        const double resistance =
            std::max(m_settings.damping, std::abs(pull) / m_settings.maxSpeed) +
            m_timeStep * m_settings.stiffness;
        setVelocityTarget(resistance > 0.0 ? pull / resistance : 0.0, 1.0);
        const int before = rows.size();
        btMultiBodyJointMotor::createConstraintRows(rows, data, info);
        if (rows.size() == before || resistance <= 0.0)
        {
            return;  // an impact, in which no drive takes part, or no drive
        }
        btMultiBodySolverConstraint& row = rows[before];
        if (row.m_jacDiagABInv > 0.0)
        {
            const double softness = 1.0 / (resistance * m_timeStep);
            const double inverse = 1.0 / (1.0 / row.m_jacDiagABInv + softness);
            row.m_rhs *= inverse / row.m_jacDiagABInv;
            row.m_cfm = softness * inverse;
            row.m_jacDiagABInv = inverse;
        }
    }

private:
    DriveSettings m_settings;
    double m_target = 0.0;
    double m_timeStep = 1.0;
};

/// position(link) = multiplier position(driver) + offset, held without limit.
class JointCoupling : public WithinBody<btMultiBodyConstraint>
{
public:
    JointCoupling(btMultiBody* body, int link, int driver, double multiplier, double offset)
        : WithinBody(body, body, link, driver, 1, false, MULTIBODY_CONSTRAINT_GEAR),
          m_driver(driver),
          m_multiplier(multiplier),
          m_offset(offset)
    {
        setMaxAppliedImpulse(BT_LARGE_FLOAT);
    }

    void finalizeMultiDof() override
    {
        allocateJacobiansMultiDof();
        jacobianA(0)[6 + m_bodyA->getLink(m_linkA).m_dofOffset] = 1.0;
        jacobianA(0)[6 + m_bodyA->getLink(m_driver).m_dofOffset] = -m_multiplier;
        m_numDofsFinalized = m_jacSizeBoth;
    }

    void createConstraintRows(btMultiBodyConstraintArray& rows,
                              btMultiBodyJacobianData& data,
                              const btContactSolverInfo& info) override
    {
        if (m_numDofsFinalized != m_jacSizeBoth)
        {
            finalizeMultiDof();
        }
        const btVector3 none(0, 0, 0);
        const double error = m_bodyA->getJointPos(m_linkA) -
                             m_multiplier * m_bodyA->getJointPos(m_driver) - m_offset;
        btMultiBodySolverConstraint& row = rows.expandNonInitializing();
        row.m_orgConstraint = this;
        row.m_orgDofIndex = 0;
        fillMultiBodyConstraint(row,
                                data,
                                jacobianA(0),
                                jacobianB(0),
                                none,
                                none,
                                none,
                                none,
                                error,
                                info,
                                -m_maxAppliedImpulse,
                                m_maxAppliedImpulse);
    }

    void debugDraw(btIDebugDraw* /*drawer*/) override {}

private:
    int m_driver;
    double m_multiplier;
    double m_offset;
};

using JointStop = WithinBody<btMultiBodyJointLimitConstraint>;
}  // namespace bullet_ccd::grasp

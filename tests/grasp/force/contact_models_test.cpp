#include "grasp/force/contact_models.h"

#include "tests/grasp/contact_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
using tests::randomGrasp;
using tests::randomVector;

const ContactLaw kSoft{.model = ContactModel::SoftFinger, .friction = 0.6, .torsion = 0.3};

TEST(ContactModels, WhatHasNoEffectIsLeftOut)
{
    EXPECT_EQ(simplified({.friction = 0.0}).model, ContactModel::Frictionless);
    EXPECT_EQ(simplified({.model = ContactModel::SoftFinger, .torsion = 0.0}).model,
              ContactModel::HardFinger);
    EXPECT_EQ(simplified(kSoft).model, ContactModel::SoftFinger);
    EXPECT_EQ(coordinateCount({.model = ContactModel::Frictionless}), 1);
    EXPECT_EQ(coordinateCount({}), 3);
    EXPECT_EQ(coordinateCount(kSoft), 4);
}

TEST(ContactModels, NumbersThatMakeNoSenseAreNamed)
{
    for (const double bad : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()})
    {
        EXPECT_THROW(static_cast<void>(simplified({.friction = bad})), std::invalid_argument);
        EXPECT_THROW(static_cast<void>(simplified({.torsion = bad})), std::invalid_argument);
    }
    EXPECT_THROW(static_cast<void>(coneEdges({}, 2)), std::invalid_argument);
    std::vector<GraspContact> contacts = tests::tetrahedralGrasp();
    EXPECT_NO_THROW(requireValidContacts(contacts));
    contacts[2].normal *= 1.1;
    EXPECT_THROW(requireValidContacts(contacts), std::invalid_argument);
    contacts = tests::tetrahedralGrasp();
    contacts[1].point.y() = std::nan("");
    EXPECT_THROW(requireValidContacts(contacts), std::invalid_argument);
}

// The wrench of local coordinates is the force through the point plus the torsional moment.
TEST(ContactModels, BasisGivesForceAndMomentAboutTheReference)
{
    std::mt19937 random(1);
    for (const GraspContact& contact : randomGrasp(random, 20))
    {
        const Eigen::Vector3d reference = randomVector(random);
        const ContactBasis basis = contactBasis(contact, kSoft, reference, 0.25);
        ASSERT_EQ(basis.cols(), 4);
        const Eigen::Vector4d local(1.5, -0.4, 0.7, 0.2);
        const Wrench wrench = basis * local;
        EXPECT_NEAR(wrench.head<3>().dot(contact.normal), 1.5, 1e-14);
        EXPECT_NEAR(wrench.head<3>().squaredNorm(), local.head<3>().squaredNorm(), 1e-13);
        const Eigen::Vector3d moment =
            (contact.point - reference).cross(wrench.head<3>()) + 0.2 * contact.normal;
        EXPECT_LT((wrench.tail<3>() * 0.25 - moment).norm(), 1e-13);
    }
}

// Samples of the cone's rim: none reaches farther than the support, and the best nearly does.
TEST(ContactModels, SupportIsTheLargestValueOverTheRim)
{
    std::mt19937 random(2);
    for (int trial = 0; trial < 20; ++trial)
    {
        const Eigen::Vector4d direction(
            randomVector(random).x(), randomVector(random).x(), randomVector(random).x(), 1.0);
        double best = -1e9;
        for (int sample = 0; sample < 20000; ++sample)
        {
            const Eigen::Vector3d unit = randomVector(random).normalized();
            const Eigen::Vector4d force(1.0, 0.6 * unit.x(), 0.6 * unit.y(), 0.6 * 0.3 * unit.z());
            best = std::max(best, direction.dot(force));
        }
        const double support = coneSupport(kSoft, direction);
        EXPECT_LE(best, support + 1e-12);
        EXPECT_GE(best, support - 0.02);
        const LocalForce point = coneSupportPoint(kSoft, direction);
        EXPECT_NEAR(direction.dot(point), support, 1e-12);
        EXPECT_NEAR(slipMargin(kSoft, point), 0.0, 1e-12);
        EXPECT_EQ(point[0], 1.0);
    }
}

TEST(ContactModels, EdgesLieOnTheRimOfTheirCones)
{
    EXPECT_EQ(coneEdges({.model = ContactModel::Frictionless}, 8), Eigen::MatrixXd::Ones(1, 1));
    const Eigen::MatrixXd hard = coneEdges({.friction = 0.4}, 8);
    ASSERT_EQ(hard.cols(), 8);
    const Eigen::MatrixXd soft = coneEdges(kSoft, 8);
    ASSERT_EQ(soft.cols(), 26);
    for (Eigen::Index k = 0; k < hard.cols(); ++k)
    {
        EXPECT_NEAR(slipMargin({.friction = 0.4}, hard.col(k)), 0.0, 1e-15);
    }
    for (Eigen::Index k = 0; k < soft.cols(); ++k)
    {
        EXPECT_NEAR(slipMargin(kSoft, soft.col(k)), 0.0, 1e-15);
        EXPECT_EQ(soft(0, k), 1.0);
    }
    EXPECT_NEAR(soft.row(3).maxCoeff(), 0.18, 1e-15);
    EXPECT_NEAR(soft.row(3).minCoeff(), -0.18, 1e-15);
}

TEST(ContactModels, MarginOfAContactWithoutFrictionIsItsNormalForce)
{
    EXPECT_EQ(slipMargin({.model = ContactModel::Frictionless}, LocalForce::Constant(1, 2.5)), 2.5);
    // 0.6 * 2 - |(0.3, 0.4, 0.36 / 0.3)|
    EXPECT_NEAR(slipMargin(kSoft, Eigen::Vector4d(2.0, 0.3, 0.4, 0.36)), 1.2 - 1.3, 1e-15);
}
}  // namespace
}  // namespace bullet_ccd::grasp

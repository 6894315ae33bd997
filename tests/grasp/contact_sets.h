/// Contact sets that tests of quality and of forces share.
#pragma once

#include "grasp/grasp_types.h"

#include <random>
#include <vector>

namespace bullet_ccd::tests
{
inline grasp::GraspContact contactOnUnitSphere(const Eigen::Vector3d& direction)
{
    grasp::GraspContact contact;
    contact.link = 0;
    contact.point = direction.normalized();
    contact.normal = -contact.point;
    return contact;
}

inline std::vector<grasp::GraspContact> tetrahedralGrasp()
{
    return {contactOnUnitSphere({1, 1, 1}),
            contactOnUnitSphere({1, -1, -1}),
            contactOnUnitSphere({-1, 1, -1}),
            contactOnUnitSphere({-1, -1, 1})};
}

inline Eigen::Vector3d randomVector(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    return {normal(random), normal(random), normal(random)};
}

/// Contacts around a lumpy ball, with normals that point roughly inwards.
inline std::vector<grasp::GraspContact> randomGrasp(std::mt19937& random, int contactCount)
{
    std::vector<grasp::GraspContact> contacts;
    for (int i = 0; i < contactCount; ++i)
    {
        grasp::GraspContact contact = contactOnUnitSphere(randomVector(random));
        contact.normal = (contact.normal + 0.3 * randomVector(random)).normalized();
        contacts.push_back(contact);
    }
    return contacts;
}
}  // namespace bullet_ccd::tests

/// Random kinematic trees and motions of them.
#pragma once

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <vector>

namespace bullet_ccd::reference
{
/// Links at arbitrary places under random parents (a chain if `branching` is 0), half of the joints
/// revolute, some prismatic, some fixed.
[[nodiscard]] KinematicTree randomTree(Random& random, int links, double branching);

/// The same with some spherical joints.
[[nodiscard]] KinematicTree randomBallTree(Random& random, int links, double branching);

/// Rates up to `fastest`; a third of the joints rest; the root moves in half of all cases.
[[nodiscard]] JointMotion randomJointMotion(Random& random,
                                            const KinematicTree& tree,
                                            double fastest);

/// Bends the paths of most joints by terms of second to fifth degree of up to `most` in all, so
/// that joints that rested move, too.
void addRandomCurves(Random& random, double most, JointMotion& motion);

[[nodiscard]] RigidMotion randomRigidMotion(Random& random, double fastest);

/// Chain of links along x: revolute joints about z at the ends of links of the given lengths; link
/// 0 is the base. `at` is the place of the base.
[[nodiscard]] KinematicTree planarChain(const std::vector<double>& lengths,
                                        const Eigen::Vector3d& at = Eigen::Vector3d::Zero());
}  // namespace bullet_ccd::reference

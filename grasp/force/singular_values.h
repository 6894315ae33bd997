/// The singular value decomposition, compiled in one place: it takes seconds in every file.
#pragma once

#include <Eigen/Core>

namespace bullet_ccd::grasp
{
/// A = U diag(values) V^T.
struct SingularValues
{
    Eigen::VectorXd values;  ///< largest first
    Eigen::MatrixXd U;       ///< as many orthonormal columns as there are values
};

[[nodiscard]] SingularValues singularValues(const Eigen::MatrixXd& A);
}  // namespace bullet_ccd::grasp

#include "grasp/force/singular_values.h"

#include <Eigen/SVD>

namespace bullet_ccd::grasp
{
SingularValues singularValues(const Eigen::MatrixXd& A)
{
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU);
    return {svd.singularValues(), svd.matrixU()};
}
}  // namespace bullet_ccd::grasp

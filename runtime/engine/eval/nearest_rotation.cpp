#include "runtime/engine/eval/nearest_rotation.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <limits>

namespace meld::eval {

void nearest_rotation(const double matrix[9], double out[9]) {
    using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Eigen::Map<const Matrix> given{matrix};
    if (!given.allFinite()) {
        std::fill_n(out, 9, std::numeric_limits<double>::quiet_NaN());
        return;
    }
    const Eigen::JacobiSVD<Matrix> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix u = svd.matrixU();
    // The best orthogonal matrix may be a reflection; then the direction that matters least is reversed.
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    Eigen::Map<Matrix>{out} = u * svd.matrixV().transpose();
}

}  // namespace meld::eval

// The rotation nearest to a matrix, for Host::nearest_rotation: modules are compiled without Eigen.
#pragma once

namespace meld::eval {

// In the Frobenius norm, with determinant 1; both matrices row by row. A matrix that has several nearest rotations gets one of them, always
// the same one. One with elements that are not finite has none: all of `out` is NaN.
void nearest_rotation(const double matrix[9], double out[9]);

}  // namespace meld::eval

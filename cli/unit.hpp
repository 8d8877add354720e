#pragma once

#include <Eigen/Cholesky>
#include <cstdlib>
#include <vector>

#include "timing.hpp"

/// Times that carry over from one machine to another.
///
/// The unit is one Eigen::LDLT of a symmetric positive definite 6x6 matrix plus one solve, fixed size, over 256
/// different matrices. A bar of T us means T us on a machine where the unit takes 149 ns, and scales with it.
namespace timing {

inline constexpr double reference_unit = 149e-9;  ///< [s]

/// Measures the unit: median of so many passes over the 256 matrices [s].
inline double measure_unit(int count = 101) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  std::vector<Matrix6> matrices;
  std::srand(1);
  for (int i = 0; i < 256; ++i) {
    const Matrix6 a = Matrix6::Random();
    matrices.push_back(a * a.transpose() + 6 * Matrix6::Identity());
  }
  const Vector6 right = Vector6::Ones();
  volatile double sink = 0;
  std::vector<double> passes;
  for (int pass = 0; pass < count; ++pass) {
    const double begin = thread_time();
    double sum = 0;
    for (const Matrix6& matrix : matrices) sum += Eigen::LDLT<Matrix6>(matrix).solve(right)[0];
    passes.push_back((thread_time() - begin) / 256);
    sink = sink + sum;
  }
  return median(std::move(passes));
}

/// The unit beside each repetition of a benchmark: a machine that others use too changes its pace within seconds.
class Units {
 public:
  void measure() { seconds_.push_back(measure_unit(11)); }
  /// How many times as long the unit takes here as on the machine of the bars.
  [[nodiscard]] double slowness() const { return median(seconds_) / reference_unit; }

 private:
  std::vector<double> seconds_;
};

}  // namespace timing

#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <ctime>
#include <vector>

/// Times that carry over from one machine to another.
///
/// The unit is one Eigen::LDLT of a symmetric positive definite 6x6 matrix plus one solve, fixed size, over 256
/// different matrices. A bar of T us means T us on a machine where the unit takes 149 ns, and scales with it.
namespace bench {

inline constexpr double reference_unit = 149e-9;  ///< [s]

/// CPU time of this thread [s]: waiting for a shared core does not count.
inline double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double median(std::vector<double> values);

/// What a pair of calls of thread_time() finds between them: time of the clock itself, a third of a microsecond where it is a
/// system call. Where single steps of a few microseconds are timed it is taken off.
inline double clock_time(int count = 1001) {
  std::vector<double> pairs;
  for (int i = 0; i < count; ++i) {
    const double begin = thread_time();
    pairs.push_back(thread_time() - begin);
  }
  return median(std::move(pairs));
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

}  // namespace bench

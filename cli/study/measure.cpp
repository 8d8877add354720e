#include "study/measure.hpp"

#include <time.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <random>

namespace cli::study {

double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Spread spread(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  const double median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
  return {values.front(), median, values.back()};
}

double unit_nanoseconds() {
  using Matrix = Eigen::Matrix<double, 6, 6>;
  using Vector = Eigen::Matrix<double, 6, 1>;
  constexpr int count = 256, sweeps = 40, repeats = 9;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Matrix> matrices(count);
  for (Matrix& m : matrices) {
    const Matrix half = Matrix::NullaryExpr([&] { return normal(random); });
    m = half * half.transpose() + Matrix::Identity();
  }
  const Vector right = Vector::LinSpaced(1, 2);
  Vector sum = Vector::Zero();
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const double begin = thread_cpu_seconds();
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (const Matrix& m : matrices) sum += Eigen::LDLT<Matrix>(m).solve(right);
    times.push_back(1e9 * (thread_cpu_seconds() - begin) / (count * sweeps));
  }
  volatile double kept = sum.sum();  // so that the loop is not optimised away
  static_cast<void>(kept);
  return spread(times).median;
}

Run timed_run(physics::Simulator& simulator, int steps) {
  Run run;
  const double begin = thread_cpu_seconds();
  for (; run.steps < steps; ++run.steps) {
    const physics::StepResult result = simulator.step();
    if (!result.ok()) break;
    run.iterations += result.iterations;
    run.helped_steps += result.substeps > 1 || result.restarts > 0 || result.new_force_direction;
  }
  run.seconds = thread_cpu_seconds() - begin;
  return run;
}

}  // namespace cli::study

#include <algorithm>

#include "gradients/gradients_impl.hpp"

/// Products with the inverse of the linearisation: dy/dp = -A^-1 dR/dp, of which the velocities' rows are needed.
namespace physics {

/// y = A^-T (adjoint of the velocities);  gradient = what poses pass on by themselves - y^T dR/dp.
void StepGradient::Impl::vector_jacobian(std::span<const double> next_adjoint, std::span<double> gradient) {
  using ConstMap3 = Eigen::Map<const Vec3>;
  using Map3 = Eigen::Map<Vec3>;
  using ConstMap6 = Eigen::Map<const Vector6>;
  const Sensitivity& d = sensitivity;
  const double* a = next_adjoint.data();
  std::fill(adjoint.begin(), adjoint.end(), 0.0);
  for (int i = 0; i < bodies(); ++i, a += 12) {
    Map3(adjoint.data() + row[i]) = ConstMap3(a + 6) + dt * ConstMap3(a);
    Map3(adjoint.data() + row[i] + 3) = ConstMap3(a + 9) + dt * (d.turn[i].transpose() * ConstMap3(a + 3));
  }
  matrix.solve_transposed(adjoint);
  const double* y = adjoint.data();
  std::fill(gradient.begin(), gradient.end(), 0.0);
  if (!normals.empty()) normals.apply(sensitivity, adjoint, gradient);
  double* state = gradient.data();
  double* load = gradient.data() + offset(StepInput::load);
  double* mass = gradient.data() + offset(StepInput::mass);
  double* inertia = gradient.data() + offset(StepInput::inertia);
  a = next_adjoint.data();
  for (int i = 0; i < bodies(); ++i, a += 12) {
    const ConstMap6 yi(y + row[i]);
    Map3(state + 12 * i) += ConstMap3(a);
    Map3(state + 12 * i + 3).noalias() += d.carry[i].transpose() * ConstMap3(a + 3);
    Eigen::Map<Vector6>(state + 12 * i).noalias() -= d.pose[i].transpose() * yi;
    Eigen::Map<Vector6>(state + 12 * i + 6).noalias() -= d.velocity[i].transpose() * yi;
    Eigen::Map<Vector6>(load + 6 * i) = impulse_time * yi;
    mass[i] = -d.mass[i].dot(yi);
    Eigen::Map<Vector6>(inertia + 6 * i).noalias() = -d.inertia[i].transpose() * yi.tail<3>();
  }
  for (const auto& block : d.across)
    for (int c = 0; c < 6; ++c) {
      double sum = 0;
      for (int r = 0; r < block.rows; ++r) sum += block.values(r, c) * y[block.row + r];
      state[12 * block.body + c] -= sum;
    }
  const auto add = [&](const std::vector<Sensitivity::Column>& columns, double* out) {
    for (const auto& column : columns)
      for (int r = 0; r < column.rows; ++r) out[column.parameter] -= column.values[r] * y[column.row + r];
  };
  add(d.effort, gradient.data() + offset(StepInput::effort));
  add(d.friction, gradient.data() + offset(StepInput::friction));
}

/// transposed := rows of A^-1 that belong to the velocities of bodies first .. first + count - 1.
void StepGradient::Impl::solve_pass(int first, int count) {
  solutions.setZero();
  for (int k = 0; k < 6 * count; ++k) solutions(row[first + k / 6] + k % 6, k) = 1;
  matrix.solve_transposed({solutions.data(), static_cast<std::size_t>(6 * count * solutions.rows())}, 6 * count);
  transposed.noalias() = solutions.transpose();
  if (!normals.empty()) normals.apply(sensitivity, transposed);
}

void StepGradient::Impl::multiply_state() {
  const Sensitivity& d = sensitivity;
  const SubtractProduct subtract = subtract_product();
  const auto column = [](Pass& pass, int k) { return pass.data() + static_cast<std::ptrdiff_t>(k) * pass_columns; };
  product.leftCols(12 * bodies()).setZero();
  if (!normals.empty()) normals.subtract_poses(sensitivity, product);
  for (int i = 0; i < bodies(); ++i) {
    const double* y = column(transposed, row[i]);
    subtract(column(product, 12 * i), y, d.pose[i].data(), 6, 6);
    subtract(column(product, 12 * i + 6), y, d.velocity[i].data(), 6, 6);
  }
  for (const auto& block : d.across)
    subtract(column(product, 12 * block.body), column(transposed, block.row), block.values.data(),
             block.values.outerStride(), block.rows);
}

/// product := derivative of the velocities of this pass by the input.
void StepGradient::Impl::multiply(StepInput input) {
  const Sensitivity& d = sensitivity;
  const auto add = [&](const std::vector<Sensitivity::Column>& columns) {
    product.leftCols(this->columns(input)).setZero();
    for (const auto& column : columns)
      for (int r = 0; r < column.rows; ++r)
        product.col(column.parameter) -= column.values[r] * transposed.col(column.row + r);
  };
  switch (input) {
    case StepInput::state: multiply_state(); break;
    case StepInput::effort: add(d.effort); break;
    case StepInput::friction: add(d.friction); break;
    case StepInput::load:
      for (int i = 0; i < bodies(); ++i)
        product.middleCols<6>(6 * i) = impulse_time * transposed.middleCols<6>(row[i]);
      break;
    case StepInput::mass:
      for (int i = 0; i < bodies(); ++i) product.col(i).noalias() = -(transposed.middleCols<6>(row[i]) * d.mass[i]);
      break;
    case StepInput::inertia:
      for (int i = 0; i < bodies(); ++i)
        product.middleCols<6>(6 * i).noalias() = -(transposed.middleCols<3>(row[i] + 3) * d.inertia[i]);
      break;
  }
}

void StepGradient::Impl::jacobian(StepInput input, std::span<double> out) {
  using Map3 = Eigen::Map<Vec3>;
  const int height = columns(StepInput::state), width = columns(input);
  for (int first = 0; first < bodies(); first += bodies_per_pass) {
    const int count = std::min(bodies_per_pass, bodies() - first);
    solve_pass(first, count);
    multiply(input);
    for (int c = 0; c < width; ++c)
      for (int k = 0; k < count; ++k) {
        double* to = out.data() + static_cast<std::ptrdiff_t>(c) * height + 12 * (first + k);
        const Vec3 v = product.col(c).segment<3>(6 * k), w = product.col(c).segment<3>(6 * k + 3);
        Eigen::Map<Eigen::Matrix<double, 12, 1>>{to} << dt * v, dt * (sensitivity.turn[first + k] * w), v, w;
      }
  }
  if (input != StepInput::state) return;
  for (int i = 0; i < bodies(); ++i)  // what poses pass on by themselves
    for (int c = 0; c < 3; ++c) {
      out[static_cast<std::size_t>(12 * i + c) * height + 12 * i + c] += 1;
      Map3(out.data() + static_cast<std::ptrdiff_t>(12 * i + 3 + c) * height + 12 * i + 3) +=
          sensitivity.carry[i].col(c);
    }
}

}  // namespace physics

#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "physics/simulator.hpp"

namespace physics {

/// How the basis of an `aligned` contact depends on the state before a step that slips.
enum class FrictionBasis {
  as_stepped,  ///< as the step did: where it turned, as it does with any slip, it follows; where it was kept, it is constant
  following,   ///< as if it turned in every step. Neither is exact through many steps: use FrictionModel::pyramid
};

struct GradientSettings {
  /// The derivative is that of the central path: every pair of velocity s and impulse z keeps
  ///   s z = smoothing m,   m the largest mass of its island (held constant)   [m^2/s^2].
  /// A value not above that at which a step ends, 1e-15, gives the derivative of the step itself: that of the contacts
  /// that press and the facets that slip. 1e-6 blurs a contact over some mm/s.
  double smoothing = 1e-15;
  FrictionBasis friction_basis = FrictionBasis::as_stepped;
};

/// Why a step has no derivative here.
enum class [[nodiscard]] GradientStatus {
  ready,
  no_step,              ///< no step since the start, a restart or a failed one
  substeps,             ///< the step was taken in shorter ones, whose states are gone
  new_force_direction,  ///< the step took its force directions at the new configuration
  singular,             ///< the linearisation has a singular block
  not_centred,          ///< the central path at this smoothing was not reached
};
std::string_view explanation(GradientStatus status);

/// What a step depends on; the columns of its Jacobian. Bodies held together by a fixed joint move as one: see
/// StepGradient::moving_body.
enum class StepInput {
  state,   ///< per moving body 12, as the next state
  load,    ///< per moving body: force on its centre of mass, world (3) [N]; torque, body frame (3) [N m]
  effort,  ///< per joint of the Mechanism: on the free coordinate, besides its motor's and within its limit [N m or N];
           ///< zero for joints that have none or more than one
  friction,  ///< per contact of the Mechanism: coefficient; zero for contacts without friction or out of reach
  mass,      ///< per moving body, inertia and centre of mass held [kg]
  inertia,   ///< per moving body: Jxx, Jyy, Jzz, Jxy, Jxz, Jyz, mass held [kg m^2]
};

/// Derivatives of one step by the implicit function theorem (docs/gradients.md): with the residual
/// R(y, p) = 0 of the step, y its velocities and joint impulses, p its inputs,
///   dy/dp = -A^-1 dR/dp,   A = dR/dy with the contacts condensed into it.
/// A state is, per moving body, 12 numbers: position (3, world), rotation (3, the vector theta of q exp(theta), body
/// frame), velocity (3, world), angular velocity (3, body frame), as the state between steps: the velocities are those
/// that led to the pose, after a half_kick start those at the pose.
///
/// One object holds the linearisation of one step, so N of them are the tape of N steps; they must not outlive the
/// simulator. Allocates in the constructor, and where friction has to give way to what presses. The simulator is left
/// as it was, to the last bit.
class StepGradient {
 public:
  /// Throws std::invalid_argument when smoothing is negative or not finite.
  explicit StepGradient(Simulator& simulator, const GradientSettings& settings = {});
  ~StepGradient();
  StepGradient(StepGradient&&) noexcept;
  StepGradient& operator=(StepGradient&&) noexcept;

  /// Linearises the last step. Anything but `ready` leaves nothing to ask for.
  GradientStatus evaluate();

  [[nodiscard]] int moving_bodies() const;
  /// Which moving body a body of the Mechanism is part of; -1: the world.
  [[nodiscard]] int moving_body(BodyId body) const;
  [[nodiscard]] int state_size() const;               ///< 12 per moving body
  [[nodiscard]] int columns(StepInput input) const;   ///< of the Jacobian by this input
  [[nodiscard]] int offset(StepInput input) const;    ///< of this input in the gradient
  [[nodiscard]] int gradient_size() const;            ///< all inputs, in the order of StepInput

  /// gradient := J^T adjoint: from the derivative of a scalar by the next state (state_size) to that by all inputs
  /// (gradient_size). One transposed solve. Throws std::invalid_argument for a wrong size, a number that is not
  /// finite and spans that overlap, std::logic_error when evaluate() did not return `ready`.
  void vector_jacobian(std::span<const double> adjoint, std::span<double> gradient);
  /// jacobian := d next state / d input, column-major, state_size x columns(input). Throws as above.
  void jacobian(StepInput input, std::span<double> jacobian);

  /// Velocities (v, w) of moving body i after the step whose derivative this is: those of the step itself, or of the
  /// smoothed one. (6)
  [[nodiscard]] std::span<const double> velocity(int moving_body) const;
  /// Pose after that step.
  [[nodiscard]] const Vec3& position(int moving_body) const;
  [[nodiscard]] const Quat& orientation(int moving_body) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics

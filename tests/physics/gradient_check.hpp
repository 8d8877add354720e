#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/gradients.hpp"
#include "physics/simulator.hpp"

/// Jacobians of a step by central differences of whole steps, each taken by a simulator of its own.
namespace gradient_check {

struct Case {
  physics::Mechanism scene;
  int steps_before = 0;  ///< the step after these is differentiated, from their record; 0: the start itself
  physics::GradientSettings gradient;
  double closer = 1;  ///< factor on the steps of the differences
};

struct Comparison {
  double largest_error = 0;  ///< of all columns: difference over the column's largest entry, or 1e-3 of the
                             ///< Jacobian's, or 0.1 (dt for forces), whichever is most
  std::string where;
  Eigen::MatrixXd jacobian, differences;
  int iterations = 0;  ///< of the step that is differentiated
};

/// Bodies of the scene must all be moving ones. `efforts` are differentiated through the motors' targets, or as
/// loads on the two bodies of a joint without one.
Comparison compare(const Case& test, physics::StepInput input);

/// Largest relative difference between J^T a, a random, from vector_jacobian and from the Jacobians of all inputs.
/// least: size below which a difference is not relative, for what is held and does not answer to all of them.
double transposed_error(const Case& test, double least = 0);

}  // namespace gradient_check

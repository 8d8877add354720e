// What docs/gradients.md shows, so that it was compiled and run.
#include <cstdio>
#include <exception>
#include <vector>

#include "physics/gradients.hpp"
#include "physics/scenes.hpp"

using namespace physics;

int main() try {
  Simulator simulator(built_in_scene("sliding_box"));
  StepGradient gradient(simulator);
  // Any function of the next state will do; here the sum of its numbers, whose derivative by each of them is 1.
  std::vector<double> by_next_state(gradient.state_size(), 1.0), by_inputs(gradient.gradient_size());
  if (!simulator.step().ok() || gradient.evaluate() != GradientStatus::ready) return 1;
  gradient.vector_jacobian(by_next_state, by_inputs);
  std::printf("%zu numbers of the state and %zu inputs in all; by the first position: %.3f\n", by_next_state.size(),
              by_inputs.size(), by_inputs[0]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

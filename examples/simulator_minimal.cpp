// A ball falls 1 m onto the floor and stays there. Prints: after 1 s: centre at 0.1000 m, the floor pushes with 9.81 N
#include <cstdio>
#include <exception>

#include "physics/simulator.hpp"

using namespace physics;

int main() try {
  Mechanism scene;  // or: built_in_scene("snake:n=100"), or read_scene("scene.toml").mechanism
  Body ball;
  ball.name = "ball";
  ball.mass = 1;
  ball.inertia = 0.004 * Mat3::Identity();
  ball.position = {0, 0, 1.1};
  Contact floor;  // by default with the plane z = 0
  floor.name = "floor";
  floor.body = scene.add(ball);
  floor.radius = 0.1;
  floor.friction = 0.5;
  scene.add(floor);
  Simulator simulator(scene);
  while (simulator.step_index() < 100) {
    const StepResult result = simulator.step();
    if (!result.ok()) {
      std::printf("step %d: %s\n", simulator.step_index() + 1, result.cause.data());
      return 1;
    }
  }
  StepRecord record;
  simulator.write_record(record);
  std::printf("after %g s: centre at %.4f m, the floor pushes with %.2f N\n", record.time,
              record.bodies[0].position.z(), record.contacts[0].normal_force);
} catch (const std::exception& error) {
  std::fprintf(stderr, "simulator_minimal: %s\n", error.what());
  return 2;
}

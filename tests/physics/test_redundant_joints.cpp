// Joints that hold more than they need to, in space: nobody is unique there, but nothing may run away.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "physics/simulator.hpp"

namespace test_redundant_joints {

using namespace physics;

const Vec3 low(0.3, 0.05, 0.3), high(0.35, 0.2, 0.05);  ///< where the bodies are joined

/// Two plates whose frames point anywhere.
Mechanism two_plates(int seed) {
  Mechanism scene;
  scene.time_step = 0.01;
  for (int i = 0; i < 2; ++i) {
    Body body;
    body.name = "plate " + std::to_string(i);
    body.mass = 1;
    body.inertia = Vec3(0.03, 0.04, 0.05).asDiagonal();
    body.position = i == 0 ? Vec3(0, 0, 0) : Vec3(0.6, 0.1, 0.2);
    const Vec3 axis = Vec3(1 + seed, 2 - 3 * i, seed - 5 * i).normalized();
    body.orientation = Quat(Eigen::AngleAxisd(0.7 + seed + 2 * i, axis));
    scene.add(body);
  }
  return scene;
}

/// Closed at the start; axis in the world.
void join(Mechanism& scene, JointType type, int parent, int child, const Vec3& at, const Vec3& axis) {
  const auto into = [&](int i, const Vec3& point) {
    return i < 0 ? point : Vec3(scene.bodies[i].orientation.conjugate() * (point - scene.bodies[i].position));
  };
  const Quat of_parent = parent < 0 ? Quat(Quat::Identity()) : scene.bodies[parent].orientation;
  Joint joint;
  joint.name = "joint " + std::to_string(scene.joints.size());
  joint.type = type;
  joint.parent = {parent};
  joint.child = {child};
  joint.parent_point = into(parent, at);
  joint.child_point = into(child, at);
  joint.axis = of_parent.conjugate() * axis.normalized();
  joint.orientation = (of_parent.conjugate() * scene.bodies[child].orientation).normalized();
  scene.add(joint);
}

struct Motion {
  double force = 0;  ///< largest of a joint [N]
  double energy = 0;
  int helped = 0;    ///< steps in substeps or with the new force direction
  std::size_t named = 0;
};

Motion run(Simulator& simulator, int steps) {
  Motion result;
  StepRecord record;
  for (int k = 0; k < steps; ++k) {
    const StepResult step = simulator.step();
    EXPECT_TRUE(step.ok()) << "step " << k + 1 << ": " << step.cause;
    if (!step.ok()) break;
    result.helped += step.substeps > 1 || step.new_force_direction;
    simulator.write_record(record);
    for (const JointRecord& joint : record.joints) result.force = std::max(result.force, joint.force.norm());
  }
  result.energy = simulator.energy();
  result.named = simulator.redundancies().size();
  return result;
}

/// A pendulum of two plates, the lower one on two ball joints, is that on one hinge through both. Forces of the row too
/// many grew to 1e11 N in a hundred steps, status solved, until rounding of them took the energy away.
TEST(RedundantJoints, APendulumOnTwoBallsIsOneOnAHinge) {
  for (int seed = 0; seed < 4; ++seed) {
    Mechanism on_balls = two_plates(seed), on_hinge = on_balls;
    join(on_balls, JointType::spherical, 0, 1, low, Vec3::UnitZ());
    join(on_balls, JointType::spherical, 0, 1, high, Vec3::UnitZ());
    join(on_hinge, JointType::revolute, 0, 1, low, high - low);
    for (Mechanism* scene : {&on_balls, &on_hinge})
      join(*scene, JointType::spherical, -1, 0, Vec3(-0.3, 0, 0), Vec3::UnitZ());
    Simulator balls(on_balls), hinge(on_hinge);
    const Motion a = run(balls, 400), b = run(hinge, 400);
    EXPECT_EQ(a.helped, 0) << seed;
    EXPECT_NEAR(a.energy, b.energy, 1e-4) << seed;
    EXPECT_LE(a.force, 1.5 * b.force) << seed;
    EXPECT_EQ(a.named, 1u) << seed << ": as long as they are closed, wherever they are";
    EXPECT_EQ(b.named, 0u) << seed;
  }
}

/// Two free bodies, joined twice: what the joints do inside keeps the angular momentum.
TEST(RedundantJoints, OfTwoFreeBodiesKeepTheAngularMomentum) {
  const std::vector<JointType> types{JointType::revolute, JointType::prismatic, JointType::spherical};
  for (std::size_t first = 0; first < types.size(); ++first)
    for (std::size_t second = first; second < types.size(); ++second)
      for (int seed = 0; seed < 3; ++seed) {
        Mechanism scene = two_plates(seed);
        scene.gravity.setZero();
        const Vec3 spin(0.9, -0.4 + 0.3 * seed, 0.7);
        for (Body& body : scene.bodies) {
          body.angular_velocity = body.orientation.conjugate() * spin;
          body.velocity = spin.cross(body.position);
        }
        join(scene, types[first], 0, 1, low, Vec3(1, 2, 3));
        join(scene, types[second], 0, 1, high, Vec3(3, -1, 1));
        Simulator simulator(scene);
        const Vec3 before = simulator.angular_momentum();
        const Motion result = run(simulator, 300);
        const std::string where = std::to_string(first) + " and " + std::to_string(second) + ", " + std::to_string(seed);
        EXPECT_EQ(result.helped, 0) << where;
        EXPECT_LE(result.force, 20) << where;
        EXPECT_LE((simulator.angular_momentum() - before).norm(), 1e-8 * before.norm()) << where;
      }
}

}  // namespace test_redundant_joints

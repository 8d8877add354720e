#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "gradient_check.hpp"

namespace test_gradients_held_twice {

/// Derivatives where normals, friction and joints hold one motion more than once: friction gives way, what presses and
/// joints do not. Everything in general position.

using namespace physics;
using gradient_check::Case;

const Quat turned = Quat(0.7, -0.3, 0.5, 0.2).normalized();

/// Along x before it is turned about y; then all is turned into general position, gravity too.
Body bar(const std::string& name, const Vec3& centre, double angle, double length) {
  Body body;
  body.name = name;
  body.mass = 1 + length;
  body.inertia = Vec3(0.01, length * length / 10, length * length / 11).asDiagonal();
  body.position = turned * centre;
  body.orientation = turned * Quat(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  return body;
}

Contact touch(const std::string& name, const Mechanism& scene, int body, const Vec3& point, const Vec3& normal) {
  const Body& on = scene.bodies[body];
  Contact contact;
  contact.name = name;
  contact.body = {body};
  contact.point = point;
  contact.normal = turned * normal;
  contact.plane_point = on.position + on.orientation * point;
  contact.friction = 0.7;
  contact.friction_model = FrictionModel::pyramid;
  return contact;
}

Joint hinge(const std::string& name, const Mechanism& scene, BodyId parent, int child, const Vec3& at) {
  const Body& b = scene.bodies[child];
  Joint joint;
  joint.name = name;
  joint.type = JointType::revolute;
  joint.parent = parent;
  joint.child = {child};
  joint.child_point = at;
  joint.axis = Vec3::UnitY();
  const Vec3 place = b.position + b.orientation * at;
  if (parent.is_world()) {
    joint.parent_point = place;
    joint.orientation = b.orientation;
    joint.axis = turned * Vec3::UnitY();
  } else {
    const Body& a = scene.bodies[parent.index];
    joint.parent_point = a.orientation.conjugate() * (place - a.position);
    joint.orientation = a.orientation.conjugate() * b.orientation;
  }
  return joint;
}

Mechanism empty(const std::string& name) {
  Mechanism scene;
  scene.name = name;
  scene.time_step = 0.01;
  scene.start = Start::standard;
  scene.gravity = turned * Vec3(0, 0, -9.81);
  return scene;
}

/// One bar on a hinge of the world, its tip on the floor: one motion, held by the normal and by friction.
Mechanism bar_on_a_hinge(double angle) {
  Mechanism scene = empty("bar on a hinge");
  scene.add(bar("bar", {0.3, -0.2, 0.5}, angle, 1));
  scene.add(hinge("hinge", scene, world, 0, {-0.5, 0, 0}));
  scene.add(touch("tip", scene, 0, {0.5, 0, 0}, Vec3::UnitZ()));
  return scene;
}

/// The same on a slide, at an angle to the floor that it can still be pushed along.
Mechanism bar_on_a_slide() {
  Mechanism scene = empty("bar on a slide");
  scene.add(bar("bar", {0.3, -0.2, 0.5}, 0.4, 1));
  Joint slide = hinge("slide", scene, world, 0, {0.1, 0, 0.2});
  slide.type = JointType::prismatic;
  slide.axis = turned * Vec3(0.5, 0, 0.8).normalized();
  scene.add(slide);
  scene.add(touch("tip", scene, 0, {0.5, 0, 0}, Vec3::UnitZ()));
  return scene;
}

void expect_agreement(const Case& test) {
  for (const StepInput input : {StepInput::state, StepInput::load, StepInput::friction, StepInput::mass, StepInput::inertia}) {
    const auto result = gradient_check::compare(test, input);
    EXPECT_LE(result.largest_error, 1e-5) << test.scene.name << ", " << result.where;
    std::printf("             %-16s step %4d: %.1e\n", test.scene.name.c_str(), test.steps_before + 1,
                result.largest_error);
  }
  EXPECT_LE(gradient_check::transposed_error(test, 1e-3), 1e-6) << test.scene.name;
}

TEST(StepGradientHeldTwice, OfABarOnAHingeIsWhatTheFloorAllows) {
  for (const double angle : {0.2, 0.5, 0.8})
    for (const int steps : {0, 3}) expect_agreement({bar_on_a_hinge(angle), steps, {}});
}

TEST(StepGradientHeldTwice, OfABarOnASlideIsWhatTheFloorAllows) {
  for (const int steps : {0, 3}) expect_agreement({bar_on_a_slide(), steps, {}});
}

}  // namespace test_gradients_held_twice

#pragma once

#include <functional>
#include <limits>
#include <string>

#include "physics/mechanism.hpp"

/// A scene where nothing is wrong, and what `validate` says of it after a change.
namespace mistakes {

using namespace physics;

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Two bodies, a joint of each kind that matters, a contact, a load: all right.
inline Mechanism good_scene() {
  Mechanism scene;
  Body body;
  body.mass = 2;
  body.inertia = Vec3(1, 2, 2.5).asDiagonal();
  body.name = "disc";
  const BodyId disc = scene.add(body);
  body.name = "rod";
  const BodyId rod = scene.add(body);
  Joint knee;
  knee.name = "knee";
  knee.type = JointType::revolute;
  knee.parent = disc;
  knee.child = rod;
  knee.motor = Motor{.stiffness = 1, .damping = 1, .limit = 2, .target = 0.0};
  scene.add(knee);
  Joint ball;
  ball.name = "ball";
  ball.type = JointType::spherical;
  ball.child = disc;
  scene.add(ball);
  Contact rim;
  rim.name = "rim";
  rim.body = disc;
  rim.friction = 0.5;
  rim.tangent = Vec3::UnitX();
  scene.add(rim);
  Load push;
  push.body = rod;
  scene.add(push);
  return scene;
}

/// What `validate` says of the good scene after a change; empty when it says nothing.
inline std::string message(const std::function<void(Mechanism&)>& change) {
  Mechanism scene = good_scene();
  change(scene);
  try {
    validate(scene);
  } catch (const DescriptionError& error) {
    return error.what();
  }
  return "";
}

#define CHANGE(statement) [](Mechanism& scene) { statement; }

}  // namespace mistakes

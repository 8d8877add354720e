#pragma once

#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "physics/geometry.hpp"

/// The description of a scene: plain data, SI units, names everywhere. A Mechanism is what a scene file
/// holds; nothing is computed here. Build one by hand, read one from a file (scene_io.hpp) or take a
/// built-in one (scenes.hpp), then hand it to a Simulator.
namespace physics {

/// A wrong description. The message is one sentence that names the thing and the value.
class DescriptionError : public std::runtime_error {
 public:
  /// place: see there.
  explicit DescriptionError(const std::string& message, std::string place = {})
      : std::runtime_error(message), place_(std::move(place)) {}
  /// Of the wrong value in a scene file, "bodies[2].mass", where `validate` has found it; else empty. `line_in_scene`
  /// (scene_io.hpp) tells the line.
  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  std::string place_;
};

/// Index of a body in Mechanism::bodies; the default is the world.
struct BodyId {
  int index = -1;
  [[nodiscard]] bool is_world() const { return index < 0; }
  friend bool operator==(BodyId, BodyId) = default;
};
inline constexpr BodyId world{};

/// Keys of a scene file that start with `x_`: kept as JSON text, written back, otherwise ignored.
using Extras = std::vector<std::pair<std::string, std::string>>;

/// For pictures and default inertia only.
struct Shape {
  enum class Type { none, sphere, box, cylinder, capsule, mesh };
  Type type = Type::none;
  double radius = 0;         ///< sphere, cylinder, capsule [m]
  double height = 0;         ///< cylinder, capsule: along z [m]
  Vec3 size = Vec3::Zero();  ///< box: full edge lengths [m]
  std::string file = {};     ///< mesh
};

struct Body {
  std::string name = {};
  double mass = 0;              ///< [kg], > 0
  Mat3 inertia = Mat3::Zero();  ///< about the centre of mass, body frame [kg m^2]
  Vec3 position = Vec3::Zero();          ///< centre of mass, world [m]
  Quat orientation = Quat::Identity();   ///< body to world, unit
  Vec3 velocity = Vec3::Zero();          ///< world [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< body frame [rad/s]
  Shape shape = {};
  Extras extras = {};
};

/// offset + amplitude sin(2 pi frequency t + phase)
struct SineTarget {
  double offset = 0, amplitude = 0;  ///< [rad] or [m]
  double frequency = 0;              ///< [Hz]
  double phase = 0;                  ///< [rad]
};
/// Piecewise linear through (time [s], value); constant before the first and after the last.
using TableTarget = std::vector<std::pair<double, double>>;

/// Drives the free coordinate of a revolute or prismatic joint:
///   effort = stiffness (target - coordinate) - damping rate, |effort| <= limit.
struct Motor {
  double stiffness = 0;                                    ///< [N m/rad] or [N/m], >= 0
  double damping = 0;                                      ///< [N m s/rad] or [N s/m], >= 0
  double limit = std::numeric_limits<double>::infinity();  ///< [N m] or [N], > 0
  std::variant<double, SineTarget, TableTarget> target = 0.0;
};

enum class JointType { fixed, revolute, prismatic, spherical };

struct Joint {
  std::string name = {};
  JointType type = JointType::fixed;
  BodyId parent = {};  ///< may be the world
  BodyId child = {};   ///< a body
  Vec3 parent_point = Vec3::Zero();     ///< parent frame [m]
  Vec3 child_point = Vec3::Zero();      ///< child frame [m]
  Vec3 axis = Vec3::UnitZ();            ///< parent frame; revolute, prismatic
  Quat orientation = Quat::Identity();  ///< of the child relative to the parent at rest
  std::optional<Motor> motor = {};
  Extras extras = {};
};

enum class FrictionModel {
  pyramid,  ///< the paper's: first direction fixed, slip is the velocity at the pose before the step
  aligned   ///< first direction along the slip when a step begins; slip is the way from pose to pose
};

/// A contact point of a body against a fixed plane.
struct Contact {
  std::string name = {};
  BodyId body = {};
  Vec3 point = Vec3::Zero();        ///< body frame [m]
  Vec3 normal = Vec3::UnitZ();      ///< world, out of the solid side
  Vec3 plane_point = Vec3::Zero();  ///< world [m]
  std::optional<double> friction = {};   ///< coefficient, 0 to 1000; absent: frictionless
  FrictionModel friction_model = FrictionModel::aligned;
  int directions = 4;           ///< facets of the pyramid, even, >= 4
  std::optional<Vec3> tangent = {};  ///< first friction direction of `pyramid`; absent: any
  double radius = 0;            ///< the contact is a sphere of this radius about `point` [m]
  Extras extras = {};
};

/// Force (world) and torque (body frame) in the steps first..last, inclusive; step k leads to record k.
struct Load {
  BodyId body = {};
  int first_step = 1, last_step = 1;
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< [N m]
};

/// `standard`: Body::velocity led to the given pose (the paper). `half_kick`: it is the velocity at that
/// pose, and the first step is second order.
enum class Start { standard, half_kick };

struct Mechanism {
  std::string name = {};
  double time_step = 0.01;  ///< [s]
  Vec3 gravity{0, 0, -9.81};  ///< [m/s^2]
  Start start = Start::half_kick;
  std::vector<Body> bodies = {};
  std::vector<Joint> joints = {};
  std::vector<Contact> contacts = {};
  std::vector<Load> loads = {};
  Extras extras = {};

  BodyId add(Body body) {
    bodies.push_back(std::move(body));
    return {static_cast<int>(bodies.size()) - 1};
  }
  void add(Joint joint) { joints.push_back(std::move(joint)); }
  void add(Contact contact) { contacts.push_back(std::move(contact)); }
  void add(Load load) { loads.push_back(load); }
};

/// Inertia of a homogeneous shape of the given mass [kg m^2]; zero for `none` and `mesh`.
Mat3 shape_inertia(const Shape& shape, double mass);

/// Checks everything a simulation relies on (unique names, masses, inertias, axes, quaternions, points,
/// indices, |w| dt < 1.9, ...) and normalises quaternions within 1e-6 of unit.
/// Throws DescriptionError: "revolute joint 'knee': axis has length 0", of the place "joints[0].axis".
void validate(Mechanism& mechanism);

}  // namespace physics

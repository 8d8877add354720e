#include "simd/joint_kernels.hpp"

#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/joint_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include <hwy/contrib/math/math-inl.h>

#include "simd/algebra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
namespace {

using graphsolve::simd::LaneBlocks;

/// Eight poses: the numbers of a NextPose, or of a Pose, whose turn nobody needs. Read where they are used: a copy in
/// registers would be one on the stack.
struct Place {
  const Octet* number;
  HWY_INLINE Vector3 x() const { return load3(number); }
  HWY_INLINE Quaternion q() const { return {load3(number + 3), load(number[6])}; }
  HWY_INLINE Matrix3 rotation() const { return load33(number + 7); }
  HWY_INLINE Vector3 rotation_row(int i) const {
    return {load(number[7 + i]), load(number[10 + i]), load(number[13 + i])};
  }
  HWY_INLINE Matrix3 turn() const { return load33(number + 16); }
};

HWY_NOINLINE const Octet* gather(const double* const* lanes, int count, Pack* to) {
  for (int k = 0; k < count; ++k) to[k] = gs::each_lane<8>([&](int l) HWY_ATTR { return lanes[l][8 * k]; });
  return reinterpret_cast<const Octet*>(to);
}

template <JointRows Rows>
struct Kind {
  static constexpr bool motor = has_motor(Rows), slides = is_slide(Rows), hinge = is_hinge(Rows);
  static constexpr int translations = physics::translations(Rows), rotations = physics::rotations(Rows);
  static constexpr int constraints = physics::constraints(Rows), rows = rows_of(Rows);
  static constexpr bool in_world_axes = !slides;  ///< the first three rows
};

HWY_INLINE Vector3 unit(int i) {
  return {Pack(i == 0 ? 1.0 : 0.0), Pack(i == 1 ? 1.0 : 0.0), Pack(i == 2 ? 1.0 : 0.0)};
}

HWY_INLINE Pack atan(const Pack& a) {
  Pack r;
  for (int i = 0; i < Pack::parts; ++i) r.part[i] = hwy::HWY_NAMESPACE::Atan(Pack::Tag(), a.part[i]);
  return r;
}
HWY_INLINE Pack round(const Pack& a) {
  Pack r;
  for (int i = 0; i < Pack::parts; ++i) r.part[i] = hwy::HWY_NAMESPACE::Round(a.part[i]);
  return r;
}

/// A pack of joints between two poses.
template <JointRows Rows, bool WithTurn>
struct Joint {
  using K = Kind<Rows>;
  const JointPoints& points;
  const JointFrames* frames;
  Pack room[2][25];        ///< of poses that do not lie in the lanes of their joints
  Place a, b;              ///< parent, child
  Vector3 child_point;
  Quaternion e;            ///< q_a^-1 q_b q_off^-1, on the half that holds the identity
  Matrix3 offset;

  HWY_INLINE Joint(const JointTask& task)
      : points(*task.points), frames(task.frames), child_point(load3(points.child)) {
    const int numbers = WithTurn && task.values ? 25 : 16;
    a.number = task.parents ? task.parents : gather(task.parent, numbers, room[0]);
    b.number = task.children ? task.children : gather(task.child, numbers, room[1]);
    if constexpr (K::rotations > 0) {
      const Quaternion rest{load3(frames->orientation), load(frames->orientation[3])};
      e = conjugate(a.q()) * b.q() * conjugate(rest);
      const Pack sign = gs::select(e.w < Pack(0.0), Pack(-1.0), Pack(1.0));
      e = {sign * e.v, sign * e.w};
      offset = load33(frames->orientation_matrix);
    }
  }
  Joint(const Joint&) = delete;
  Joint& operator=(const Joint&) = delete;

  HWY_INLINE Vector3 locked_rotation(int i) const {
    if constexpr (K::hinge) return load3(frames->side[i]);
    else return unit(i);
  }
  /// From the parent's centre to the child's joint point, parent frame.
  HWY_INLINE Vector3 arm() const { return transposed_times(a.rotation(), b.x() + b.rotation() * child_point - a.x()); }

  /// Of the motor: along the slide, or about the hinge.
  HWY_INLINE Pack coordinate() const {
    const Vector3 axis = load3(frames->axis);
    if constexpr (K::slides) return dot(axis, arm() - load3(points.parent));
    else return Pack(2.0) * atan(dot(axis, e.v) / e.w);  // e.w >= 0
  }

  HWY_INLINE void violation(Pack* g) const {
    const Vector3 parent_point = load3(points.parent);
    if constexpr (K::slides) {
      const Vector3 d = arm() - parent_point;
      for (int i = 0; i < 2; ++i) g[i] = dot(load3(frames->side[i]), d);
    } else {
      put(b.x() + b.rotation() * child_point - a.x() - a.rotation() * parent_point, g);
    }
    for (int i = 0; i < K::rotations; ++i) g[K::translations + i] = Pack(2.0) * dot(locked_rotation(i), e.v);
  }

  /// Derivatives of the rows by (x, theta) of child and parent; without a turn the force directions.
  /// put(row, of the parent?, first column, three numbers)
  template <class Put>
  HWY_INLINE void derivative(Put&& put) const {
    for (int i = 0; i < K::translations; ++i) {
      if constexpr (K::slides) along_axis(load3(frames->side[i]), i, put);
      else along_world(i, put);
    }
    const Vector3 zero{Pack(0.0), Pack(0.0), Pack(0.0)};
    const auto rotation_row = [&](const Vector3& on_child, const Vector3& on_parent, int r) HWY_ATTR {
      put(r, false, 0, zero);
      put(r, true, 0, zero);
      put(r, false, 3, turned(b, transposed_times(offset, on_child)));
      put(r, true, 3, turned(a, -on_parent));
    };
    // d(2 vec e) = (w I + [v]x) R_off theta_b = -(w I - [v]x) theta_a
    for (int i = 0; i < K::rotations; ++i) {
      const Vector3 r = locked_rotation(i), even = e.w * r, odd = cross(r, e.v);
      rotation_row(even + odd, even - odd, K::translations + i);
    }
    if constexpr (K::motor && K::slides) along_axis(load3(frames->axis), 5, put);
    if constexpr (K::motor && K::hinge) {
      // Of 2 atan2(axis . v, w), exact off the hinge's manifold too.
      const Vector3 axis = load3(frames->axis);
      const Pack along = dot(axis, e.v), share = Pack(1.0) / (e.w * e.w + along * along);
      const Vector3 even = share * (e.w * e.w * axis + along * e.v), odd = share * e.w * cross(axis, e.v);
      rotation_row(even + odd, even - odd, 5);
    }
  }

 private:
  static HWY_INLINE Vector3 turned(const Place& place, const Vector3& angular) {
    if constexpr (WithTurn) return transposed_times(place.turn(), angular);
    else return angular;
  }
  /// Row of x_b + R_b p_b - x_a - R_a p_a in world axis i.
  template <class Put>
  HWY_INLINE void along_world(int i, Put&& put) const {
    put(i, false, 0, unit(i));
    put(i, true, 0, -unit(i));
    put(i, false, 3, turned(b, cross(child_point, b.rotation_row(i))));
    put(i, true, 3, turned(a, cross(a.rotation_row(i), load3(points.parent))));
  }
  /// Row of f . R_a^T (x_b + R_b p_b - x_a), f fixed in the parent.
  template <class Put>
  HWY_INLINE void along_axis(const Vector3& f, int i, Put&& put) const {
    const Vector3 world = a.rotation() * f;
    put(i, false, 0, world);
    put(i, true, 0, -world);
    put(i, false, 3, turned(b, cross(child_point, transposed_times(b.rotation(), world))));
    put(i, true, 3, turned(a, cross(f, arm())));
  }
};

/// Of rows along world axes the force is that axis, always: Joints has written it.
template <JointRows Rows>
HWY_INLINE void aim(const JointTask& task) {
  using K = Kind<Rows>;
  const Joint<Rows, false> joint(task);
  const Keeper keep(task.used);
  joint.derivative([&](int r, bool of_parent, int first, const Vector3& numbers) HWY_ATTR {
    if (K::in_world_axes && r < 3 && first == 0) return;
    keep(numbers, (of_parent ? task.parent_force : task.child_force) + 6 * r + first);
  });
  const Mask on_parent = lanes_of(task.children_are_world);
  const auto recorded = [&](const Pack& of_parent, const Pack& of_child) HWY_ATTR {
    return gs::select(on_parent, of_parent, of_child);
  };
  const Vector3 a = joint.a.x(), b = joint.b.x(), point = b + joint.b.rotation() * joint.child_point;
  for (int k = 0; k < 4; ++k) keep(recorded(load(joint.a.number[3 + k]), load(joint.b.number[3 + k])), task.stands[k]);
  keep(point.x - recorded(a.x, b.x), task.stands[4]);
  keep(point.y - recorded(a.y, b.y), task.stands[5]);
  keep(point.z - recorded(a.z, b.z), task.stands[6]);
}

/// out = force^T impulses; sign: of the force along a world axis.
template <class K>
HWY_INLINE void push(const Octet* force, const Pack* impulses, double sign, Octet* out) {
  constexpr int first = K::in_world_axes ? 3 : 0;  // forces of these rows are the impulses
  if constexpr (K::in_world_axes)
    for (int c = 0; c < 3; ++c) store(Pack(sign) * impulses[c], out[c]);
  for (int c = first; c < 6; ++c) {
    Pack sum = load(force[c]) * impulses[0];
    for (int r = 1; r < K::rows; ++r) sum += load(force[6 * r + c]) * impulses[r];
    store(sum, out[c]);
  }
}

/// Block (body, joint) = -force^T: this is of this joint alone. sign: of the force along a world axis.
template <class K>
HWY_INLINE void write_force(const JointTask& task, const Octet* force, double sign, const LaneBlocks& to) {
  gs::BlockAssignment<6 * K::rows> block(task.values, to, task.used);
  for (int r = 0; r < K::rows; ++r)
    for (int c = 0; c < 6; ++c)
      block(6 * r + c, K::in_world_axes && c < 3 ? Pack(r == c ? -sign : 0.0) : -load(force[6 * r + c]));
  block.finish();
}

/// Blocks (joint, body) = derivative, likewise. limited: where the last row, of a motor, vanishes.
template <JointRows Rows>
HWY_INLINE void write_derivative(const JointTask& task, const Joint<Rows, true>& joint, const Mask& limited) {
  using K = Kind<Rows>;
  gs::BlockAssignment<6 * K::rows> child(task.values, task.blocks->to_child, task.used);
  gs::BlockAssignment<6 * K::rows> parent(task.values, task.blocks->to_parent, task.used);
  joint.derivative([&](int r, bool of_parent, int first, const Vector3& numbers) HWY_ATTR {
    auto& block = of_parent ? parent : child;
    const auto write = [&](int c, const Pack& number) HWY_ATTR {
      if constexpr (K::motor) block(c * K::rows + r, r == 5 ? gs::select(limited, Pack(0.0), number) : number);
      else block(c * K::rows + r, number);
    };
    write(first, numbers.x), write(first + 1, numbers.y), write(first + 2, numbers.z);
  });
  child.finish();
  parent.finish();
}

/// (lambda - impulse_time * effort) * diagonal, an angle or a distance. Where the effort is at its limit it no longer
/// answers to the velocity.
template <JointRows Rows>
HWY_INLINE Pack motor(const JointTask& task, const Joint<Rows, true>& joint, const Pack& lambda, Mask& limited,
                      Pack& diagonal) {
  MotorOctet& m = *task.motor;
  const Pack before = load(m.coordinate), limit = load(m.limit), dt(task.dt);
  Pack change = joint.coordinate() - before;
  if constexpr (Kind<Rows>::hinge) {  // follows full turns
    constexpr double turn = 2 * std::numbers::pi;
    change -= Pack(turn) * round(change * Pack(1 / turn));
  }
  const Pack next = before + change, stiffness = load(m.stiffness), damping = load(m.damping);
  const Pack wanted = stiffness * (load(m.target) - next) - damping * change / dt;
  const Mask used = lanes_of(task.used);
  limited = !(gs::abs(wanted) < limit);
  const Pack effort = gs::select(limited, gs::select(wanted < Pack(0.0), -limit, limit), wanted),
             time = load(m.impulse_time);
  store(gs::select(used, next, load(m.next_coordinate)), m.next_coordinate);
  store(gs::select(used, gs::select(limited, Pack(1.0), Pack(0.0)), load(m.limited)), m.limited);
  diagonal = Pack(1.0) / (time * (stiffness * dt + damping));
  return (lambda - time * effort) * diagonal;
}

template <JointRows Rows>
HWY_INLINE void evaluate(const JointTask& task) {
  using K = Kind<Rows>;
  const unsigned used = task.used;
  const Joint<Rows, true> joint(task);
  Pack g[K::rows], impulses[K::rows];
  Mask limited;
  joint.violation(g);
  const Pack rate(1 / task.dt);
  for (int i = 0; i < K::constraints; ++i) g[i] *= rate;
  const double* from[8];
  double* residual[8];
  for (int l = 0; l < 8; ++l) from[l] = task.x + task.rows[l], residual[l] = task.residual + task.rows[l];
  gs::load_transposed(from, K::rows, impulses, used);
  if constexpr (K::motor) {
    Pack diagonal;
    g[5] = motor(task, joint, impulses[5], limited, diagonal);
    if (task.values)
      gs::put_entries(&diagonal, 1, [](int) HWY_ATTR { return 35; }, task.values, task.blocks->own, used, 1.0);
  }
  gs::add_transposed(g, K::rows, residual, used, 1.0);
  push<K>(task.child_force, impulses, 1.0, task.wrenches->child);
  push<K>(task.parent_force, impulses, -1.0, task.wrenches->parent);
  if (!task.values) return;
  write_derivative(task, joint, limited);
  write_force<K>(task, task.child_force, 1.0, task.blocks->from_child);
  write_force<K>(task, task.parent_force, -1.0, task.blocks->from_parent);
}

#define PHYSICS_BY_JOINT_ROWS(function, task)                                             \
  switch (task.kind) {                                                                    \
    case JointRows::spherical: return function<JointRows::spherical>(task);               \
    case JointRows::revolute: return function<JointRows::revolute>(task);                 \
    case JointRows::revolute_motor: return function<JointRows::revolute_motor>(task);     \
    case JointRows::prismatic: return function<JointRows::prismatic>(task);               \
    case JointRows::prismatic_motor: return function<JointRows::prismatic_motor>(task);   \
    case JointRows::fixed: return function<JointRows::fixed>(task);                       \
  }

void AimJoints(const JointTask& task) { PHYSICS_BY_JOINT_ROWS(aim, task) }
void EvaluateJoints(const JointTask& task) { PHYSICS_BY_JOINT_ROWS(evaluate, task) }

JointKernels Kernels() { return {.aim = AimJoints, .evaluate = EvaluateJoints}; }

}  // namespace
}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(Kernels);

JointKernels joint_kernels() {
  (void)graphsolve::simd::instruction_set();  // chosen now, if it was not yet
  return HWY_DYNAMIC_DISPATCH(Kernels)();
}

}  // namespace physics
#endif

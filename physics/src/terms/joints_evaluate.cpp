#include <algorithm>

#include "graphsolve/io/block_view.hpp"
#include "terms/joints.hpp"

/// Force directions of all joints, residual and blocks at the iterate: octets by kernels, forces one by one.
namespace physics {

void Joints::aim(std::span<const int> copies) {
  of_copies_.each(copies, [&](int octet, unsigned used) { aim_octet(octets_[octet], used, When::now); });
}

/// In place: tasks point there.
void Joints::put_back(const Aim& aim) {
  std::ranges::copy(aim.forces, forces_.begin());
  std::ranges::copy(aim.motors, motors_.begin());
  std::ranges::copy(aim.wrenches, wrenches_.begin());
}

void Joints::aim_octet(JointOctet& octet, unsigned used, When when) {
  point_at(octet, when);
  octet.task.used = used;
  kernels_.aim(octet.task);
}

void Joints::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  if (joints_.empty()) return;
  if (groups_.take(instances.index, instances.version, [&](int i) { return joints_[i].place; })) {
    for (JointOctet& octet : octets_) octet.running = 0;
    groups_.each_again([&](int octet, unsigned used) { octets_[octet].running = used; });
  }
  groups_.each_again([&](int octet, unsigned used) {
    JointOctet& o = octets_[octet];
    if (bodies_.force_at_next) aim_octet(o, used, When::next);
    point_at(o, When::next);
    o.task.used = used;
    o.task.dt = bodies_.dt;
    o.task.x = x.data();
    o.task.residual = residual.data();
    o.task.values = values;
    kernels_.evaluate(o.task);
  });
  push();
  bodies_.hand_out(residual);
  if (!values || !bodies_.force_at_next) return;
  for (const int i : instances.index)
    add_direction_derivative(joints_[i], Eigen::Map<const Vec3>(x.data() + joints_[i].row), values);
}

/// Poses: whole octets, or lane by lane.
void Joints::point_at(JointOctet& octet, When when) const {
  const auto point = [&](int whole, const auto& places, const Octet*& all, const double** lanes) {
    const auto poses = [&](int bodies) {
      return when == When::now ? bodies_.poses_now(bodies) : bodies_.poses_next(bodies);
    };
    if (whole >= 0) {
      all = poses(whole);
      return;
    }
    for (int l = 0; l < graphsolve::simd::lanes; ++l) lanes[l] = &poses(octet_of(places[l]))->lane[lane_of(places[l])];
  };
  point(octet.parents, octet.parent, octet.task.parents, octet.task.parent);
  point(octet.children, octet.child, octet.task.children, octet.task.child);
}

/// Forces on the bodies.
void Joints::push() {
  for (const Push& p : pushes_) {
    const unsigned used = octets_[p.octet].running;
    const Octet* wrench = p.on_parent ? wrenches_[p.octet].parent : wrenches_[p.octet].child;
    if (p.lane >= 0) {
      if (used >> p.lane & 1u) bodies_.push_one(p.body, wrench, p.lane);
    } else if (used != 0) {
      bodies_.push(p.body, used, wrench);
    }
  }
}

/// With directions at z_{k+2} the torque p x R^T impulse turns with the body. (Of the rows in all three axes of the
/// world only; the others are left to converge as they do without it.)
void Joints::add_direction_derivative(const Joint& joint, const Vec3& impulse, double* values) const {
  if (translations(joint.kind) != 3) return;
  const auto add = [&](int body, const Vec3& point, double sign) {
    if (body < 0) return;
    const NextPose pose = bodies_.pose_next(body);
    const Vec3 local = pose.rotation.transpose() * impulse;
    graphsolve::block_view(values, bodies_.block(body)).bottomRightCorner<3, 3>() -=
        sign * bodies_.dt * skew(point) * skew(local) * pose.turn;
  };
  add(joint.geometry.child, joint.geometry.child_point, 1);
  add(joint.geometry.parent, joint.geometry.parent_point, -1);
}

}  // namespace physics

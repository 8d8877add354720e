#include "graphsolve/io/block_view.hpp"
#include "joints.hpp"

/// Force directions of all joints, residual and blocks at the iterate: octets by kernels, forces one by one.
namespace physics {

void Joints::aim() {
  groups_.each(to_aim_, 0, [&](int i) { return joints_[i].place; }, [&](int octet, unsigned used) {
    JointTask task = task_of(octet, used);
    each_lane(octet, used, [&](int lane, int place) {
      const JointGeometry& g = joints_[joint_at_[place]].geometry;
      task.parent[lane] = bodies_.pose_now(g.parent).x.data();
      task.child[lane] = bodies_.pose_now(g.child).x.data();
    });
    kernels_.aim(task);
  });
  for (const int i : to_aim_) {
    const JointGeometry& g = joints_[i].geometry;
    keep_arm(joints_[i], bodies_.pose_now(g.parent), bodies_.pose_now(g.child));
  }
  to_aim_.clear();
}

void Joints::aim_at_next(std::span<const int> joints) {
  groups_.each(joints, 0, [&](int i) { return joints_[i].place; }, [&](int octet, unsigned used) {
    JointTask task = task_of(octet, used);
    NextRoom room{Bodies::NextRoom(bodies_), Bodies::NextRoom(bodies_)};
    point_at_next(task, octet, room);
    kernels_.aim(task);
  });
  for (const int i : joints) {
    const JointGeometry& g = joints_[i].geometry;
    keep_arm(joints_[i], bodies_.pose_next(g.parent), bodies_.pose_next(g.child));
  }
}

/// Where the recorded body stands as the force acts on it.
void Joints::keep_arm(Joint& joint, const Pose& parent, const Pose& child) {
  const Pose& recorded = joint.geometry.child >= 0 ? child : parent;
  joint.force_orientation = recorded.q;
  joint.force_arm = child.x + child.rotation * joint.geometry.child_point - recorded.x;
}

void Joints::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  if (bodies_.force_at_next) aim_at_next(instances.index);
  groups_.each(instances.index, instances.version, [&](int i) { return joints_[i].place; },
               [&](int octet, unsigned used) { evaluate_octet(octet, used, x, residual, values); });
  // In the order of the joints, whatever octets they are in: sums in bits depend on it.
  for (const int i : instances.index) add_forces(i, x, residual, values);
}

void Joints::evaluate_octet(int octet, unsigned used, std::span<const double> x, std::span<double> residual,
                            double* values) {
  JointTask task = task_of(octet, used);
  task.dt = bodies_.dt;
  task.values = values;
  task.blocks = &blocks_[octet];
  NextRoom room{Bodies::NextRoom(bodies_), Bodies::NextRoom(bodies_)};
  point_at_next(task, octet, room);
  each_lane(octet, used, [&](int lane, int place) {
    const int i = joint_at_[place];
    const Joint& joint = joints_[i];
    task.impulses[lane] = x.data() + joint.row;
    task.residual[lane] = residual.data() + joint.row;
    task.wrenches[lane] = wrenches_[i].data();
  });
  kernels_.evaluate(task);
}

/// At the poses of the present iterate: whole octets, or copies in `room`.
void Joints::point_at_next(JointTask& task, int octet, NextRoom& room) const {
  task.parents = octets_[octet].parents;
  task.children = octets_[octet].children;
  if (task.parents && task.children) return;
  each_lane(octet, task.used, [&](int lane, int place) {
    const JointGeometry& g = joints_[joint_at_[place]].geometry;
    if (!task.parents) task.parent[lane] = room.parents.at(lane, g.parent);
    if (!task.children) task.child[lane] = room.children.at(lane, g.child);
  });
}

/// What the octets leave out: forces on the bodies.
void Joints::add_forces(int i, std::span<const double> x, std::span<double> residual, double* values) {
  const Joint& joint = joints_[i];
  const double* wrench = wrenches_[i].data();
  if (joint.child_row >= 0)
    for (int k = 0; k < 6; ++k) residual[joint.child_row + k] -= wrench[k];
  if (joint.parent_row >= 0)
    for (int k = 0; k < 6; ++k) residual[joint.parent_row + k] -= wrench[6 + k];
  if (values && bodies_.force_at_next)
    add_direction_derivative(joint, Eigen::Map<const Vec3>(x.data() + joint.row), values);
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

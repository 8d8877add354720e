#include "mechanism/assembly.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "mechanism/start_pose.hpp"

namespace physics {

namespace {

/// Placement of the neighbour across a fixed joint: x_b + R_b p_b = x_a + R_a p_a, q_b = q_a orientation.
Placement across(const Placement& a, const Joint& joint, bool to_child) {
  Placement b{.body = a.body};
  if (to_child) {
    b.rotation = a.rotation * joint.orientation;
    b.offset = a.offset + a.rotation * joint.parent_point - b.rotation * joint.child_point;
  } else {
    b.rotation = a.rotation * joint.orientation.conjugate();
    b.offset = a.offset + a.rotation * joint.child_point - b.rotation * joint.parent_point;
  }
  return b;
}

struct Groups {
  std::vector<Placement> placement;
  std::vector<std::vector<int>> members;  ///< by rigid body
};

Groups group(const Mechanism& mechanism, bool merge) {
  const int n = static_cast<int>(mechanism.bodies.size());
  std::vector<std::vector<int>> fixed_at(n);
  std::vector<int> pending;
  Groups groups;
  groups.placement.resize(n);
  std::vector<char> placed(n, 0);
  const auto spread = [&] {
    while (!pending.empty()) {
      const int a = pending.back();
      pending.pop_back();
      for (const int j : fixed_at[a]) {
        const Joint& joint = mechanism.joints[j];
        if (joint.parent.is_world()) continue;
        const bool to_child = joint.parent.index == a;
        const int b = to_child ? joint.child.index : joint.parent.index;
        if (placed[b]) continue;
        groups.placement[b] = across(groups.placement[a], joint, to_child);
        placed[b] = 1;
        if (groups.placement[b].body >= 0) groups.members[groups.placement[b].body].push_back(b);
        pending.push_back(b);
      }
    }
  };
  if (merge) {
    for (int j = 0; j < static_cast<int>(mechanism.joints.size()); ++j) {
      const Joint& joint = mechanism.joints[j];
      if (joint.type != JointType::fixed) continue;
      fixed_at[joint.child.index].push_back(j);
      if (!joint.parent.is_world()) fixed_at[joint.parent.index].push_back(j);
    }
    for (const Joint& joint : mechanism.joints) {
      if (joint.type != JointType::fixed || !joint.parent.is_world() || placed[joint.child.index]) continue;
      groups.placement[joint.child.index] = across(Placement{}, joint, true);
      placed[joint.child.index] = 1;
      pending.push_back(joint.child.index);
      spread();
    }
  }
  for (int i = 0; i < n; ++i) {
    if (placed[i]) continue;
    placed[i] = 1;
    groups.placement[i] = {.body = static_cast<int>(groups.members.size())};
    groups.members.push_back({i});
    pending.push_back(i);
    spread();
  }
  return groups;
}

RigidBody compose(const Mechanism& mechanism, const std::vector<int>& members, std::vector<Placement>& placement) {
  const Body& first = mechanism.bodies[members.front()];
  RigidBody body{.name = first.name, .mass = 0, .inertia = Mat3::Zero(), .smallest_inertia = 0};
  placement[members.front()].leads = true;
  Vec3 centre = Vec3::Zero();
  for (const int i : members) {
    body.mass += mechanism.bodies[i].mass;
    centre += mechanism.bodies[i].mass * placement[i].offset;
  }
  centre /= body.mass;
  for (const int i : members) {
    Vec3& r = placement[i].offset;
    r -= centre;
    const Mat3 rotation = placement[i].rotation.toRotationMatrix();
    body.inertia += rotation * mechanism.bodies[i].inertia * rotation.transpose() +
                    mechanism.bodies[i].mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  body.smallest_inertia = Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return body;
}

/// Of a joint whose bodies fixed joints hold together: it must be closed where they are, for nothing will close it.
void check_held(const Mechanism& mechanism, int j, const Placement& a, const Placement& b) {
  const Joint& joint = mechanism.joints[j];
  const Frame parent{a.offset, a.rotation}, child{b.offset, b.rotation};
  const std::string place = fmt::format("joints[{}]", j);
  if (const double apart = gap(joint, parent, child); apart > largest_start_error)
    throw DescriptionError(fmt::format("joint '{}': its points are {:.3g} m apart, and fixed joints hold its bodies together",
                                       joint.name, apart), place);
  if (const double angle = bend(joint, parent, child); angle > largest_start_error)
    throw DescriptionError(fmt::format("joint '{}': its bodies are {:.3g} rad off its orientation, and other fixed joints "
                                       "hold them together", joint.name, angle), place);
}

}  // namespace

Assembly assemble(const Mechanism& mechanism, bool merge_fixed_joints) {
  Assembly result;
  Groups groups = group(mechanism, merge_fixed_joints);
  for (const auto& members : groups.members) result.bodies.push_back(compose(mechanism, members, groups.placement));
  result.placement = std::move(groups.placement);
  for (int j = 0; j < static_cast<int>(mechanism.joints.size()); ++j) {
    const Joint& joint = mechanism.joints[j];
    const Placement a = joint.parent.is_world() ? Placement{} : result.placement[joint.parent.index];
    const Placement& b = result.placement[joint.child.index];
    if (a.body == b.body) {  // both sides hang together already
      check_held(mechanism, j, a, b);
      continue;
    }
    result.joints.push_back({.source = j,
                             .type = joint.type,
                             .parent = a.body,
                             .child = b.body,
                             .parent_point = a.offset + a.rotation * joint.parent_point,
                             .child_point = b.offset + b.rotation * joint.child_point,
                             .axis = a.rotation * joint.axis,
                             .orientation = a.rotation * joint.orientation * b.rotation.conjugate()});
  }
  return result;
}

}  // namespace physics

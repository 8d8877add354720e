#include <algorithm>
#include <array>
#include <utility>

#include "terms/joints.hpp"
#include "simd/placement.hpp"

/// Where joints and their numbers lie, and what they write to.
namespace physics {

void Joints::wire(const graphsolve::Wiring& wiring) {
  if (joints_.empty()) return;
  std::vector<Placed> placed;
  for (Joint& joint : joints_) {
    // In the lane of the child, whose block with the joint mostly lies in the child's panel: read, pushed and written
    // whole.
    const int leads = joint.geometry.child >= 0 ? joint.geometry.child : joint.geometry.parent;
    placed.push_back({static_cast<int>(joint.kind), wiring.block(bodies_.node(leads), bodies_.node(leads))});
    joint.row = wiring.row(joint.nodes[0]);
    if (joint.geometry.parent >= 0) joint.parent_row = wiring.row(bodies_.node(joint.geometry.parent));
    if (joint.geometry.child >= 0) joint.child_row = wiring.row(bodies_.node(joint.geometry.child));
  }
  kernels_ = joint_kernels();
  move_to(places_in_octets(placed));
  find_blocks(wiring);
  find_neighbours();
  find_pushes();
  make_tasks();
  bodies_.let_joints_push();
}

/// Makes octets for these places, by joint. Motors and force directions come along from where they were.
void Joints::move_to(std::span<const int> places) {
  const int octets = octets_with(places);
  const auto octets_before = std::exchange(octets_, std::vector<JointOctet>(octets));
  const auto motors_before = std::exchange(motors_, {});
  const auto forces_before = std::exchange(forces_, {});
  points_.assign(octets, {});
  wrenches_.assign(octets, {});
  joint_at_.assign(octets * graphsolve::simd::lanes, -1);
  groups_.resize(octets);
  for (int i = 0; i < size(); ++i) {
    joint_at_[places[i]] = i;
    octets_[octet_of(places[i])].kind = joints_[i].kind;
  }
  of_copies_.wire(joint_at_);
  int frames = 0, motors = 0, forces = 0;
  for (JointOctet& octet : octets_) {
    if (octet.kind != JointRows::spherical) octet.frames = frames++;
    if (physics::has_motor(octet.kind)) octet.motor = motors++;
    octet.forces = forces;
    forces += 12 * physics::rows_of(octet.kind);
  }
  frames_.assign(frames, {});
  motors_.assign(motors, {});
  forces_.assign(forces, {});
  for (int i = 0; i < size(); ++i) {
    Joint& joint = joints_[i];
    const int before = std::exchange(joint.place, places[i]);
    set(i, joint.geometry, joint.motor);
    for (int r = 0; translations(joint.kind) == 3 && r < 3; ++r) {  // along world axes
      Octet* force = &forces_[octets_[octet_of(joint.place)].forces] + 7 * r;
      force[0][lane_of(joint.place)] = 1;
      force[6 * physics::rows_of(joint.kind)][lane_of(joint.place)] = -1;
    }
    if (before < 0) continue;
    const JointOctet &from = octets_before[octet_of(before)], &to = octets_[octet_of(joint.place)];
    const int from_lane = lane_of(before), to_lane = lane_of(joint.place);
    if (joint.motor) copy_lane(motors_before[from.motor], from_lane, motors_[to.motor], to_lane);
    for (int e = 0; e < 12 * physics::rows_of(joint.kind); ++e)
      forces_[to.forces + e][to_lane] = forces_before[from.forces + e][from_lane];
  }
}

void Joints::find_blocks(const graphsolve::Wiring& wiring) {
  blocks_.assign(octets_.size(), {});
  for (const Joint& joint : joints_) {
    const auto own = joint.nodes[0];
    const int lane = lane_of(joint.place);
    JointBlocks& blocks = blocks_[octet_of(joint.place)];
    blocks.own.set(lane, wiring.block(own, own));
    const auto connect = [&](int body, graphsolve::simd::LaneBlocks& to, graphsolve::simd::LaneBlocks& from) {
      if (body < 0) return;
      to.set(lane, wiring.claim(own, bodies_.node(body)));
      from.set(lane, wiring.claim(bodies_.node(body), own));
    };
    connect(joint.geometry.parent, blocks.to_parent, blocks.from_parent);
    connect(joint.geometry.child, blocks.to_child, blocks.from_child);
  }
  for (JointBlocks& blocks : blocks_)
    for (auto* some : {&blocks.own, &blocks.to_child, &blocks.from_child, &blocks.to_parent, &blocks.from_parent})
      some->finish();
}

/// Octets of bodies that lie in the lanes of their joints.
void Joints::find_neighbours() {
  for (int octet = 0; octet < static_cast<int>(octets_.size()); ++octet) {
    constexpr int lanes = graphsolve::simd::lanes;
    std::array<int, lanes> parent, child;
    for (int l = 0; l < lanes; ++l) {
      const int i = joint_at_[octet * lanes + l];
      parent[l] = i < 0 ? Bodies::nothing : joints_[i].geometry.parent;
      child[l] = i < 0 ? Bodies::nothing : joints_[i].geometry.child;
    }
    JointOctet& o = octets_[octet];
    o.parents = bodies_.octet_of_all(parent);
    o.children = bodies_.octet_of_all(child);
    each_lane(octet, lanes_used(octet), [&](int l, int place) {
      const Joint& joint = joints_[joint_at_[place]];
      o.task.rows[l] = joint.row;
      if (joint.geometry.child < 0) o.task.children_are_world |= 1u << l;
      o.parent[l] = bodies_.place_of(joint.geometry.parent);
      o.child[l] = bodies_.place_of(joint.geometry.child);
    });
  }
}

void Joints::make_tasks() {
  for (std::size_t k = 0; k < octets_.size(); ++k) {
    JointOctet& o = octets_[k];
    JointTask& task = o.task;
    task.kind = o.kind;
    task.points = &points_[k];
    task.frames = o.frames < 0 ? nullptr : &frames_[o.frames];
    task.motor = o.motor < 0 ? nullptr : &motors_[o.motor];
    task.child_force = &forces_[o.forces];
    task.parent_force = task.child_force + 6 * physics::rows_of(o.kind);
    task.wrenches = &wrenches_[k];
    task.stands = wrenches_[k].stands;
    task.blocks = &blocks_[k];
  }
}

unsigned Joints::lanes_used(int octet) const {
  unsigned used = 0;
  for (int l = 0; l < graphsolve::simd::lanes; ++l)
    if (joint_at_[octet * graphsolve::simd::lanes + l] >= 0) used |= 1u << l;
  return used;
}

/// Whole octets where there is an order of them that keeps that of the joints for every body; else lane by lane.
void Joints::find_pushes() {
  std::vector<Push> whole, single;
  std::vector<std::array<int, 2>> of_octet(octets_.size(), {-1, -1});  ///< among `whole`
  std::vector<std::array<int, 2>> of_joint(joints_.size(), {-1, -1});
  for (int i = 0; i < size(); ++i) {
    const int octet = octet_of(joints_[i].place);
    for (const int side : {0, 1}) {
      const int body = bodies_of(i)[side], beside = side ? octets_[octet].parents : octets_[octet].children;
      if (body < 0) continue;
      const Push push{octet, lane_of(joints_[i].place), bodies_.place_of(body), side == 1};
      single.push_back(push);
      int& number = beside < 0 ? of_joint[i][side] : of_octet[octet][side];
      if (number < 0) {
        number = static_cast<int>(whole.size());
        whole.push_back(beside < 0 ? push : Push{octet, -1, beside, side == 1});
      }
      of_joint[i][side] = number;
    }
  }
  // Each push waits for that of the joint before on the same body.
  std::vector<std::vector<int>> followers(whole.size());
  std::vector<int> waits_for(whole.size(), 0), last(bodies_.size(), -1), ready;
  for (int i = 0; i < size(); ++i)
    for (const int side : {0, 1}) {
      if (bodies_of(i)[side] < 0) continue;
      const int before = std::exchange(last[bodies_of(i)[side]], of_joint[i][side]);
      if (before < 0) continue;
      followers[before].push_back(of_joint[i][side]);
      ++waits_for[of_joint[i][side]];
    }
  for (std::size_t k = 0; k < whole.size(); ++k)
    if (waits_for[k] == 0) ready.push_back(static_cast<int>(k));
  for (std::size_t k = 0; k < ready.size(); ++k)
    for (const int next : followers[ready[k]])
      if (--waits_for[next] == 0) ready.push_back(next);
  if (ready.size() < whole.size()) {  // they wait for each other
    pushes_ = std::move(single);
    return;
  }
  pushes_.clear();
  for (const int k : ready) pushes_.push_back(whole[k]);
}

}  // namespace physics

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "stepper/stepper.hpp"

namespace physics {

namespace {

constexpr int lane_of_simulator[] = {0};

/// Looking begins a step at the present pose. What the last one left, which records tell forces by, is put back at the
/// end.
class Kept {
 public:
  explicit Kept(Stepper& stepper)
      : stepper_(stepper),
        aim_(stepper.joints.aim()),
        state_(stepper.lanes.front().state),
        unknowns_(stepper.unknowns),
        noise_(stepper.noise) {}
  ~Kept() {
    stepper_.joints.put_back(aim_);
    stepper_.lanes.front().state = state_;
    stepper_.unknowns = unknowns_;
    stepper_.noise = noise_;
  }
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;

 private:
  Stepper& stepper_;
  Joints::Aim aim_;
  LaneState state_;
  std::vector<double> unknowns_, noise_;
};

}  // namespace

/// Groups dependent joint rows: two that share a joint belong together.
std::vector<std::string> Simulator::redundancies() const {
  Impl& s = *impl_;
  const Lane& lane = s.lanes.front();
  const Kept kept(s);
  s.begin(lane_of_simulator, s.dt);
  // At rest: where velocities lead, joints are open by what curves, and their rows only nearly depend.
  for (int i = 0; i < s.bodies.size(); ++i) std::fill_n(s.unknowns.data() + s.bodies.row[i], 6, 0.0);
  for (int j = 0; j < s.joints.size(); ++j) s.joints.prepare(j, lane.time(1), s.dt);
  s.joints.aim(lane_of_simulator);
  (void)s.solver->factorize_terms(s.unknowns);  // rows that it drops are there whether or not a later pivot failed
  const auto& factorization = s.solver->factorization();
  std::vector<double> y(s.unknowns.size());
  struct Group {
    std::set<int> joints;
    int count = 0;
  };
  std::vector<Group> groups;
  for (const auto& dropped : factorization.dropped_rows()) {
    factorization.dependency(dropped, y);
    double largest = 0;
    for (int j = 0; j < s.joints.size(); ++j)
      for (int r = 0; r < s.joints.rows(j); ++r) largest = std::max(largest, std::abs(y[s.joints.row(j) + r]));
    Group group{.joints = {}, .count = 1};
    for (int j = 0; j < s.joints.size(); ++j)
      for (int r = 0; r < s.joints.rows(j); ++r)
        if (std::abs(y[s.joints.row(j) + r]) > 1e-6 * largest) group.joints.insert(s.joints.geometry(j).source);
    for (auto other = groups.begin(); other != groups.end();) {
      const bool shares = std::any_of(group.joints.begin(), group.joints.end(),
                                      [&](int j) { return other->joints.contains(j); });
      if (!shares) {
        ++other;
        continue;
      }
      group.joints.insert(other->joints.begin(), other->joints.end());
      group.count += other->count;
      other = groups.erase(other);
    }
    groups.push_back(std::move(group));
  }
  std::vector<std::string> sentences;
  for (const Group& group : groups) {
    std::string names;
    for (const int j : group.joints)
      names += (names.empty() ? "'" : ", '") + lane.mechanism.joints[j].name + "'";
    sentences.push_back(fmt::format("joints {} over-constrain the mechanism by {}", names, group.count));
  }
  return sentences;
}

}  // namespace physics

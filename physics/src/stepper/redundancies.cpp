#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "stepper/stepper.hpp"

namespace physics {

static constexpr int only[] = {0};  ///< the lane of a simulator

/// Groups dependent joint rows: two that share a joint belong together.
std::vector<std::string> Simulator::redundancies() const {
  Impl& s = *impl_;
  const Lane& lane = s.lanes.front();
  s.begin(only, s.dt);
  for (int j = 0; j < s.joints.size(); ++j) s.joints.prepare(j, lane.time(1), s.dt);
  s.joints.aim(only);
  const auto& factorization = s.solver->factorize_terms(s.unknowns);
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

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "factorization/given.hpp"
#include "graphsolve/symbolic.hpp"
#include "simd/program.hpp"

namespace graphsolve {

/// The components that take part in a call, and their way through the program.
class Participants {
 public:
  /// Nobody. The symbolic one must live as long.
  explicit Participants(const Symbolic& symbolic);

  [[nodiscard]] std::span<const int> everybody() const { return everybody_; }
  /// Throws std::invalid_argument where there is no such component, or one is named twice.
  void check(std::span<const int> components);
  void set(std::span<const int> components);
  /// From here on, in this call.
  void leave_out(int component);

  [[nodiscard]] std::span<const int> components() const { return components_; }
  [[nodiscard]] bool include(int pivot) const;
  /// Of a group of the program; bit 0 for a component alone.
  [[nodiscard]] unsigned lanes(std::size_t group) const { return lanes_[group]; }

  template <class F>
  void each_pivot(F&& f) const {
    for (const int c : components_)
      for (int k = symbolic_.component_begin(c); k < symbolic_.component_begin(c + 1); ++k) f(k);
  }
  /// whole(group, begin, end) for ranges of the values that the user gives where all of the group takes part, of_pivot(k)
  /// elsewhere.
  template <class Whole, class OfPivot>
  void each_extent(bool symmetric, Whole&& whole, OfPivot&& of_pivot) const;
  /// together(pack, lanes) and alone(pivot), in the order of the elimination or backward.
  template <class Together, class Alone>
  void walk(bool backward, Together&& together, Alone&& alone) const;

 private:
  const Symbolic& symbolic_;
  std::vector<int> everybody_, components_;
  std::vector<std::uint8_t> lanes_;  ///< by group of the program
  std::vector<char> named_;          ///< by component: while a list of them is checked
};

template <class Whole, class OfPivot>
void Participants::each_extent(bool symmetric, Whole&& whole, OfPivot&& of_pivot) const {
  const auto groups = symbolic_.program().groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (lanes_[g] == 0) continue;
    if (lanes_[g] == (1u << groups[g].copies) - 1) {
      whole(g, groups[g].begin, given_end(groups[g], symmetric));
      continue;
    }
    for (int c = 0; c < groups[g].copies; ++c) {
      if (!(lanes_[g] >> c & 1u)) continue;
      const int component = groups[g].component[c];
      for (int k = symbolic_.component_begin(component); k < symbolic_.component_begin(component + 1); ++k) of_pivot(k);
    }
  }
}

template <class Together, class Alone>
void Participants::walk(bool backward, Together&& together, Alone&& alone) const {
  const simd::Program& program = symbolic_.program();
  const auto groups = program.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool copies = groups[g].copies > 1;
    const auto steps = program.steps(groups[g]);
    // A lane that fails is taken out.
    for (std::size_t i = 0; i < steps.size() && lanes_[g] != 0; ++i) {
      const auto& step = steps[backward ? steps.size() - 1 - i : i];
      if (step.pack >= 0) {
        const unsigned used = program.pack(step.pack).used;
        together(step.pack, copies ? used & lanes_[g] : used);
      } else if (!copies || include(step.pivot)) {
        alone(step.pivot);
      }
    }
  }
}

}  // namespace graphsolve

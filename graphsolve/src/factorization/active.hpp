#pragma once

#include "factorization/impl.hpp"
#include "simd/program.hpp"

/// What of a factorization takes part in a call.
namespace graphsolve {

/// Where in a group the numbers end that the user gives: of a symmetric matrix one triangle.
inline std::int64_t given_end(const simd::Program::Group& group, bool symmetric) { return symmetric ? group.upper : group.end; }

template <class F>
void Factorization::Impl::each_active_pivot(F&& f) const {
  for (const int c : active_)
    for (int k = symbolic_->component_begin(c); k < symbolic_->component_begin(c + 1); ++k) f(k);
}

/// whole(group, begin, end) for ranges of the values that the user gives where all of the group takes part, of_pivot(k)
/// elsewhere.
template <class Whole, class OfPivot>
void Factorization::Impl::each_extent(Whole&& whole, OfPivot&& of_pivot) const {
  const Symbolic& s = *symbolic_;
  const auto groups = s.program().groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (lanes_[g] == 0) continue;
    if (lanes_[g] == (1u << groups[g].copies) - 1) {
      whole(g, groups[g].begin, given_end(groups[g], symmetric()));
      continue;
    }
    for (int c = 0; c < groups[g].copies; ++c) {
      if (!(lanes_[g] >> c & 1u)) continue;
      const int component = groups[g].component[c];
      for (int k = s.component_begin(component); k < s.component_begin(component + 1); ++k) of_pivot(k);
    }
  }
}

/// f(place) of every number of pivot k that the user gives.
template <class F>
void Factorization::Impl::each_given(int k, F&& f) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  for (std::int64_t i = 0; i < p.lower_scalars(); ++i) f(p.diagonal + i * p.stride);
  if (symmetric()) return;
  for (std::int64_t i = 0; i < p.upper_scalars(); ++i) f(p.upper + i * p.stride);
}

template <class F>
void Factorization::Impl::each_row(int component, F&& f) const {
  for (int k = symbolic_->component_begin(component); k < symbolic_->component_begin(component + 1); ++k) {
    const Symbolic::Pivot& p = symbolic_->pivot(k);
    for (int i = p.row; i < p.row + p.dimension; ++i) f(i);
  }
}

/// together(pack, lanes) and alone(pivot) for what takes part, in the order of the elimination or backward.
template <class Together, class Alone>
void Factorization::Impl::walk(bool backward, Together&& together, Alone&& alone) const {
  const simd::Program& program = symbolic_->program();
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
      } else if (!copies || takes_part(step.pivot)) {
        alone(step.pivot);
      }
    }
  }
}

}  // namespace graphsolve

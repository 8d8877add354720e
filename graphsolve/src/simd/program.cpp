#include "simd/program.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace graphsolve::simd {

namespace {

/// Steps from the leaves of the elimination tree.
std::vector<int> levels(const Symbolic& s) {
  std::vector<int> level(s.pivots(), 0);
  for (int k = 0; k < s.pivots(); ++k)
    if (const int parent = s.parent(k); parent >= 0) level[parent] = std::max(level[parent], level[k] + 1);
  return level;
}

bool fits(const Symbolic::Pivot& p) { return p.dimension <= largest_dimension && p.coupled_rows <= largest_front; }

}  // namespace

Program::Program(const Symbolic& s) {
  std::map<std::vector<int>, int> number;  // dimension and kind, then of each coupled block dimension and kind
  std::vector<int> shape(s.pivots(), -1), key;
  for (int k = 0; k < s.pivots(); ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    if (!fits(p)) continue;
    key.assign({p.dimension, (p.saddle ? 2 : 0) + (p.may_depend ? 1 : 0)});
    for (const int later : s.coupled(k)) key.insert(key.end(), {s.dimension(later), s.may_depend(later) ? 1 : 0});
    const auto [found, is_new] = number.try_emplace(key, static_cast<int>(shapes_.size()));
    if (is_new) add_shape(s, k);
    shape[k] = found->second;
  }
  const std::vector<int> level = levels(s);
  std::vector<int> order(s.pivots());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::tuple(level[a], shape[a], a) < std::tuple(level[b], shape[b], b);
  });
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && level[order[end]] == level[order[i]] && shape[order[end]] == shape[order[i]]) ++end;
    while (i < end) {
      const std::size_t some = std::min<std::size_t>(lanes, end - i);
      if (shape[order[i]] >= 0) {
        add_pack(s, shape[order[i]], std::span(order).subspan(i, some));
        i += some;
      } else {
        steps_.push_back({-1, order[i++]});
      }
    }
  }
  steps_.shrink_to_fit();
  packs_.shrink_to_fit();
  rows_.shrink_to_fit();
}

void Program::add_shape(const Symbolic& s, int k) {
  const Symbolic::Pivot& p = s.pivot(k);
  Shape shape{p.dimension, p.coupled_rows, p.saddle, p.may_depend, {}, {}, p.may_depend};
  for (const int later : s.coupled(k)) {
    shape.coupled.push_back(s.dimension(later));
    shape.coupled_may.push_back(s.may_depend(later) ? 1 : 0);
    shape.uncertain |= s.may_depend(later);
  }
  const int largest = shape.coupled.empty() ? 1 : *std::max_element(shape.coupled.begin(), shape.coupled.end());
  scratch_size_ = std::max(scratch_size_, lanes * (largest * largest + p.dimension * p.coupled_rows));
  shapes_.push_back(std::move(shape));
}

void Program::add_pack(const Symbolic& s, int shape, std::span<const int> pivots) {
  const Shape& form = shapes_[shape];
  PivotPack pack{.shape = shape, .used = (1u << pivots.size()) - 1, .pivot = {}, .factor = factor_size_,
                 .rows = static_cast<int>(rows_.size())};
  for (int l = 0; l < lanes; ++l) pack.pivot[l] = pivots[l < static_cast<int>(pivots.size()) ? l : 0];
  for (const int k : pack.pivot) rows_.push_back(s.row(k));
  for (int c = 0; c < form.couplings(); ++c)
    for (const int k : pack.pivot) rows_.push_back(s.row(s.coupled(k)[c]));
  factor_size_ += form.size() * lanes;
  steps_.push_back({static_cast<int>(packs_.size()), -1});
  packs_.push_back(pack);
}

std::int64_t Program::memory() const {
  return static_cast<std::int64_t>(sizeof(Program) + steps_.size() * sizeof(Step) + packs_.size() * sizeof(PivotPack) +
                                   shapes_.size() * sizeof(Shape) + rows_.size() * sizeof(int));
}

}  // namespace graphsolve::simd

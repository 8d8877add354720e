#include "simd/program.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "symbolic/operations.hpp"
#include "simd/bundles.hpp"

namespace graphsolve::simd {

namespace {

constexpr int alone = -1, in_dense_end = -2;  // instead of a shape

bool fits(const Symbolic& s, int k) {
  if (s.pivot(k).dimension > largest_dimension) return false;
  return std::ranges::all_of(s.coupled(k), [&](int later) { return s.dimension(later) <= largest_dimension; });
}

/// The structure of a component: equal for equal ones.
std::vector<int> signature(const Symbolic& s, int component, std::span<const int> shape) {
  std::vector<int> result;
  const int begin = s.component_begin(component);
  for (int k = begin; k < s.component_begin(component + 1); ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    result.insert(result.end(), {shape[k], p.dimension, p.saddle ? 1 : 0, p.may_depend ? 1 : 0, p.end - p.begin});
    for (const int later : s.coupled(k)) result.push_back(later - begin);
  }
  return result;
}

}  // namespace

/// Components of equal structure, and how one of them is eliminated.
struct Program::Class {
  std::vector<int> components;
  std::vector<Bundle> bundles;
};

Program::Program(const Symbolic& s, Packs packs) : group_of_(s.components(), -1), copy_of_(s.components(), 0), place_(s.pivots(), -1) {
  if (packs == Packs::off) {
    go_one_by_one(s);
    return;
  }
  find_shapes(s);
  // A remainder of copies goes side by side only if it fills its lanes better than a copy does by itself.
  constexpr int fewest_copies = 3;
  for (const Class& equal : classes(s)) {
    std::span<const int> rest = equal.components;
    while (static_cast<int>(rest.size()) >= fewest_copies) {
      const auto some = rest.first(std::min<std::size_t>(lanes, rest.size()));
      add_copies(s, equal, some);
      rest = rest.subspan(some.size());
    }
    for (const int component : rest) add_one(s, equal, component);
  }
  shape_of_ = std::vector<int>();
  shapes_.shrink_to_fit();
  steps_.shrink_to_fit();
  groups_.shrink_to_fit();
  packs_.shrink_to_fit();
  rows_.shrink_to_fit();
}

void Program::go_one_by_one(const Symbolic& s) {
  for (int k = 0; k < s.pivots(); ++k) {
    steps_.push_back({-1, k});
    place_[k] = ~s.row(k);
  }
  for (int c = 0; c < s.components(); ++c) {
    group_of_[c] = c;
    groups_.push_back({s.component_begin(c), s.component_begin(c + 1), 0, 0, 0, 1, {c}});
  }
  steps_.shrink_to_fit();
  groups_.shrink_to_fit();
}

void Program::find_shapes(const Symbolic& s) {
  std::map<std::vector<int>, int> number;  // dimension and kind, then of each coupled block dimension and kind
  std::vector<int> key;
  shape_of_.assign(s.pivots(), alone);
  for (int k = 0; k < s.pivots(); ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    if (p.coupled_rows > largest_front) shape_of_[k] = in_dense_end;
    if (shape_of_[k] == in_dense_end && p.parent >= 0) shape_of_[p.parent] = in_dense_end;
    if (shape_of_[k] == in_dense_end || !fits(s, k)) continue;
    key.assign({p.dimension, (p.saddle ? 2 : 0) + (p.may_depend ? 1 : 0)});
    for (const int later : s.coupled(k)) key.insert(key.end(), {s.dimension(later), s.may_depend(later) ? 1 : 0});
    const auto [found, is_new] = number.try_emplace(key, static_cast<int>(shapes_.size()));
    shape_of_[k] = found->second;
    if (!is_new) continue;
    Shape shape{.dimension = p.dimension, .coupled_rows = p.coupled_rows, .saddle = p.saddle,
                .may_depend = p.may_depend, .coupled = {}, .coupled_may = {},
                .operations = lu_pivot_operations(p.dimension, p.coupled_rows),
                .symmetric_operations = ldlt_pivot_operations(p.dimension, p.coupled_rows)};
    for (const int later : s.coupled(k)) {
      shape.coupled.push_back(s.dimension(later));
      shape.coupled_may.push_back(s.may_depend(later) ? 1 : 0);
    }
    shapes_.push_back(std::move(shape));
  }
}

std::vector<Program::Class> Program::classes(const Symbolic& s) const {
  std::vector<Class> result;
  std::map<std::vector<int>, int> number;
  for (int c = 0; c < s.components(); ++c) {
    int equal = static_cast<int>(result.size());
    if (s.components() > 1) equal = number.try_emplace(signature(s, c, shape_of_), equal).first->second;
    if (equal == static_cast<int>(result.size()))
      result.push_back({{}, bundles(s, s.component_begin(c), s.component_begin(c + 1), shape_of_)});
    result[equal].components.push_back(c);
  }
  return result;
}

void Program::add_one(const Symbolic& s, const Class& equal, int component) {
  const int first = static_cast<int>(steps_.size()), begin = s.component_begin(component);
  for (const Bundle& bundle : equal.bundles) {
    const int k = begin + bundle.first_pivot(), shape = shape_of_[k];
    if (shape == in_dense_end) continue;
    const bool lone = bundle.lanes == 1 && s.dimension(k) > largest_lone;
    if (shape < 0 || lone) {
      for (int l = 0; l < bundle.lanes; ++l)
        if (bundle.used >> l & 1u) steps_.push_back({-1, begin + bundle.pivot[l]});
      continue;
    }
    PivotPack pack{.shape = shape, .lanes = bundle.lanes, .used = bundle.used, .pivot = bundle.pivot};
    for (int& pivot : pack.pivot) pivot += begin;
    add_pack(s, pack);
  }
  add_dense_end(s, component);
  group_of_[component] = static_cast<int>(groups_.size());
  groups_.push_back({first, static_cast<int>(steps_.size()), 0, 0, 0, 1, {component}});
}

/// What couples to many, and all that follows it, last and in the order of the pivots: nothing of it lies interleaved with
/// others, and the factorization makes groups of it.
void Program::add_dense_end(const Symbolic& s, int component) {
  for (int k = s.component_begin(component); k < s.component_begin(component + 1); ++k)
    if (shape_of_[k] == in_dense_end) steps_.push_back({-1, k});
}

/// In the order in which the lanes of a single one are added up: what becomes of a component does not depend on how
/// many there are.
void Program::add_copies(const Symbolic& s, const Class& equal, std::span<const int> components) {
  const int first = static_cast<int>(steps_.size()), copies = static_cast<int>(components.size());
  Group group{first, 0, 0, 0, 0, copies, {}};
  for (int c = 0; c < copies; ++c) {
    group.component[c] = components[c];
    group_of_[components[c]] = static_cast<int>(groups_.size());
    copy_of_[components[c]] = static_cast<std::uint8_t>(c);
  }
  for (const Bundle& bundle : equal.bundles)
    for (int l = 0; l < bundle.lanes; ++l) {
      if (!(bundle.used >> l & 1u) || shape_of_[s.component_begin(components[0]) + bundle.pivot[l]] == in_dense_end) continue;
      PivotPack pack{.shape = shape_of_[s.component_begin(components[0]) + bundle.pivot[l]], .lanes = lanes_for(copies),
                     .used = (1u << copies) - 1, .pivot = {}};
      for (int c = 0; c < lanes; ++c)
        pack.pivot[c] = s.component_begin(components[c < copies ? c : 0]) + bundle.pivot[l];
      if (pack.shape >= 0) add_pack(s, pack);
      else
        for (int c = 0; c < copies; ++c) steps_.push_back({-1, pack.pivot[c]});
    }
  for (const int component : components) add_dense_end(s, component);
  group.end_step = static_cast<int>(steps_.size());
  groups_.push_back(group);
}

void Program::add_pack(const Symbolic& s, PivotPack pack) {
  const Shape& shape = shapes_[pack.shape];
  const int number = static_cast<int>(packs_.size());
  pack.pivots = std::popcount(pack.used);
  pack.kind = pack_kind(pack.lanes, shape.dimension);
  pack.rows = static_cast<int>(rows_.size());
  for (int l = 0; l < pack.lanes; ++l) {
    rows_.push_back(s.row(pack.pivot[l]));
    if (pack.used >> l & 1u) place_[pack.pivot[l]] = number * lanes + l;
  }
  for (int c = 0; c < shape.couplings(); ++c)
    for (int l = 0; l < pack.lanes; ++l) rows_.push_back(s.row(s.coupled(pack.pivot[l])[c]));
  scratch_size_ = std::max(scratch_size_, shape.size() * pack.lanes);
  steps_.push_back({number, -1});
  packs_.push_back(pack);
}

/// Where all lanes lie side by side, in one place; else lane by lane.
Target Program::target(const PivotPack& pack, std::span<const Target> of_lane) {
  const int first = std::countr_zero(pack.used), stride = of_lane[first].stride;
  // Room for all lanes, so that a register may be read and written whole.
  const std::int64_t place = of_lane[first].place - first;
  bool side_by_side = !pack.shares && place % stride + pack.lanes <= stride;
  for (int l = 0; l < pack.lanes; ++l)
    side_by_side &= !(pack.used >> l & 1u) || (of_lane[l].place == place + l && of_lane[l].stride == stride);
  if (side_by_side) return {place, stride};
  const auto begin = static_cast<std::int64_t>(scattered_.size());
  scattered_.insert(scattered_.end(), of_lane.begin(), of_lane.begin() + pack.lanes);
  return {~begin, 0};
}

/// In the order of the elimination.
void Program::place_rows(const Symbolic& s) {
  for (const Step& step : steps_) {
    if (step.pack < 0) {
      place_[step.pivot] = ~lane_rows_;
      lane_rows_ += s.dimension(step.pivot);
      continue;
    }
    PivotPack& pack = packs_[step.pack];
    lane_rows_ += -lane_rows_ & (pack.lanes - 1);  // to the next multiple
    pack.lane_rows = lane_rows_;
    lane_rows_ += shape(pack).dimension * pack.lanes;
  }
}

void Program::find_row_targets(const Symbolic& s, PivotPack& pack) {
  std::array<Target, lanes> of_lane{};
  pack.row_targets = static_cast<int>(row_targets_.size());
  for (int i = 0; i < shape(pack).couplings(); ++i) {
    for (int l = 0; l < pack.lanes; ++l) {
      const RowPlace rows = row_place(s.coupled(pack.pivot[l])[i]);
      of_lane[l] = {rows.first, rows.stride};
    }
    row_targets_.push_back(target(pack, of_lane));
  }
}

void Program::find_targets(const Symbolic& s) {
  if (s.packs() == Packs::on) place_rows(s);
  std::array<Target, lanes> of_lane{};
  std::vector<int> seen(s.pivots(), -1);  // last pack that couples to a pivot
  for (PivotPack& pack : packs_) {
    const int number = static_cast<int>(&pack - packs_.data()), first = std::countr_zero(pack.used);
    pack.place = s.pivot(pack.pivot[first]).diagonal - first;
    pack.upper = s.pivot(pack.pivot[first]).upper - first;
    for (int l = 0; l < pack.lanes; ++l) {
      if (!(pack.used >> l & 1u)) continue;
      for (const int later : s.coupled(pack.pivot[l])) pack.shares |= std::exchange(seen[later], number) == number;
    }
    if (pack.shares) scratch_size_ = std::max(scratch_size_, (shape(pack).size() + shape(pack).coupled_rows * shape(pack).coupled_rows) * pack.lanes);
    find_row_targets(s, pack);
    const int m = shape(pack).couplings();
    pack.targets = static_cast<int>(targets_.size());
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) {
        for (int l = 0; l < pack.lanes; ++l) {
          const Symbolic::Pivot& p = s.pivot(pack.pivot[l]);
          of_lane[l] = {s.targets(p)[i * p.target_stride + j], s.pivot(s.coupled(pack.pivot[l])[std::min(i, j)]).stride};
        }
        targets_.push_back(target(pack, of_lane));
      }
  }
  targets_.shrink_to_fit();
  row_targets_.shrink_to_fit();
  scattered_.shrink_to_fit();
}

std::int64_t Program::memory() const {
  std::int64_t couplings = 0;
  for (const Shape& shape : shapes_) couplings += shape.couplings();
  return static_cast<std::int64_t>(sizeof(Program) + steps_.size() * sizeof(Step) + groups_.size() * sizeof(Group) +
                                   group_of_.size() * (sizeof(int) + 1) + packs_.size() * sizeof(PivotPack) +
                                   shapes_.size() * sizeof(Shape) + (place_.size() + rows_.size()) * sizeof(int) +
                                   (targets_.size() + row_targets_.size() + scattered_.size()) * sizeof(Target)) +
         couplings * static_cast<std::int64_t>(sizeof(int) + sizeof(char));
}

}  // namespace graphsolve::simd

#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/symbolic.hpp"

/// The elimination as a program for packs: pivots of one shape at one level of the elimination tree do not depend on
/// each other, so up to eight of them are factored as one. Worked out once, immutable, shared by threads.
namespace graphsolve::simd {

/// Larger pivots have enough to do inside and go alone, and so do those coupled to larger ones.
inline constexpr int largest_dimension = 16;
inline constexpr int largest_front = 32;  ///< coupled rows; beyond, few pivots of a level are equal: a dense end begins
inline constexpr int largest_lone = 6;    ///< dimension of a pivot that is packed though no other is equal
inline constexpr int largest_factor = largest_dimension * (largest_dimension + 2 * largest_front);  ///< scalars

/// Pivots are of one shape when their blocks and those coupled to them agree in size, and in whether their rows may
/// depend.
struct Shape {
  int dimension;
  int coupled_rows;
  bool saddle;               ///< all of its pivots are saddle blocks (else none is)
  bool may_depend;
  std::vector<int> coupled;       ///< dimensions of the coupled blocks
  std::vector<char> coupled_may;  ///< may their rows depend?
  std::int64_t operations;            ///< to eliminate one of its pivots, of LDU
  std::int64_t symmetric_operations;  ///< of LDL^T or Cholesky
  [[nodiscard]] int couplings() const { return static_cast<int>(coupled.size()); }
  /// Scalars of the factor: D, L, and U.
  [[nodiscard]] int size() const { return lower_size() + upper_size(); }
  [[nodiscard]] int lower_size() const { return dimension * (dimension + coupled_rows); }
  [[nodiscard]] int upper_size() const { return dimension * coupled_rows; }
};

/// Kinds of packs that have code of their own: by lanes, and by dimension up to that of a pivot that is packed alone; what is
/// larger shares code, as dimension 0.
inline constexpr int pack_dimensions = largest_lone + 1, pack_kinds = 4 * pack_dimensions;
constexpr int pack_kind(int width, int dimension) {
  return std::countr_zero(static_cast<unsigned>(width)) * pack_dimensions + (dimension <= largest_lone ? dimension : 0);
}

/// Pivots in lanes. Scalar i of the diagonal block and of those below, in lane l, lies at values[place + i lanes + l], of those
/// to the right at values[upper + i lanes + l]: blocks of the matrix are written there, and become those of the factor. Lanes
/// without a pivot repeat one that is used, in `pivot`; their scalars mean nothing.
struct PivotPack {
  int shape;
  int lanes;                           ///< 1, 2, 4 or 8
  unsigned used;                       ///< bit per lane that has a pivot
  std::array<int, simd::lanes> pivot;
  int pivots = 0;                      ///< how many lanes are used
  int kind = 0;                        ///< pack_kind
  bool shares = false;                 ///< do several of its pivots couple to one and the same?
  std::int64_t place = -1, upper = -1;
  int rows = 0;                        ///< first of lanes * (1 + couplings) entries in Program::rows
  int targets = 0;                     ///< first of couplings^2 entries in Program::targets
  int lane_rows = 0;                   ///< of a vector in lanes: row r of lane l lies at lane_rows + r lanes + l
  int row_targets = 0;                 ///< first of couplings entries in Program::row_targets
};

/// Blocks that the lanes of a pack change, or rows that they see: lane l's from place + l on, its scalars `stride` apart.
/// Where they do not lie side by side like that, place is ~ of the first of as many entries in Program::scattered() as
/// there are lanes.
struct Target {
  std::int64_t place;
  int stride;
};

/// Where the rows of a pivot lie in a vector in lanes: the first, and how far apart they are.
struct RowPlace {
  int first, stride;
};

class Program {
 public:
  Program(const Symbolic& symbolic, Packs packs);

  /// One thing to do: the pack of this number, or, if pack < 0, one pivot by itself.
  struct Step {
    int pack;
    int pivot;
  };
  /// Components that are eliminated together: one, or up to eight of equal structure, each in a lane of every pack.
  struct Group {
    int first_step, end_step;
    std::int64_t begin, upper, end;  ///< of its part of the values; from `upper` on blocks to the right of pivots
    int copies;
    std::array<int, simd::lanes> component;
  };
  [[nodiscard]] std::span<const Group> groups() const { return groups_; }
  [[nodiscard]] int group_of(int component) const { return group_of_[component]; }
  /// Which of the copies in its group a component is, as a bit.
  [[nodiscard]] unsigned copy_bit(int component) const { return 1u << copy_of_[component]; }
  [[nodiscard]] std::span<const Step> steps() const { return steps_; }
  [[nodiscard]] std::span<const Step> steps(const Group& g) const {
    return std::span(steps_).subspan(g.first_step, g.end_step - g.first_step);
  }
  [[nodiscard]] const PivotPack& pack(int i) const { return packs_[i]; }
  [[nodiscard]] int packs() const { return static_cast<int>(packs_.size()); }
  [[nodiscard]] const Shape& shape(const PivotPack& pack) const { return shapes_[pack.shape]; }
  /// Pack and lane of a pivot, as pack * 8 + lane; negative for one that goes by itself.
  [[nodiscard]] int place(int pivot) const { return place_[pivot]; }
  /// First row, in the user's numbering, of each lane's pivot, then of each lane's first coupled block, and so on.
  [[nodiscard]] const int* rows(const PivotPack& pack) const { return rows_.data() + pack.rows; }
  /// A vector in lanes: rows lie as the pivots do, those of a pack interleaved. Unused lanes have a place too. Without packs
  /// it is the user's.
  [[nodiscard]] int lane_rows() const { return lane_rows_; }
  [[nodiscard]] RowPlace row_place(int pivot) const {
    const int place = place_[pivot];
    if (place < 0) return {~place, 1};
    const PivotPack& pack = packs_[place / lanes];
    return {pack.lane_rows + place % lanes, pack.lanes};
  }
  /// By pivot; of one that goes by itself ~ of its first row in such a vector.
  [[nodiscard]] const int* places() const { return place_.data(); }
  /// The rows of such a vector that belong to the couplings.
  [[nodiscard]] const Target* row_targets(const PivotPack& pack) const { return row_targets_.data() + pack.row_targets; }
  /// The blocks between couplings i and j at [i couplings + j].
  [[nodiscard]] const Target* targets(const PivotPack& pack) const { return targets_.data() + pack.targets; }
  [[nodiscard]] const Target* scattered() const { return scattered_.data(); }
  [[nodiscard]] int scratch_size() const { return scratch_size_; }  ///< doubles, for the largest pack
  [[nodiscard]] std::int64_t memory() const;                        ///< bytes

  // While the plan is made.
  void set_extent(int group, std::int64_t begin, std::int64_t upper, std::int64_t end) {
    groups_[group].begin = begin;
    groups_[group].upper = upper;
    groups_[group].end = end;
  }
  /// After all blocks have found their places.
  void find_targets(const Symbolic& symbolic);

 private:
  struct Class;
  void go_one_by_one(const Symbolic& symbolic);
  void find_shapes(const Symbolic& symbolic);
  [[nodiscard]] std::vector<Class> classes(const Symbolic& symbolic) const;
  void add_one(const Symbolic& symbolic, const Class& equal, int component);
  void add_copies(const Symbolic& symbolic, const Class& equal, std::span<const int> components);
  void add_dense_end(const Symbolic& symbolic, int component);
  void add_pack(const Symbolic& symbolic, PivotPack pack);
  void place_rows(const Symbolic& symbolic);
  void find_row_targets(const Symbolic& symbolic, PivotPack& pack);
  [[nodiscard]] Target target(const PivotPack& pack, std::span<const Target> of_lane);

  std::vector<Step> steps_;
  std::vector<Group> groups_;
  std::vector<int> group_of_;          ///< by component
  std::vector<std::uint8_t> copy_of_;  ///< by component
  std::vector<PivotPack> packs_;
  std::vector<Shape> shapes_;
  std::vector<int> shape_of_;  ///< by pivot; only while the plan is made
  std::vector<int> place_;     ///< by pivot; of one that goes by itself ~ of its first row in a vector in lanes
  std::vector<int> rows_;
  std::vector<Target> targets_, row_targets_, scattered_;
  int scratch_size_ = 0, lane_rows_ = 0;
};

}  // namespace graphsolve::simd

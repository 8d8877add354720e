#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/symbolic.hpp"

/// The elimination as a program for packs: pivots of one shape at one level of the elimination tree do not depend on
/// each other, so eight of them are factored as one. Worked out once, immutable, shared by threads.
namespace graphsolve::simd {

/// Larger pivots have enough to do inside and go alone.
inline constexpr int largest_dimension = 16;
inline constexpr int largest_front = 32;  ///< coupled rows; beyond, few pivots of a level are equal
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
  bool uncertain;                 ///< may any rows, its own or those of coupled blocks?
  [[nodiscard]] int couplings() const { return static_cast<int>(coupled.size()); }
  /// Packs of the factor: D as LU, L, and D^-1 U, which the symmetric kinds do without.
  [[nodiscard]] std::int64_t size() const {
    return static_cast<std::int64_t>(dimension) * (dimension + 2 * coupled_rows);
  }
};

/// One to eight pivots in lanes; lanes without a pivot repeat lane 0 and write nothing. A single pivot is a pack too: what
/// becomes of it in bits does not depend on its company.
struct PivotPack {
  int shape;
  unsigned used;                  ///< bit per lane that has a pivot
  std::array<int, lanes> pivot;
  std::int64_t factor;            ///< place of its factor, in doubles
  int rows;                       ///< first of lanes * (1 + couplings) entries in Program::rows
};

class Program {
 public:
  explicit Program(const Symbolic& symbolic);

  /// One thing to do: the pack of this number, or, if pack < 0, one pivot by itself.
  struct Step {
    int pack;
    int pivot;
  };
  [[nodiscard]] std::span<const Step> steps() const { return steps_; }
  [[nodiscard]] const PivotPack& pack(int i) const { return packs_[i]; }
  [[nodiscard]] int packs() const { return static_cast<int>(packs_.size()); }
  [[nodiscard]] const Shape& shape(const PivotPack& pack) const { return shapes_[pack.shape]; }
  /// First row, in the user's numbering, of each lane's pivot, then of each lane's first coupled block, and so on.
  [[nodiscard]] const int* rows(const PivotPack& pack) const { return rows_.data() + pack.rows; }
  [[nodiscard]] std::int64_t factor_size() const { return factor_size_; }  ///< doubles
  [[nodiscard]] int scratch_size() const { return scratch_size_; }         ///< doubles
  [[nodiscard]] std::int64_t memory() const;                               ///< bytes, without the factor

 private:
  void add_shape(const Symbolic& symbolic, int pivot);
  void add_pack(const Symbolic& symbolic, int shape, std::span<const int> pivots);

  std::vector<Step> steps_;
  std::vector<PivotPack> packs_;
  std::vector<Shape> shapes_;
  std::vector<int> rows_;
  std::int64_t factor_size_ = 0;
  int scratch_size_ = 0;
};

}  // namespace graphsolve::simd

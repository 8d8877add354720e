#pragma once

#include <hwy/aligned_allocator.h>

#include <span>
#include <vector>

#include "simd/program.hpp"

namespace graphsolve::simd {

/// The factors of all packs of a program, and which of their pivots had to be done alone instead.
class PackedFactor {
 public:
  explicit PackedFactor(const Symbolic& symbolic);

  /// Is the factor of this pivot in a pack (or with the values, as the scalar elimination leaves it)?
  [[nodiscard]] bool packed(int pivot) const { return packed_[pivot] != 0; }
  void set_alone(int pivot) { packed_[pivot] = 0; }

  /// Eliminates a pack for the lanes in `active`; the lanes returned need exchanges of rows and were left alone.
  unsigned eliminate(const PivotPack& pack, double* values, double saddle_shift, unsigned active);
  /// Lanes of the pack whose factor is here.
  [[nodiscard]] unsigned present(const PivotPack& pack) const;
  void solve_forward(const PivotPack& pack, double* x, unsigned active) const;
  void solve_backward(const PivotPack& pack, double* x, unsigned active) const;

  /// D as LU without exchanges, L, D^-1 U of a packed pivot, as the scalar elimination would have left them.
  void copy(int pivot, double* to) const;

 private:
  const Symbolic& symbolic_;
  const Program& program_;
  std::vector<char> packed_;  ///< by pivot
  std::vector<int> place_;    ///< by pivot: pack * lanes + lane, or -1
  hwy::AlignedFreeUniquePtr<double[]> factor_, scratch_;
};

}  // namespace graphsolve::simd

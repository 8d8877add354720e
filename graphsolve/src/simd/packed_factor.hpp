#pragma once

#include <hwy/aligned_allocator.h>

#include <cstdint>
#include <vector>

#include "simd/pivot_kernels.hpp"

namespace graphsolve::simd {

/// Numbers that eliminations read and write, and how.
struct PackData {
  double *values, *reference;  ///< as in PackJob
  const int* first_row;
  double saddle_shift;
  Watch watch;                 ///< symmetric form; the other has nothing to watch
};

/// The factors of all packs of a program, and which of their pivots had to be done alone instead.
class PackedFactor {
 public:
  enum class Form { general, symmetric };
  PackedFactor(const Symbolic& symbolic, Form form);

  /// Is the factor of this pivot in a pack (or with the values, as the scalar elimination leaves it)?
  [[nodiscard]] bool packed(int pivot) const {
    const int place = place_[pivot];
    return place >= 0 && (present_[place / lanes] >> place % lanes & 1u) != 0;
  }
  void set_alone(int pivot) {
    if (const int place = place_[pivot]; place >= 0)
      present_[place / lanes] &= static_cast<std::uint8_t>(~(1u << place % lanes));
  }

  /// Can pivots of this shape be eliminated in packs? Rows that may depend are looked after in the symmetric form only.
  [[nodiscard]] bool takes(const Shape& shape) const { return form_ == Form::symmetric || !shape.uncertain; }
  /// Eliminates pack i for the lanes in `active`. If some of these need exchanges of rows, they are returned, and
  /// nothing was done.
  unsigned eliminate(int i, const PackData& data, const Definite& definite, unsigned active);
  /// Lanes of the pack whose factor is here.
  [[nodiscard]] unsigned present(int i) const { return present_[i]; }
  void solve_forward(int i, double* x, unsigned active) const { simd::solve_forward(solve_job(i, x, active)); }
  void solve_backward(int i, double* x, unsigned active) const {
    if (form_ == Form::symmetric) simd::solve_backward_symmetric(solve_job(i, x, active));
    else simd::solve_backward(solve_job(i, x, active));
  }

  /// D as LU without exchanges, L, and in the general form D^-1 U of a packed pivot, as the scalar elimination would
  /// have left them.
  void copy(int pivot, double* to) const;

 private:
  [[nodiscard]] PackSolve solve_job(int i, double* x, unsigned active) const {
    const PivotPack& pack = program_.pack(i);
    return {.shape = program_.shape(pack), .pack = pack, .rows = program_.rows(pack),
            .factor = factor_.get() + pack.factor, .x = x, .active = active};
  }

  const Symbolic& symbolic_;
  const Program& program_;
  Form form_;
  std::vector<std::uint8_t> present_;  ///< by pack: a bit per lane
  std::vector<int> place_;             ///< by pivot: pack * lanes + lane, or -1
  hwy::AlignedFreeUniquePtr<double[]> factor_, scratch_;
};

}  // namespace graphsolve::simd

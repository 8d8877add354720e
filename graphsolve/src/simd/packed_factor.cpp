#include "simd/packed_factor.hpp"

#include "simd/pivot_kernels.hpp"

namespace graphsolve::simd {

PackedFactor::PackedFactor(const Symbolic& symbolic)
    : symbolic_(symbolic),
      program_(symbolic.program()),
      packed_(symbolic.pivots(), 0),
      place_(symbolic.pivots(), -1),
      factor_(hwy::AllocateAligned<double>(program_.factor_size() + lanes)),
      scratch_(hwy::AllocateAligned<double>(program_.scratch_size() + lanes)) {
  (void)instruction_set();  // chosen before the first kernel runs
  for (int i = 0; i < program_.packs(); ++i) {
    const PivotPack& pack = program_.pack(i);
    for (int l = 0; l < lanes; ++l)
      if (pack.used >> l & 1u) place_[pack.pivot[l]] = i * lanes + l;
  }
}

unsigned PackedFactor::eliminate(const PivotPack& pack, double* values, double saddle_shift, unsigned active) {
  const unsigned alone = simd::eliminate({.symbolic = symbolic_,
                                          .shape = program_.shape(pack),
                                          .pack = pack,
                                          .values = values,
                                          .factor = factor_.get() + pack.factor,
                                          .scratch = scratch_.get(),
                                          .saddle_shift = saddle_shift,
                                          .active = active});
  for (int l = 0; l < lanes; ++l)
    if (active >> l & 1u) packed_[pack.pivot[l]] = (alone >> l & 1u) == 0;
  return alone;
}

unsigned PackedFactor::present(const PivotPack& pack) const {
  unsigned found = 0;
  for (int l = 0; l < lanes; ++l)
    if (pack.used >> l & 1u) found |= static_cast<unsigned>(packed_[pack.pivot[l]]) << l;
  return found;
}

void PackedFactor::solve_forward(const PivotPack& pack, double* x, unsigned active) const {
  simd::solve_forward({.shape = program_.shape(pack),
                       .pack = pack,
                       .rows = program_.rows(pack),
                       .factor = factor_.get() + pack.factor,
                       .x = x,
                       .active = active});
}

void PackedFactor::solve_backward(const PivotPack& pack, double* x, unsigned active) const {
  simd::solve_backward({.shape = program_.shape(pack),
                        .pack = pack,
                        .rows = program_.rows(pack),
                        .factor = factor_.get() + pack.factor,
                        .x = x,
                        .active = active});
}

void PackedFactor::copy(int pivot, double* to) const {
  const PivotPack& pack = program_.pack(place_[pivot] / lanes);
  const double* from = factor_.get() + pack.factor + place_[pivot] % lanes;
  const std::int64_t size = program_.shape(pack).size();
  for (std::int64_t i = 0; i < size; ++i) to[i] = from[i * lanes];
}

}  // namespace graphsolve::simd

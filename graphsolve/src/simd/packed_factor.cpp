#include "simd/packed_factor.hpp"

namespace graphsolve::simd {

PackedFactor::PackedFactor(const Symbolic& symbolic, Form form)
    : symbolic_(symbolic),
      program_(symbolic.program()),
      form_(form),
      present_(program_.packs(), 0),
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

unsigned PackedFactor::eliminate(int i, const PackData& data, const Definite& definite, unsigned active) {
  const PivotPack& pack = program_.pack(i);
  const PackJob job{.symbolic = symbolic_,
                    .shape = program_.shape(pack),
                    .pack = pack,
                    .values = data.values,
                    .factor = factor_.get() + pack.factor,
                    .scratch = scratch_.get(),
                    .reference = data.reference,
                    .first_row = data.first_row,
                    .saddle_shift = data.saddle_shift,
                    .active = active};
  const unsigned alone =
      form_ == Form::symmetric ? simd::eliminate_symmetric(job, definite, data.watch) : simd::eliminate(job);
  if (alone == 0) present_[i] = static_cast<std::uint8_t>(present_[i] | active);
  return alone;
}

void PackedFactor::copy(int pivot, double* to) const {
  const PivotPack& pack = program_.pack(place_[pivot] / lanes);
  const Shape& shape = program_.shape(pack);
  const double* from = factor_.get() + pack.factor + place_[pivot] % lanes;
  const int size = shape.dimension * (shape.dimension + (form_ == Form::symmetric ? 1 : 2) * shape.coupled_rows);
  for (int i = 0; i < size; ++i) to[i] = from[i * lanes];
}

}  // namespace graphsolve::simd

// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_SPREAD_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_SPREAD_INL_HPP_
#undef GRAPHSOLVE_SIMD_SPREAD_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_SPREAD_INL_HPP_
#endif

#include <cmath>
#include <cstdint>

#include "factorization/kernels.hpp"
#include "simd/rows-inl.hpp"

/// Products of an L with a W that lies spread, block row by block row, as kernels.hpp describes them.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::kernels::HWY_NAMESPACE {

/// How the S^2 numbers of a block are worked on: so many in registers of their own, and the rest, one at most, with those of
/// three other blocks. A spread W has for every four blocks and every p the numbers that column p of an L is multiplied
/// by: first those of the registers, block after block, then the rest of all four.
template <int S>
struct Parts {
  static constexpr int square = S * S, own = square & ~3, rest = square - own, four = spread_row(S);
};

/// The own numbers of a block whose columns are all this one: column[e % S].
template <int S>
HWY_INLINE Rows<Parts<S>::own> every_column(const double* column) {
#if HWY_TARGET <= HWY_AVX3
  if constexpr (S == 3) {
    using Eight = hn::CappedTag<double, 8>;
    alignas(64) static constexpr std::int64_t from[8] = {0, 1, 2, 0, 1, 2, 0, 1};
    Rows<8> r;
    r.head = hn::TableLookupLanes(hn::MaskedLoad(hn::FirstN(Eight(), 3), Eight(), column), hn::SetTableIndices(Eight(), from));
    return r;
  }
#endif
  double tile[Parts<S>::own + 1];
#pragma GCC unroll 16
  for (int e = 0; e < Parts<S>::own; ++e) tile[e] = column[e % S];
  return Rows<Parts<S>::own>::load(tile);
}

/// The own numbers of a block whose rows are all this one: row[e / S].
template <int S>
HWY_INLINE Rows<Parts<S>::own> every_row(const Rows<S>& row) {
#if HWY_TARGET <= HWY_AVX3
  if constexpr (S == 3) {
    using Eight = hn::CappedTag<double, 8>;
    alignas(64) static constexpr std::int64_t from[8] = {0, 0, 0, 1, 1, 1, 2, 2};
    const auto three = hn::Combine(Together(), hn::Set(Pair(), hn::GetLane(row.tail.head)), row.head);
    Rows<8> r;
    r.head = hn::TableLookupLanes(hn::ZeroExtendVector(Eight(), three), hn::SetTableIndices(Eight(), from));
    return r;
  }
#endif
  double one[S], tile[Parts<S>::own + 1];
  row.store(one);
#pragma GCC unroll 16
  for (int e = 0; e < Parts<S>::own; ++e) tile[e] = one[e / S];
  return Rows<Parts<S>::own>::load(tile);
}

template <int S>
void spread(const double* HWY_RESTRICT w, double* HWY_RESTRICT to, int d, int blocks, int begin, int depth) {
  using P = Parts<S>;
  for (int j = 0; j < blocks; ++j, w += S * d) {
    double* place = to + (static_cast<std::ptrdiff_t>(j / 4) * depth + begin) * P::four;
    const int b = j % 4;
    for (int p = 0; p < d; ++p, place += P::four) {
#pragma GCC unroll 16
      for (int e = 0; e < P::own; ++e) place[b * P::own + e] = w[e / S * d + p];
      if (P::rest) place[4 * P::own + b] = w[(S - 1) * d + p];
    }
  }
}

/// As HalveAndSpread describes it.
template <int S>
void halve_and_spread(const double* a, double* lower, double* l, std::ptrdiff_t next, double* HWY_RESTRICT to, int blocks, int begin, int depth) {
  using P = Parts<S>;
  for (int j = 0; j < blocks; ++j, lower += S * S, l += next) {
    double* place = to + (static_cast<std::ptrdiff_t>(j / 4) * depth + begin) * P::four;
    const int b = j % 4;
    Rows<S> x[S];
#pragma GCC unroll 4
    for (int q = 0; q < S; ++q) x[q] = Rows<S>::load(lower + q * S);
#pragma GCC unroll 4
    for (int p = 0; p < S; ++p)
#pragma GCC unroll 4
      for (int q = p + 1; q < S; ++q) x[q].subtract(x[p], a[p * S + q]);
#pragma GCC unroll 4
    for (int q = 0; q < S; ++q, place += P::four) {
      every_row<S>(x[q]).store(place + b * P::own);
      if (P::rest) place[4 * P::own + b] = x[q].last();
      const Rows<S> half = x[q].times(a[q * (S + 1)]);
      half.store(lower + q * S);
      half.store(l + q * S);
    }
  }
}

/// The blocks [begin, end) of a row lose `some` columns of L times their part of W; D: as many columns, known here.
template <int S, int D>
HWY_INLINE void part_of_row(double* values, const std::int64_t* target, const double* l, const double* spread_w, int depth,
                            int begin, int end, int some_) {
  using P = Parts<S>;
  using Own = Rows<P::own>;
  using Rest = Rows<P::rest>;
  constexpr int largest = D ? D : at_once;
  const int some = D ? D : some_;
  Own left[largest];
  double last[largest];
  for (int p = 0; p < some; ++p) {
    left[p] = every_column<S>(l + p * S);
    last[p] = l[p * S + S - 1];
  }
  const auto one = [&](int j) {
    const double* w = spread_w + static_cast<std::ptrdiff_t>(j / 4) * depth * P::four;
    const int b = j % 4;
    double* to = values + target[j];
    Own sum = Own::load(to);
    Rest rest = Rest::load(to + P::own);
#pragma GCC unroll 12
    for (int p = 0; p < some; ++p, w += P::four) {
      sum.subtract_each(left[p], Own::load(w + b * P::own));
      rest.subtract(Rest::load(w + 4 * P::own + b), last[p]);
    }
    sum.store(to);
    rest.store(to + P::own);
  };
  int j = begin;
  if constexpr (hn::MaxLanes(Together()) == 4) {
    for (; j < end && j % 4 != 0; ++j) one(j);
    for (; j + 4 <= end; j += 4) {
      const double* w = spread_w + static_cast<std::ptrdiff_t>(j / 4) * depth * P::four;
      double* to[4];
      Own sum[4];
#pragma GCC unroll 4
      for (int b = 0; b < 4; ++b) {
        to[b] = values + target[j + b];
        sum[b] = Own::load(to[b]);
      }
      auto rest = hn::Zero(Together());
      if constexpr (P::rest > 0) rest = load_row(Together(), to, P::own);
#pragma GCC unroll 12
      for (int p = 0; p < some; ++p, w += P::four) {
#pragma GCC unroll 4
        for (int b = 0; b < 4; ++b) sum[b].subtract_each(left[p], Own::load(w + b * P::own));
        if constexpr (P::rest > 0)
          rest = hn::NegMulAdd(hn::LoadU(Together(), w + 4 * P::own), hn::Set(Together(), last[p]), rest);
      }
#pragma GCC unroll 4
      for (int b = 0; b < 4; ++b) sum[b].store(to[b]);
      if constexpr (P::rest > 0) store_row(Together(), to, P::own, rest);
    }
  }
  for (; j < end; ++j) one(j);
}

/// Blocks of S x S, which lie wherever they do, lose L (S x depth) times their columns of the spread W.
template <int S>
void row_of_blocks(double* values, const std::int64_t* target, const double* l, const double* spread_w, int depth, int begin,
                   int end) {
  int done = 0;
  const auto part = [&]<int D>(int some) {
    part_of_row<S, D>(values, target, l + done * S, spread_w + done * Parts<S>::four, depth, begin, end, some);
    done += some;
  };
  while (depth - done > at_once) part.template operator()<at_once>(at_once);
  switch (depth - done) {
    case S: return part.template operator()<S>(S);
    case 2 * S: return part.template operator()<2 * S>(2 * S);
    case 3 * S: return part.template operator()<3 * S>(3 * S);
    default: break;
  }
  if (depth - done == at_once) return part.template operator()<at_once>(at_once);
  part.template operator()<0>(depth - done);
}

/// Block j alone, d columns of L after d columns, and the largest amount that each time is added to its diagonal.
template <int S>
void watched_block(double* c, double* HWY_RESTRICT reference, const double* HWY_RESTRICT l, const double* HWY_RESTRICT spread_w,
                   int depth, int d, int j) {
  using P = Parts<S>;
  const double* w = spread_w + static_cast<std::ptrdiff_t>(j / 4) * depth * P::four;
  const int b = j % 4;
  Rows<P::own> sum = Rows<P::own>::load(c);
  Rows<P::rest> rest = Rows<P::rest>::load(c + P::own);
  double before[S];
#pragma GCC unroll 4
  for (int q = 0; q < S; ++q) before[q] = c[q * (S + 1)];
  for (int begin = 0; begin < depth; begin += d) {
    for (int p = 0; p < d; ++p, l += S, w += P::four) {
      sum.subtract_each(every_column<S>(l), Rows<P::own>::load(w + b * P::own));
      rest.subtract(Rows<P::rest>::load(w + 4 * P::own + b), l[S - 1]);
    }
    sum.store(c);
    rest.store(c + P::own);
#pragma GCC unroll 4
    for (int q = 0; q < S; ++q) {
      const double added = c[q * (S + 1)] - before[q];
      reference[q] = std::abs(added) > std::abs(reference[q]) ? added : reference[q];  // no branch: unpredictable
      before[q] = c[q * (S + 1)];
    }
  }
}

/// As ColumnOfBlocks describes it.
template <int S>
void column_of_blocks(double* c, const double* l, std::ptrdiff_t next, const double* w, int depth, int blocks) {
  using P = Parts<S>;
  Rows<P::own> right[at_once];
  for (int p = 0; p < depth; ++p) {
    double tile[P::own + 1];
#pragma GCC unroll 16
    for (int e = 0; e < P::own; ++e) tile[e] = w[e / S * depth + p];
    right[p] = Rows<P::own>::load(tile);
  }
  const double* last = w + (S - 1) * depth;
  for (int j = 0; j < blocks; ++j, c += S * S, l += next) {
    Rows<P::own> sum = Rows<P::own>::load(c);
    Rows<P::rest> rest = Rows<P::rest>::load(c + P::own);
    for (int p = 0; p < depth; ++p) {
      sum.subtract_each(every_column<S>(l + p * S), right[p]);
      rest.subtract(Rows<P::rest>::load(l + p * S + S - 1), last[p]);
    }
    sum.store(c);
    rest.store(c + P::own);
  }
}

}  // namespace graphsolve::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard

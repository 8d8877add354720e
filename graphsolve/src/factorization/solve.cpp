#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <string>
#include <utility>

#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"
#include "factorization/rank_revealing.hpp"
#include "graphsolve/overlap.hpp"
#include "simd/pivot_kernels.hpp"

/// Solving with the factors. Of single pivots they have the same form for all kinds, of packs simd::Form. Where there are
/// packs, the vector lies interleaved as they do (Program::row_place) while it is solved for.
namespace graphsolve {

namespace {

constexpr int columns_at_once = 8;  ///< more would push the blocks out of the cache between their uses

/// Rows of one pivot side by side, while a pivot goes by itself: in place, or a copy of what lies interleaved.
class Gathered {
 public:
  Gathered(double* x, simd::RowPlace at, int rows) : at_(at), rows_(rows), x_(x + at.first), here_(at.stride == 1 ? x_ : copy_) {
    if (at.stride == 1) return;
    for (int i = 0; i < rows; ++i) copy_[i] = x_[i * at.stride];
  }
  [[nodiscard]] double* rows() const { return here_; }
  void write_back() const {
    if (at_.stride == 1) return;
    for (int i = 0; i < rows_; ++i) x_[i * at_.stride] = copy_[i];
  }

 private:
  simd::RowPlace at_;
  int rows_;
  double* x_;
  double copy_[simd::largest_dimension];
  double* here_;
};

}  // namespace

void Factorization::Impl::check_size(std::span<const double> x, int columns) const {
  if (columns >= 0 && x.size() == static_cast<std::size_t>(symbolic_->rows()) * static_cast<std::size_t>(columns)) return;
  throw std::invalid_argument("right-hand side has " + std::to_string(x.size()) + " numbers, expected " +
                              std::to_string(symbolic_->rows()) + " rows x " + std::to_string(columns) + " columns");
}

void Factorization::Impl::solve_diagonal(int k, const double* diagonal, double* x, int columns, std::ptrdiff_t stride) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int row = first_row_[k];
  if (rank_[k] == p.dimension) {
    kernels_->solve(p.dimension)(diagonal, row_exchange_.data() + row, x, p.dimension, columns, stride);
    return;
  }
  for (int c = 0; c < columns; ++c, x += stride)
    solve_rank_deficient(diagonal, p.dimension, rank_[k], row_exchange_.data() + row, column_exchange_.data() + row, x, 1);
}

void Factorization::Impl::check_factored(std::span<const int> components) const {
  for (const int c : components) {
    if (standing_.factor(c) == Standing::Factor::there) continue;
    const std::string which = symbolic_->components() > 1 ? " of component " + std::to_string(c) : "";
    if (standing_.factor(c) == Standing::Factor::none) throw std::logic_error("solve: factorize()" + which + " comes first");
    throw std::logic_error("solve: there are no factors" + which + ", whose node " +
                           std::to_string(symbolic_->node(outcomes_[c].first_bad_pivot).index) +
                           (kind_ == FactorizationKind::cholesky ? " is not positive definite" : " is singular"));
  }
}

void Factorization::Impl::solve(std::span<double> x, int columns) const {
  check_size(x, columns);
  check_factored(taking_part_.everybody());
  taking_part_.set(taking_part_.everybody());
  const int rows = symbolic_->rows(), some = symbolic_->packs() == Packs::on ? 1 : columns_at_once;
  for (int c = 0; c < columns; c += some)
    solve_active(x.data() + static_cast<std::ptrdiff_t>(c) * rows, std::min(some, columns - c));
}

void Factorization::Impl::solve_components(std::span<double> x, std::span<const int> components) const {
  check_size(x, 1);
  taking_part_.check(components);
  check_factored(components);
  taking_part_.set(components);
  solve_active(x.data(), 1);
}

/// x_k := D^-1 x_k, or the first half of it, then the coupled rows lose L x_k. Columns only without packs, where they are `stride` apart.
void Factorization::Impl::solve_forward(int k, double* x, int columns) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::ptrdiff_t stride = s.rows();
  double buffer[simd::largest_factor];
  const PivotFactor factor = factor_of(k, buffer);
  const Gathered own(x, s.program().row_place(k), p.dimension);
  const double* xk = own.rows();
  if (is_halved(k)) kernels_->first_solve(p.dimension)(factor.diagonal, nullptr, own.rows(), p.dimension, columns, stride);
  else solve_diagonal(k, factor.diagonal, own.rows(), columns, stride);
  own.write_back();
  const double* lower = factor.lower;
  if (columns == 1 && equal_[k] > 0 && among_single_[k]) {
    kernels_->forwards[equal_[k] - 1](x, s.program().places(), s.coupled(k), lower, xk, p.dimension);
    return;
  }
  for (const int i : s.coupled(k)) {
    const int rows = s.dimension(i);
    const Gathered coupled(x, s.program().row_place(i), rows);
    kernels_->product(rows)(coupled.rows(), stride, lower, xk, stride, rows, p.dimension, columns);
    coupled.write_back();
    lower += rows * p.dimension;
  }
}

/// x_k loses D^-1 U times the coupled rows, or L^-1 P^T times them before it goes through the second half; where that is not kept
/// (P L^-T D^-1)^T times them on the way.
void Factorization::Impl::solve_backward(int k, double* x, int columns) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::ptrdiff_t stride = s.rows();
  double buffer[simd::largest_factor];
  const PivotFactor factor = factor_of(k, buffer);
  const double* upper = factor.upper;
  const Gathered own(x, s.program().row_place(k), p.dimension);
  if (is_half_kept(k)) {
    const auto backward = kernels_->backward_halves[p.dimension - 1];
    for (int c = 0; c < columns; ++c)
      backward(factor.diagonal, own.rows() + c * stride, s.program().places(), s.coupled(k), factor.lower, x + c * stride);
    return;
  }
  if (columns == 1 && equal_[k] > 0 && among_single_[k]) {
    kernels_->backwards[equal_[k] - 1](own.rows(), s.program().places(), s.coupled(k), upper, x, p.dimension);
  } else {
    for (const int j : s.coupled(k)) {
      const Gathered coupled(x, s.program().row_place(j), s.dimension(j));
      kernels_->product(p.dimension)(own.rows(), stride, upper, coupled.rows(), stride, p.dimension, s.dimension(j), columns);
      upper += p.dimension * s.dimension(j);
    }
  }
  if (is_halved(k)) kernels_->second_solve(p.dimension)(factor.diagonal, nullptr, own.rows(), p.dimension, columns, stride);
  own.write_back();
}

/// The coupled rows lose W^T x_k.
void Factorization::Impl::solve_forward_transposed(int k, double* x) const {
  const Symbolic& s = *symbolic_;
  const int d = s.dimension(k);
  double buffer[simd::largest_factor];
  const double* upper = factor_of(k, buffer).upper;
  const Gathered own(x, s.program().row_place(k), d);
  for (const int j : s.coupled(k)) {
    const Gathered coupled(x, s.program().row_place(j), s.dimension(j));
    kernels::subtract_transposed_times_vector(coupled.rows(), upper, own.rows(), d, s.dimension(j));
    coupled.write_back();
    upper += d * s.dimension(j);
  }
}

/// x_k := D^-T (x_k - L^T times the coupled rows).
void Factorization::Impl::solve_backward_transposed(int k, double* x) const {
  const Symbolic& s = *symbolic_;
  const int d = s.dimension(k), row = first_row_[k];
  double buffer[simd::largest_factor];
  const PivotFactor factor = factor_of(k, buffer);
  const Gathered own(x, s.program().row_place(k), d);
  const double* lower = factor.lower;
  for (const int i : s.coupled(k)) {
    const Gathered coupled(x, s.program().row_place(i), s.dimension(i));
    kernels::subtract_transposed_times_vector(own.rows(), lower, coupled.rows(), s.dimension(i), d);
    lower += s.dimension(i) * d;
  }
  if (rank_[k] == d)
    kernels::solve_block_transposed(factor.diagonal, row_exchange_.data() + row, own.rows(), d);
  else
    solve_rank_deficient_transposed(factor.diagonal, d, rank_[k], row_exchange_.data() + row, column_exchange_.data() + row,
                                    own.rows());
  own.write_back();
}

/// The kernel for runs of lanes of a pack that were made together, alone(pivot) for those between them.
template <class Kernels, class Alone>
void Factorization::Impl::solve_pack(int number, unsigned active, const Vectors& v, const Kernels& kernels, Alone&& alone) const {
  const simd::Program& program = symbolic_->program();
  const simd::PivotPack& pack = program.pack(number);
  const auto together = [&](unsigned lanes) {
    kernels[pack.kind](simd::PackSolve{.program = program, .pack = pack, .factor = values_.data(), .x = v.x, .result = v.result,
                      .active = lanes, .form = symmetric() ? simd::Form::ldlt : simd::Form::ldu});
  };
  if ((packed_[number] & active) == active) return together(active);
  unsigned run = 0;
  for (int l = 0; l <= pack.lanes; ++l) {
    const bool ends = l == pack.lanes || (active & ~packed_[number]) >> l & 1u;
    if (ends && run != 0) together(std::exchange(run, 0));
    if (l == pack.lanes) break;
    if (ends) alone(pack.pivot[l]);
    else run |= active & 1u << l;
  }
}

/// The user's vector goes into lanes; without packs it is one already.
auto Factorization::Impl::enter(double* x) const -> Vectors {
  if (symbolic_->packs() == Packs::off) return {x, x};
  const simd::Program& program = symbolic_->program();
  double* lanes = lane_rows_.data();
  const auto groups = program.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (taking_part_.lanes(g) == 0) continue;
    simd::to_lanes(program, program.steps(groups[g]), x, lanes);
    for (const auto& step : program.steps(groups[g]))
      if (step.pack < 0)
        std::copy_n(x + symbolic_->row(step.pivot), symbolic_->dimension(step.pivot), lanes + program.row_place(step.pivot).first);
  }
  return {lanes, x};
}

/// The rows of a pivot that went by itself are final.
void Factorization::Impl::leave(int k, const Vectors& v) const {
  if (v.x == v.result) return;
  const simd::RowPlace at = symbolic_->program().row_place(k);
  const int row = symbolic_->row(k);
  for (int i = 0; i < symbolic_->dimension(k); ++i) v.result[row + i] = v.x[at.first + i * at.stride];
}

void Factorization::Impl::forward_pack(int number, unsigned active, const Vectors& v) const {
  solve_pack(number, active, v, solves_->forward, [&](int k) { solve_forward(k, v.x, 1); });
}

/// The second half of a solve.
void Factorization::Impl::backward(const Vectors& v, int columns) const {
  const auto& kernels = symmetric() ? solves_->backward_transposed : solves_->backward;
  const auto alone = [&](int k) {
    solve_backward(k, v.x, columns);
    leave(k, v);
  };
  taking_part_.walk(true, [&](int pack, unsigned active) { solve_pack(pack, active, v, kernels, alone); }, alone);
}

/// Several columns only without packs.
void Factorization::Impl::solve_active(double* x, int columns) const {
  const Vectors v = enter(x);
  taking_part_.walk(false, [&](int pack, unsigned active) { forward_pack(pack, active, v); }, [&](int k) { solve_forward(k, v.x, columns); });
  backward(v, columns);
}

Factorization::Outcome Factorization::Impl::factorize_and_solve(std::span<double> x) {
  check_size(x, 1);
  start_all();
  const Vectors v = enter(x.data());
  factorize_active(Count::together, &v);
  backward(v, 1);
  return finish_all();
}

std::span<const Factorization::Outcome> Factorization::Impl::factorize_and_solve(std::span<const int> components, std::span<double> x) {
  check_size(x, 1);
  start(components);
  const Vectors v = enter(x.data());
  factorize_active(Count::each, &v);
  backward(v, 1);
  finish(components);
  return outcomes_;
}

/// The symmetric kinds solve with A itself.
void Factorization::Impl::solve_transposed(std::span<double> x, int columns) const {
  if (symmetric()) return solve(x, columns);
  check_size(x, columns);
  check_factored(taking_part_.everybody());
  taking_part_.set(taking_part_.everybody());
  for (int c = 0; c < columns; ++c) solve_transposed_active(x.data() + static_cast<std::ptrdiff_t>(c) * symbolic_->rows());
}

/// Of an LDU.
void Factorization::Impl::solve_transposed_active(double* x) const {
  const Vectors v = enter(x);
  const auto forward = [&](int k) { solve_forward_transposed(k, v.x); };
  const auto backward = [&](int k) {
    solve_backward_transposed(k, v.x);
    leave(k, v);
  };
  taking_part_.walk(false, [&](int pack, unsigned active) { solve_pack(pack, active, v, solves_->forward_transposed, forward); }, forward);
  taking_part_.walk(true, [&](int pack, unsigned active) { solve_pack(pack, active, v, solves_->backward_transposed, backward); }, backward);
}

Factorization::Refinement Factorization::Impl::refine(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine(b, x, taking_part_.everybody(), max_sweeps, Side::plain);
}

/// The symmetric kinds keep both triangles, which are equal.
Factorization::Refinement Factorization::Impl::refine_transposed(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine(b, x, taking_part_.everybody(), max_sweeps, symmetric() ? Side::plain : Side::transposed);
}

Factorization::Refinement Factorization::Impl::refine(std::span<const double> b, std::span<double> x,
                                                      std::span<const int> components, int max_sweeps, Side side) {
  check_size(b, 1);
  check_size(x, 1);
  check_apart("refine", b, x);
  taking_part_.check(components);
  if (!std::ranges::all_of(components, [&](int c) { return standing_.is_kept(c); }))
    throw std::logic_error("refine: allow_refinement() and keep_matrix(true) come before factorize()");
  check_factored(components);
  return refiner_.refine(matrix_.data(), side, b, x, components, max_sweeps, taking_part_, [this, side](double* r) {
    side == Side::plain ? solve_active(r, 1) : solve_transposed_active(r);
  });
}

}  // namespace graphsolve

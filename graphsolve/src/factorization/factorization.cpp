#include "graphsolve/factorization.hpp"

#include <utility>

#include "factorization/impl.hpp"

/// What users see: every call goes to Factorization::Impl.
namespace graphsolve {

Factorization::Factorization(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind)
    : impl_(std::make_unique<Impl>(std::move(symbolic), kind)), values_(impl_->values()) {}
Factorization::~Factorization() = default;
Factorization::Factorization(Factorization&& other) noexcept
    : impl_(std::move(other.impl_)), values_(std::exchange(other.values_, {})) {}
Factorization& Factorization::operator=(Factorization&& other) noexcept {
  impl_ = std::move(other.impl_);
  values_ = std::exchange(other.values_, {});
  return *this;
}

Factorization Factorization::twin() const {
  Factorization other(impl_->symbolic(), impl_->kind());
  other.impl_->set_saddle_shift(impl_->saddle_shift(), impl_->leave_out());
  return other;
}

const Symbolic& Factorization::symbolic() const { return *impl_->symbolic(); }
FactorizationKind Factorization::kind() const { return impl_->kind(); }

void Factorization::set_zero() { impl_->set_zero(); }
void Factorization::set_zero(std::span<const int> components) { impl_->set_zero(components); }
void Factorization::leave_unzeroed(std::span<const BlockHandle> blocks) { impl_->leave_unzeroed(blocks); }

void Factorization::allow_refinement() { impl_->allow_refinement(); }
void Factorization::keep_matrix(bool keep) { impl_->keep_matrix(keep); }
std::span<const double> Factorization::matrix() const { return impl_->matrix(); }
void Factorization::set_saddle_shift(double relative, double leave_out) { impl_->set_saddle_shift(relative, leave_out); }

Factorization::Outcome Factorization::factorize() { return impl_->factorize(); }
Factorization::Outcome Factorization::factorize(int component) { return impl_->factorize({&component, 1})[component]; }
std::span<const Factorization::Outcome> Factorization::factorize(std::span<const int> components) {
  return impl_->factorize(components);
}
Factorization::Outcome Factorization::factorize_and_solve(std::span<double> x) { return impl_->factorize_and_solve(x); }
std::span<const Factorization::Outcome> Factorization::factorize_and_solve(std::span<const int> components,
                                                                           std::span<double> x) {
  return impl_->factorize_and_solve(components, x);
}

void Factorization::allow_refactorization() { impl_->allow_refactorization(); }
double& Factorization::kept_entry(const BlockHandle& handle, int row, int column) {
  return impl_->kept_entry(handle.place(row, column));
}
Factorization::Outcome Factorization::refactorize(std::span<const NodeId> changed) { return impl_->refactorize(changed); }

void Factorization::solve_component(std::span<double> x, int component) const {
  impl_->solve_components(x, {&component, 1});
}
void Factorization::solve_components(std::span<double> x, std::span<const int> components) const {
  impl_->solve_components(x, components);
}
void Factorization::solve(std::span<double> x, int columns) const { impl_->solve(x, columns); }
void Factorization::solve_transposed(std::span<double> x, int columns) const { impl_->solve_transposed(x, columns); }

Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return impl_->refine(b, x, max_sweeps);
}
Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x,
                                                std::span<const int> components, int max_sweeps) {
  return impl_->refine(b, x, components, max_sweeps);
}
Factorization::Refinement Factorization::refine_transposed(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return impl_->refine_transposed(b, x, max_sweeps);
}

std::span<const Factorization::DroppedRow> Factorization::dropped_rows() const { return impl_->dropped_rows(); }
void Factorization::dependency(const DroppedRow& dropped, std::span<double> y) const { impl_->dependency(dropped, y); }

}  // namespace graphsolve

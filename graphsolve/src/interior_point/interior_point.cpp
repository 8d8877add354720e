#include "graphsolve/interior_point.hpp"

#include <utility>

#include "interior_point/impl.hpp"

/// What users see: every call goes to InteriorPoint::Impl.
namespace graphsolve {

InteriorPoint::InteriorPoint(Problem& problem, std::shared_ptr<const Symbolic> symbolic, InteriorPointSettings settings)
    : impl_(std::make_unique<Impl>(problem, std::move(symbolic), settings)) {}
InteriorPoint::~InteriorPoint() = default;
InteriorPoint::InteriorPoint(InteriorPoint&&) noexcept = default;
InteriorPoint& InteriorPoint::operator=(InteriorPoint&&) noexcept = default;

void InteriorPoint::activate(int batch, std::span<const int> instances) { impl_->activate(batch, instances); }
void InteriorPoint::select(std::span<const int> components) { impl_->select(components); }
void InteriorPoint::set_row_scale(NodeId node, std::span<const double> scale) { impl_->set_row_scale(node, scale); }

Status InteriorPoint::solve(std::span<double> x, double force_factor, std::span<const double> noise) {
  return impl_->solve(x, force_factor, noise);
}
std::span<const ComponentReport> InteriorPoint::reports() const { return impl_->reports(); }
std::span<const double> InteriorPoint::residual() const { return impl_->residual(); }
const Factorization& InteriorPoint::factorization() const { return impl_->factorization(); }
void InteriorPoint::set_more_starts(bool more) { impl_->set_more_starts(more); }
void InteriorPoint::set_profile(Profile* profile) { impl_->set_profile(profile); }

Status InteriorPoint::linearize(std::span<double> x, double smoothing, double stiffness, Factorization& target) {
  return impl_->linearize(x, smoothing, stiffness, target);
}
void InteriorPoint::restore_laws() { impl_->restore_laws(); }
Factorization::Outcome InteriorPoint::factorize_terms(std::span<const double> x) { return impl_->factorize_terms(x); }

}  // namespace graphsolve

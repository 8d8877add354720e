#pragma once

#include <functional>
#include <span>
#include <vector>

#include "factorization/residual.hpp"
#include "graphsolve/factorization.hpp"

namespace graphsolve {

/// Iterative refinement against a kept matrix, every component by itself.
class Refiner {
 public:
  /// The symbolic one must live as long.
  Refiner(const Symbolic& symbolic, const simd::Solves& kernels) : symbolic_(symbolic), residual_(symbolic, kernels) {}
  void reserve();

  /// x becomes the best one found. solve(r) replaces r by what the factors make of it, for those who take part: of the
  /// components given fewer and fewer.
  Factorization::Refinement refine(const double* matrix, Side side, std::span<const double> b, std::span<double> x,
                                   std::span<const int> components, int max_sweeps, Participants& participants,
                                   const std::function<void(double*)>& solve);

 private:
  enum class Precision { plain, twice };
  void keep(int component, std::span<const double> x);
  [[nodiscard]] bool is_done(int component) const;
  /// After a sweep: is this the best x so far?
  [[nodiscard]] bool judge(const Residual::System& system, int component);

  const Symbolic& symbolic_;
  Residual residual_;
  std::vector<double> best_;
  std::vector<int> refined_;  ///< components that it still improves
  // By component.
  std::vector<double> least_error_;
  std::vector<Precision> precision_;
  std::vector<int> in_vain_;  ///< sweeps in a row
};

}  // namespace graphsolve

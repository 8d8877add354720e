#pragma once

#include <span>
#include <vector>

#include "factorization/participants.hpp"
#include "factorization/side.hpp"
#include "simd/pivot_kernels.hpp"

namespace graphsolve {

/// f(row) for the rows of a component, in the user's numbering.
template <class F>
void each_row(const Symbolic& symbolic, int component, F&& f) {
  for (int k = symbolic.component_begin(component); k < symbolic.component_begin(component + 1); ++k) {
    const Symbolic::Pivot& p = symbolic.pivot(k);
    for (int i = p.row; i < p.row + p.dimension; ++i) f(i);
  }
}

/// b - A x, or b - A^T x, with the componentwise backward error of every component.
class Residual {
 public:
  /// The symbolic one must live as long.
  Residual(const Symbolic& symbolic, const simd::Solves& kernels) : symbolic_(symbolic), kernels_(kernels) {}
  void reserve();

  /// Values of a matrix that lie as those of the factorization do, a right-hand side and what is to solve it.
  struct System {
    const double* matrix;
    Side side;
    std::span<const double> b, x;
  };
  /// Of those who take part.
  void measure(const System& system, const Participants& participants);
  /// Of one component, in twice the precision.
  void measure_twice(const System& system, int component);

  [[nodiscard]] double error(int component) const { return error_[component]; }
  [[nodiscard]] double* rows() { return residual_.data(); }

 private:
  void start(std::span<const double> b, int component);
  void finish(int component);
  void measure_plain(const System& system, const Participants& participants);
  void measure_transposed(const System& system, const Participants& participants);
  template <class F>
  void each_block(const double* matrix, int k, F&& take) const;

  const Symbolic& symbolic_;
  const simd::Solves& kernels_;
  std::vector<double> residual_, low_, magnitude_;  ///< low_: what residual_ has no digits for
  std::vector<double> error_;                       ///< by component
};

}  // namespace graphsolve

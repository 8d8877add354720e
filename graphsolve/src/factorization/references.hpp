#pragma once

#include <cstddef>
#include <vector>

#include "factorization/participants.hpp"
#include "graphsolve/aligned.hpp"
#include "graphsolve/factorization.hpp"

namespace graphsolve {

/// What is remembered of diagonal blocks while neighbours add to them: amounts that their pivots are compared with. Lies as
/// the rows of vectors in lanes do.
class References {
 public:
  /// The symbolic one must live as long.
  References(const Symbolic& symbolic, FactorizationKind kind);
  /// With a shift all saddle blocks of a symmetric matrix have one.
  void set_shifted(bool shifted) { shifted_ = shifted; }

  /// Is what neighbours add to the diagonal of this block remembered? Only where something is decided by it.
  [[nodiscard]] bool track(int k) const;
  /// Must that of this block be noted before the elimination begins? Else it is zero, or what stands on the diagonal when
  /// its turn comes, since nobody changes it.
  [[nodiscard]] bool start_with(int k) const;

  /// Notes those that must be, of who takes part.
  void start(const Participants& participants, const double* values);
  void start(int k, const double* values);

  /// Largest amount, signed, added to a row of a saddle diagonal; in the symmetric kinds |diagonal of the matrix| of others.
  [[nodiscard]] double& own(int k, int row) { return own_[place(k, row)]; }
  /// Where dependence is looked for: largest entry of the row right of the block.
  [[nodiscard]] double& panel(int k, int row) { return panel_[place(k, row)]; }
  /// Those of a block side by side: in place, or a copy.
  [[nodiscard]] const double* side_by_side(int k, double* buffer) const;
  [[nodiscard]] double* in_lanes() { return own_.data(); }

 private:
  [[nodiscard]] std::size_t place(int k, int row) const;
  [[nodiscard]] bool is_compared(int k) const;
  void find_started();
  void start(const simd::PivotPack& pack, unsigned active, const double* values);
  void start_panel(int k, const double* values);
  void start_panels(const simd::PivotPack& pack, const double* values);
  template <int Lanes>
  void start_panels_of(const simd::PivotPack& pack, const double* values);

  const Symbolic& symbolic_;
  FactorizationKind kind_;
  bool symmetric_, shifted_ = false;
  std::vector<int> started_;  ///< steps of the program whose pivots start_with one, ascending
  AlignedVector own_, panel_;
};

}  // namespace graphsolve

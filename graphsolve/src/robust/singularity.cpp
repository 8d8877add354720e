#include <stdexcept>

#include "factorization/kept_matrix.hpp"
#include "graphsolve/diagnosis.hpp"
#include "robust/near_null.hpp"
#include "robust/scales.hpp"

namespace graphsolve {

namespace {

constexpr int middle_passes = 30;    ///< of the second look
constexpr double rounding_of_sizes = 4e-15;   ///< of what the sizes of the entries make of the vector, signs left out
constexpr double agrees = 1.01;      ///< what factors say of a vector and what the matrix does to it
constexpr double shift_slack = 2;    ///< times the shift of the diagonal

/// A matrix in units of its own, and what is asked of it.
class Scaled {
 public:
  Scaled(const Eigen::SparseMatrix<double>& a, Scales scales) : scales_(std::move(scales)), matrix_(scales_.applied_to(a)) {}

  [[nodiscard]] bool is_singular() const {
    const NearNull found = near_null(matrix_);
    return found.vector.size() == 0 || shortened_to_rounding(found.vector, shift_slack * found.shift);
  }
  /// With factors of the matrix as it was. Those of another one, boosted ones or such that growth spoiled, betray themselves.
  [[nodiscard]] bool is_singular(const Factorization& factors) const {
    Eigen::VectorXd v = uneven_vector(matrix_.rows());
    for (int sweep = 0; sweep < 2; ++sweep)
      for (const bool transposed : {true, false}) {
        v.normalize();
        v = v.cwiseQuotient(transposed ? scales_.column : scales_.row);
        const std::span<double> x(v.data(), static_cast<std::size_t>(v.size()));
        transposed ? factors.solve_transposed(x) : factors.solve(x);
        v = v.cwiseQuotient(transposed ? scales_.row : scales_.column);
      }
    if (shortened_to_rounding(v, 0)) return true;
    const double back = (matrix_ * v).norm();  // 1 by the factors
    const bool credible = back < agrees && agrees * back > 1;
    return !credible && is_singular();
  }

 private:
  /// Rounding every entry alone can make a matrix singular that leaves no more of a vector than a few eps |A| |v|. That does
  /// not grow with the number of rows, and the smallest singular value of a long chain falls with its square. False of NaN.
  [[nodiscard]] bool shortened_to_rounding(const Eigen::VectorXd& v, double slack) const {
    const double unsigned_length = (matrix_.cwiseAbs() * v.cwiseAbs()).norm();
    return (matrix_ * v).norm() - slack * v.norm() <= rounding_of_sizes * unsigned_length;
  }

  Scales scales_;
  Eigen::SparseMatrix<double> matrix_;
};

}  // namespace

bool is_singular(const Factorization& f, const Factorization::Outcome& outcome) {
  if (f.matrix().empty()) throw std::invalid_argument("is_singular: the factorization did not keep its matrix");
  const Eigen::SparseMatrix<double> a = sparse_matrix(f.symbolic(), f.matrix());
  if (!Eigen::Map<const Eigen::VectorXd>(a.valuePtr(), a.nonZeros()).allFinite()) return false;
  const bool complete = outcome.ok() && outcome.dropped_rows == 0 && outcome.boosts == 0;
  for (const int passes : {0, middle_passes}) {
    const Scaled scaled(a, scales_of(a, passes));
    if (!(complete ? scaled.is_singular(f) : scaled.is_singular())) return false;
  }
  return true;
}

}  // namespace graphsolve

#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// General sparse packages behind one interface, for comparison only: graphsolve never links them, and parts of
/// SuiteSparse are GPL.
namespace baselines {

/// What a package can be given.
enum class Demand {
  any,                ///< any square matrix
  symmetric,          ///< symmetric, definite or not, but no pivoting: a zero pivot ends it
  positive_definite,  ///< symmetric with positive eigenvalues
};

struct Status {
  bool ok = true;
  std::string why;  ///< the package's own word, in a few words; empty when ok
};

/// One package, one method. Calls in this order: analyze, then any number of (write, refactor, any number of solve).
/// Times of `refactor` and `solve` are the package's own: converting and copying happens in `write`.
class Baseline {
 public:
  virtual ~Baseline() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;
  [[nodiscard]] virtual Demand demand() const = 0;
  /// Everything that is done once for a pattern, its ordering included. `a` is square, compressed, sorted, and both
  /// triangles are given.
  [[nodiscard]] virtual Status analyze(const Eigen::SparseMatrix<double>& a) = 0;
  /// New numbers, in the order of `a.valuePtr()` of the matrix that was analyzed.
  virtual void write(std::span<const double> values) = 0;
  [[nodiscard]] virtual Status refactor() = 0;
  /// x := A^-1 b. Not ok also when x has entries that are no numbers.
  [[nodiscard]] virtual Status solve(std::span<const double> b, std::span<double> x) = 0;

  /// refactor and solve in one pass, for those that can; the others are timed by the sum of the two.
  [[nodiscard]] virtual bool has_one_pass() const { return false; }
  [[nodiscard]] virtual Status refactor_and_solve(std::span<const double> b, std::span<double> x) {
    const Status status = refactor();
    return status.ok ? solve(b, x) : status;
  }

  [[nodiscard]] Status refactor(std::span<const double> values) {
    write(values);
    return refactor();
  }
};

std::unique_ptr<Baseline> cholmod_simplicial();  ///< LDL'
std::unique_ptr<Baseline> cholmod_supernodal();  ///< LL' by dense blocks
std::unique_ptr<Baseline> umfpack();             ///< LU by frontal matrices, refines by itself
std::unique_ptr<Baseline> klu();                 ///< LU; refactor keeps the first pivots
std::unique_ptr<Baseline> eigen_ldlt();          ///< SimplicialLDLT
std::unique_ptr<Baseline> eigen_lu();            ///< SparseLU

/// All six, in this order.
std::vector<std::unique_ptr<Baseline>> all();

/// A matrix of the same pattern that is positive definite: off-diagonal entries kept, the diagonal made dominant.
/// For packages that demand it where the matrix at hand is indefinite; the work is the same.
Eigen::SparseMatrix<double> positive_definite_twin(const Eigen::SparseMatrix<double>& a);

/// "SuiteSparse 5.12.0, Eigen 3.4.0"
std::string versions();

}  // namespace baselines

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <algorithm>

#include "baselines/baselines.hpp"
#include "baselines/finite.hpp"

namespace baselines {

namespace {

template <class Solver>
class EigenSolver final : public Baseline {
 public:
  EigenSolver(std::string_view name, Demand demand, std::string_view failure)
      : name_(name), demand_(demand), failure_(failure) {}

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Demand demand() const override { return demand_; }

  [[nodiscard]] Status analyze(const Eigen::SparseMatrix<double>& a) override {
    matrix_ = a;
    solver_.analyzePattern(matrix_);
    return {};
  }

  void write(std::span<const double> values) override { std::copy(values.begin(), values.end(), matrix_.valuePtr()); }

  [[nodiscard]] Status refactor() override {
    solver_.factorize(matrix_);
    factored_ = solver_.info() == Eigen::Success;
    return factored_ ? Status{} : Status{false, failure_};
  }

  [[nodiscard]] Status solve(std::span<const double> b, std::span<double> x) override {
    if (!factored_) return {false, "not factored"};
    const auto n = static_cast<Eigen::Index>(b.size());
    Eigen::Map<Eigen::VectorXd>(x.data(), n) = solver_.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), n));
    return judged(x);
  }

 private:
  std::string_view name_;
  Demand demand_;
  std::string failure_;
  Solver solver_;
  Eigen::SparseMatrix<double> matrix_;
  bool factored_ = false;
};

}  // namespace

std::unique_ptr<Baseline> eigen_ldlt() {
  return std::make_unique<EigenSolver<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>>(
      "Eigen SimplicialLDLT", Demand::symmetric, "zero pivot");
}

std::unique_ptr<Baseline> eigen_lu() {
  return std::make_unique<EigenSolver<Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>>>>(
      "Eigen SparseLU", Demand::any, "singular");
}

}  // namespace baselines

#include <cholmod.h>

#include <algorithm>

#include "baselines/baselines.hpp"
#include "baselines/finite.hpp"

namespace baselines {

namespace {

class Cholmod final : public Baseline {
 public:
  Cholmod(std::string_view name, Demand demand, int method) : name_(name), demand_(demand) {
    cholmod_start(&common_);
    common_.supernodal = method;
    common_.print = 0;
  }
  ~Cholmod() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_finish(&common_);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Demand demand() const override { return demand_; }

  [[nodiscard]] Status analyze(const Eigen::SparseMatrix<double>& a) override {
    lower_ = a.triangularView<Eigen::Lower>();
    source_.clear();
    for (int j = 0, k = 0; j < a.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry, ++k)
        if (entry.row() >= j) source_.push_back(k);
    matrix_ = {};
    matrix_.nrow = matrix_.ncol = static_cast<std::size_t>(lower_.rows());
    matrix_.nzmax = static_cast<std::size_t>(lower_.nonZeros());
    matrix_.p = lower_.outerIndexPtr();
    matrix_.i = lower_.innerIndexPtr();
    matrix_.x = lower_.valuePtr();
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.dtype = CHOLMOD_DOUBLE;
    matrix_.sorted = matrix_.packed = 1;
    cholmod_free_factor(&factor_, &common_);
    factor_ = cholmod_analyze(&matrix_, &common_);
    if (factor_ == nullptr) return {false, "analysis failed"};
    return {};
  }

  void write(std::span<const double> values) override {
    for (std::size_t k = 0; k < source_.size(); ++k) lower_.valuePtr()[k] = values[source_[k]];
  }

  [[nodiscard]] Status refactor() override {
    cholmod_factorize(&matrix_, factor_, &common_);
    if (common_.status == CHOLMOD_NOT_POSDEF)
      return {false, factor_->is_ll ? "not positive definite" : "zero pivot"};
    if (common_.status < 0) return {false, "out of memory or bad input"};
    return factor_->minor == factor_->n ? Status{} : Status{false, "zero pivot"};
  }

  [[nodiscard]] Status solve(std::span<const double> b, std::span<double> x) override {
    cholmod_dense right{};
    right.nrow = right.nzmax = right.d = b.size();
    right.ncol = 1;
    right.x = const_cast<double*>(b.data());  // CHOLMOD knows no const
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    if (!cholmod_solve2(CHOLMOD_A, factor_, &right, nullptr, &x_, nullptr, &y_, &e_, &common_))
      return {false, "solve failed"};
    std::copy_n(static_cast<const double*>(x_->x), x.size(), x.data());
    return judged(x);
  }

 private:
  std::string_view name_;
  Demand demand_;
  cholmod_common common_{};
  cholmod_sparse matrix_{};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
  Eigen::SparseMatrix<double> lower_;
  std::vector<int> source_;  ///< per entry of the lower triangle: its place in the whole matrix
};

}  // namespace

std::unique_ptr<Baseline> cholmod_simplicial() {
  return std::make_unique<Cholmod>("CHOLMOD simplicial", Demand::symmetric, CHOLMOD_SIMPLICIAL);
}

std::unique_ptr<Baseline> cholmod_supernodal() {
  return std::make_unique<Cholmod>("CHOLMOD supernodal", Demand::positive_definite, CHOLMOD_SUPERNODAL);
}

}  // namespace baselines

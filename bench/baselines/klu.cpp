#include <klu.h>

#include <algorithm>

#include "baselines/baselines.hpp"
#include "baselines/finite.hpp"

namespace baselines {

namespace {

class Klu final : public Baseline {
 public:
  Klu() { klu_defaults(&common_); }
  ~Klu() override { release(); }
  Klu(const Klu&) = delete;
  Klu& operator=(const Klu&) = delete;

  [[nodiscard]] std::string_view name() const override { return "KLU"; }
  [[nodiscard]] Demand demand() const override { return Demand::any; }

  [[nodiscard]] Status analyze(const Eigen::SparseMatrix<double>& a) override {
    release();
    matrix_ = a;
    symbolic_ = klu_analyze(static_cast<int>(a.rows()), matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), &common_);
    if (symbolic_ == nullptr) return {false, "structurally singular"};
    return {};
  }

  void write(std::span<const double> values) override { std::copy(values.begin(), values.end(), matrix_.valuePtr()); }

  /// The first call chooses the pivots, the later ones keep them.
  [[nodiscard]] Status refactor() override {
    if (numeric_ == nullptr) {
      numeric_ = klu_factor(matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), matrix_.valuePtr(), symbolic_, &common_);
      if (numeric_ != nullptr && common_.status == KLU_OK) return {};
    } else if (klu_refactor(matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), matrix_.valuePtr(), symbolic_, numeric_,
                            &common_) && common_.status == KLU_OK) {
      return {};
    }
    return {false, common_.status == KLU_SINGULAR ? "singular" : "factorization failed"};
  }

  [[nodiscard]] Status solve(std::span<const double> b, std::span<double> x) override {
    if (numeric_ == nullptr) return {false, "not factored"};
    std::copy(b.begin(), b.end(), x.begin());
    if (!klu_solve(symbolic_, numeric_, static_cast<int>(x.size()), 1, x.data(), &common_))
      return {false, "solve failed"};
    return judged(x);
  }

 private:
  void release() {
    if (numeric_ != nullptr) klu_free_numeric(&numeric_, &common_);
    if (symbolic_ != nullptr) klu_free_symbolic(&symbolic_, &common_);
  }

  klu_common common_{};
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
  Eigen::SparseMatrix<double> matrix_;
};

}  // namespace

std::unique_ptr<Baseline> klu() { return std::make_unique<Klu>(); }

}  // namespace baselines

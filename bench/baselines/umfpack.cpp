#include <umfpack.h>

#include <algorithm>

#include "baselines/baselines.hpp"
#include "baselines/finite.hpp"

namespace baselines {

namespace {

class Umfpack final : public Baseline {
 public:
  Umfpack() { umfpack_di_defaults(control_); }
  ~Umfpack() override { release(); }
  Umfpack(const Umfpack&) = delete;
  Umfpack& operator=(const Umfpack&) = delete;

  [[nodiscard]] std::string_view name() const override { return "UMFPACK"; }
  [[nodiscard]] Demand demand() const override { return Demand::any; }

  [[nodiscard]] Status analyze(const Eigen::SparseMatrix<double>& a) override {
    release();
    matrix_ = a;
    const int n = static_cast<int>(a.rows());
    const int status = umfpack_di_symbolic(n, n, matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), matrix_.valuePtr(),
                                           &symbolic_, control_, info_);
    return status == UMFPACK_OK ? Status{} : Status{false, "analysis failed"};
  }

  void write(std::span<const double> values) override { std::copy(values.begin(), values.end(), matrix_.valuePtr()); }

  [[nodiscard]] Status refactor() override {
    if (numeric_ != nullptr) umfpack_di_free_numeric(&numeric_);
    const int status = umfpack_di_numeric(matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), matrix_.valuePtr(),
                                          symbolic_, &numeric_, control_, info_);
    if (status == UMFPACK_OK) return {};
    return {false, status == UMFPACK_WARNING_singular_matrix ? "singular" : "factorization failed"};
  }

  [[nodiscard]] Status solve(std::span<const double> b, std::span<double> x) override {
    if (numeric_ == nullptr) return {false, "not factored"};
    const int status = umfpack_di_solve(UMFPACK_A, matrix_.outerIndexPtr(), matrix_.innerIndexPtr(), matrix_.valuePtr(),
                                        x.data(), b.data(), numeric_, control_, info_);
    if (status == UMFPACK_WARNING_singular_matrix) return {false, "singular"};
    return status == UMFPACK_OK ? judged(x) : Status{false, "solve failed"};
  }

 private:
  void release() {
    if (numeric_ != nullptr) umfpack_di_free_numeric(&numeric_);
    if (symbolic_ != nullptr) umfpack_di_free_symbolic(&symbolic_);
  }

  double control_[UMFPACK_CONTROL] = {}, info_[UMFPACK_INFO] = {};
  void *symbolic_ = nullptr, *numeric_ = nullptr;
  Eigen::SparseMatrix<double> matrix_;
};

}  // namespace

std::unique_ptr<Baseline> umfpack() { return std::make_unique<Umfpack>(); }

}  // namespace baselines

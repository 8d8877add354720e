#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "graphsolve/largest.hpp"
#include "graphsolve/term.hpp"

namespace graphsolve {

/// Complementarity seen from the graph: a batch of equal *ports*, each with a *law* of its own.
///
/// The port is a map between the graph and a few local rows: u = u(x) with derivative J2, and a force f that
/// enters the residual as -J1^T f. The law is local, knows no graph, and ties f to u by complementarity pairs
/// (s, z). Its unknowns are eliminated before the graph is:
///     (A + J1^T K J2) dx = -r + J1^T f0,   du = J2 dx.
/// This is what the interior point calls, one virtual call per batch. Write a Port and a Law and let
/// PortLawBatch do the rest.
class PortBatch : public Wired {
 public:
  virtual ~PortBatch() = default;
  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] virtual std::span<const NodeId> nodes(int i) const = 0;
  [[nodiscard]] virtual int degree(int i) const = 0;  ///< number of complementarity pairs
  /// z over s of a pair at its natural size (a mass, where z is an impulse and s a velocity).
  [[nodiscard]] virtual double scale(int i) const = 0;
  virtual void wire(const Wiring& wiring) = 0;

  /// Keeps the private unknowns of the last solve as the start of this one, with forces times `factor`.
  virtual void remember(Instances, double factor) = 0;
  /// Back to what was remembered.
  virtual void restore(Instances) = 0;
  /// Private unknowns on the central path of `mu` (by component), near the remembered ones and u(x).
  virtual void start_warm(Instances, std::span<const double> x, std::span<const double> mu,
                          std::span<const double> scale) = 0;
  /// s = velocity, z = scale velocity for every pair.
  virtual void start_cold(Instances, double velocity, std::span<const double> scale) = 0;

  /// u, J2 and the local residuals at x; residual -= J1^T f. By component: error = max(error, local natural residual),
  /// product = max(product, s z).
  virtual void evaluate(Instances, std::span<const double> x, std::span<double> residual, std::span<const double> scale,
                        std::span<double> error, std::span<double> product) = 0;
  /// values += J1^T K J2, with z/s of every pair bounded by largest_ratio (by component).
  virtual void condense(Instances, std::span<const double> largest_ratio, double* values) = 0;
  /// rhs += J1^T f0; correction (by component) weighs the products of the last recovered step.
  virtual void right_hand_side(Instances, std::span<const double> mu, std::span<const double> correction,
                               std::span<double> rhs) = 0;
  /// ds, dz of a step dx. By component: ratio = max(ratio, -dz/z, -ds/s); the step to the boundary is 1 / ratio.
  virtual void recover(Instances, std::span<const double> dx, std::span<double> ratio) = 0;
  /// sum += s z after a step of alpha (by component).
  virtual void complementarity(Instances, std::span<const double> alpha, std::span<double> sum) const = 0;
  virtual void accept(Instances, std::span<const double> alpha) = 0;
  /// Freezes the non-monotone coupling of the law at its present value, moved by `damping` from the last
  /// frozen one, or beyond where it is more than 1; change = max(change, relative change). 0 sets it free again.
  virtual void relax(Instances, double damping, std::span<double> change) = 0;
};

/// A Port has
///   static constexpr int rows, node_count;   std::array<NodeId, node_count> nodes;
///   void wire(const Wiring&);
///   void evaluate(std::span<const double> x, double* u);            u (rows); keeps J2
///   void add_force(const double* f, double* residual, double sign); residual += sign J1^T f
///   void rate(const double* dx, double* du) const;                  du = J2 dx
///   void add_condensed(const double* K, double* values) const;      values += J1^T K J2, K column-major
/// A Law has
///   static constexpr int rows;   int degree() const;   double scale() const;
///   void remember(double factor);  void restore();
///   void start_warm(const double* u, double mu, double scale);  void start_cold(double velocity, double scale);
///   void residual(const double* u, double* f);                      local residuals; f (rows)
///   double natural_error(double scale) const;  double largest_product() const;
///   void condense(double largest_ratio, double* K);                 holds no mu; z/s is bounded
///   void right_hand_side(double mu, double correction, double* f0);
///   void recover(const double* du);
///   double boundary_ratio() const;  double complementarity(double alpha) const;  void accept(double alpha);
///   double relax(double damping);
template <class Port, class Law>
class PortLawBatch final : public PortBatch {
 public:
  static_assert(Port::rows == Law::rows);
  static constexpr int rows = Port::rows;

  int add(Port port, Law law) {
    ports_.push_back(std::move(port));
    laws_.push_back(std::move(law));
    return size() - 1;
  }
  [[nodiscard]] Port& port(int i) { return ports_[i]; }
  [[nodiscard]] const Port& port(int i) const { return ports_[i]; }
  [[nodiscard]] Law& law(int i) { return laws_[i]; }
  [[nodiscard]] const Law& law(int i) const { return laws_[i]; }

  [[nodiscard]] int size() const override { return static_cast<int>(ports_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return ports_[i].nodes; }
  [[nodiscard]] int degree(int i) const override { return laws_[i].degree(); }
  [[nodiscard]] double scale(int i) const override { return laws_[i].scale(); }
  void wire(const Wiring& wiring) override {
    for (auto& port : ports_) port.wire(wiring);
  }
  void remember(Instances instances, double factor) override {
    for (const int i : instances.index) laws_[i].remember(factor);
  }
  void restore(Instances instances) override {
    for (const int i : instances.index) laws_[i].restore();
  }
  void start_warm(Instances instances, std::span<const double> x, std::span<const double> mu,
                  std::span<const double> scale) override {
    double u[rows];
    for (const int i : instances.index) {
      ports_[i].evaluate(x, u);
      laws_[i].start_warm(u, mu[instances.component[i]], scale[instances.component[i]]);
    }
  }
  void start_cold(Instances instances, double velocity, std::span<const double> scale) override {
    for (const int i : instances.index) laws_[i].start_cold(velocity, scale[instances.component[i]]);
  }
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, std::span<const double> scale,
                std::span<double> error, std::span<double> product) override {
    double u[rows], f[rows];
    for (const int i : instances.index) {
      const int c = instances.component[i];
      ports_[i].evaluate(x, u);
      laws_[i].residual(u, f);
      ports_[i].add_force(f, residual.data(), -1.0);
      keep_largest(error[c], laws_[i].natural_error(scale[c]));
      keep_largest(product[c], laws_[i].largest_product());
    }
  }
  void condense(Instances instances, std::span<const double> largest_ratio, double* values) override {
    double k[rows * rows];
    for (const int i : instances.index) {
      laws_[i].condense(largest_ratio[instances.component[i]], k);
      ports_[i].add_condensed(k, values);
    }
  }
  void right_hand_side(Instances instances, std::span<const double> mu, std::span<const double> correction,
                       std::span<double> rhs) override {
    double f[rows];
    for (const int i : instances.index) {
      const int c = instances.component[i];
      laws_[i].right_hand_side(mu[c], correction[c], f);
      ports_[i].add_force(f, rhs.data(), 1.0);
    }
  }
  void recover(Instances instances, std::span<const double> dx, std::span<double> ratio) override {
    double du[rows];
    for (const int i : instances.index) {
      ports_[i].rate(dx.data(), du);
      laws_[i].recover(du);
      keep_largest(ratio[instances.component[i]], laws_[i].boundary_ratio());
    }
  }
  void complementarity(Instances instances, std::span<const double> alpha, std::span<double> sum) const override {
    for (const int i : instances.index) {
      const int c = instances.component[i];
      sum[c] += laws_[i].complementarity(alpha[c]);
    }
  }
  void accept(Instances instances, std::span<const double> alpha) override {
    for (const int i : instances.index) laws_[i].accept(alpha[instances.component[i]]);
  }
  void relax(Instances instances, double damping, std::span<double> change) override {
    for (const int i : instances.index) keep_largest(change[instances.component[i]], laws_[i].relax(damping));
  }

 private:
  std::vector<Port> ports_;
  std::vector<Law> laws_;
};

}  // namespace graphsolve

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// Hands out, once, the places where a term or a port will read and write.
class Wiring {
 public:
  /// claims: takes up the blocks that are claimed; null where the whole matrix is zeroed before every evaluation.
  explicit Wiring(const Symbolic& symbolic, const BlockGraph& graph, std::vector<BlockHandle>* claims = nullptr)
      : symbolic_(symbolic), graph_(graph), claims_(claims) {}
  /// First row of the node in every vector (unknowns, residual). Throws std::invalid_argument, as `block` does, when there
  /// is no such node.
  [[nodiscard]] int row(NodeId node) const {
    (void)block(node, node);
    return graph_.row(node);
  }
  /// Connected component that the node belongs to.
  [[nodiscard]] int component(NodeId node) const {
    (void)block(node, node);
    return symbolic_.component(node);
  }
  /// Derivative of the rows of `a` by the unknowns of `b`.
  [[nodiscard]] BlockHandle block(NodeId a, NodeId b) const { return symbolic_.block(a, b); }
  /// The same, of a term that *assigns* every entry of this block whenever it makes the matrix, before anything is added
  /// to it: it is not zeroed then, which saves a pass through memory. One claim per block; InteriorPoint throws
  /// std::logic_error on a second one.
  [[nodiscard]] BlockHandle claim(NodeId a, NodeId b) const {
    const BlockHandle handle = block(a, b);
    if (claims_) claims_->push_back(handle);
    return handle;
  }

 private:
  const Symbolic& symbolic_;
  const BlockGraph& graph_;
  std::vector<BlockHandle>* claims_;
};

/// What is wired keeps places of one Symbolic, and may be used as long as nobody has wired it for another (Problem::wired).
class Wired {
 private:
  friend class Problem;
  std::int64_t wiring_ = 0;
};

/// Instances of a batch that are to be worked on, and what belongs to each of them. Arrays named "by
/// component" are indexed with component[instance].
struct Instances {
  std::span<const int> index;
  std::span<const int> component;  ///< by instance
  /// Lists of one version are equal, for one batch and since it was wired: what was worked out for one holds for the
  /// next. 0: a list of its own.
  std::uint64_t version = 0;
};

/// Which blocks of the matrix the nodes of one instance make.
enum class Coupling {
  all_pairs,
  star,  ///< the first node with each of the others, these not with each other: a constraint and what it constrains
};

/// A batch of equal smooth contributions F(x) to the residual: dynamics, equality constraints, the gradient of
/// an objective. Stationarity rows carry constraints as -J^T lambda, constraint rows as +g.
/// Terms are evaluated in the order in which they were added; all terms before all ports.
class Term : public Wired {
 public:
  virtual ~Term() = default;
  [[nodiscard]] virtual int size() const = 0;
  /// Nodes that instance i touches.
  [[nodiscard]] virtual std::span<const NodeId> nodes(int i) const = 0;
  /// A block that is never written costs fill and operations all the same: say `star` where that is enough.
  [[nodiscard]] virtual Coupling coupling() const { return Coupling::all_pairs; }
  /// Called once, before anything else: keep the rows and blocks that are needed.
  virtual void wire(const Wiring& wiring) = 0;
  /// residual += F(x).  With values != nullptr also: the blocks of dF/dx are *added*, entry (i, j) at
  /// values[handle.place(i, j)]; only blocks that were claimed are assigned.
  virtual void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) = 0;
  /// Lowers alpha (by component) so that x + alpha dx stays where F is defined. Default: no bound.
  virtual void bound_step(Instances, std::span<const double> /*x*/, std::span<const double> /*dx*/,
                          std::span<double> /*alpha*/) const {}
};

}  // namespace graphsolve

#pragma once

#include <Eigen/Core>
#include <span>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

using BlockView = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

using ConstBlockView = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

/// A block of the matrix as one of Eigen's, to be read and written in place. For those who use Eigen; the library itself
/// does not need it.
inline BlockView block_view(double* values, const BlockHandle& block) {
  const Eigen::Index stride = block.stride;
  return {values + block.offset, block.rows, block.columns, {stride * block.rows, stride}};
}
inline BlockView block_view(std::span<double> values, const BlockHandle& block) { return block_view(values.data(), block); }
inline ConstBlockView block_view(std::span<const double> values, const BlockHandle& block) {
  const Eigen::Index stride = block.stride;
  return {values.data() + block.offset, block.rows, block.columns, {stride * block.rows, stride}};
}

}  // namespace graphsolve

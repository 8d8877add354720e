#include "matrix_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "graphsolve/io/block_map.hpp"
#include "physics/mechanism.hpp"

namespace cli {

using namespace graphsolve;
using physics::DescriptionError;

namespace {

/// A value in [-1, 1] for the places (i, j) and (j, i) alike.
double seeded_value(int i, int j) {
  std::uint64_t x = static_cast<std::uint64_t>(std::min(i, j)) << 32 | static_cast<std::uint64_t>(std::max(i, j));
  x += 0x9e3779b97f4a7c15u;  // splitmix64
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

/// Every row's diagonal exceeds the sum of the rest of its row and column by one.
void fill_pattern(SparseMatrix& matrix) {
  std::vector<Triplet> triplets;
  std::vector<double> sum(static_cast<std::size_t>(matrix.rows), 1.0);
  for (int j = 0; j < matrix.columns; ++j) {
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const int i = matrix.row[k];
      if (i == j) continue;
      const double value = seeded_value(i, j);
      triplets.push_back({i, j, value});
      sum[i] += std::abs(value) / 2;
      sum[j] += std::abs(value) / 2;
    }
  }
  for (int i = 0; i < matrix.rows; ++i) triplets.push_back({i, i, sum[i]});
  matrix = from_triplets(matrix.rows, matrix.columns, triplets);
}

}  // namespace

void translate_errors(const std::string& name, const std::function<void()>& work) {
  try {
    work();
  } catch (const io::FileError& error) {
    throw DescriptionError(error.what());
  } catch (const std::invalid_argument& error) {
    throw DescriptionError(fmt::format("{}: {}", name, error.what()));
  }
}

MatrixSource load_matrix(const std::string& path, const std::string& map_path) {
  MatrixSource source;
  translate_errors(path, [&] {
    source.file = io::read_matrix_market(path);
    SparseMatrix& matrix = source.file.matrix;
    if (matrix.rows != matrix.columns)
      throw std::invalid_argument(fmt::format("the matrix must be square, not {} x {}", matrix.rows, matrix.columns));
    source.seeded = source.file.field == io::Field::pattern;
    if (source.seeded) fill_pattern(matrix);
    if (map_path.empty()) source.blocks = detect_blocks(matrix);
  });
  if (map_path.empty()) return source;
  translate_errors(map_path, [&] {
    io::BlockMap map = io::read_block_map(map_path);
    source.blocks = make_blocks(source.file.matrix, map.blocks, map.couplings);
    source.couplings = std::move(map.couplings);
  });
  return source;
}

std::string block_map_text(const MatrixSource& source) {
  io::BlockMap map = io::block_map(source.blocks);
  for (const BlockCoupling& c : source.couplings)  // room for later entries, which the structure cannot tell from others
    if (c.rank == EdgeRank::unknown) map.couplings.push_back(c);
  return io::block_map_json(map);
}

std::string count(long long n, const char* one, const char* many) { return fmt::format("{} {}", n, n == 1 ? one : many); }

std::string describe(const MatrixSource& source, const std::string& map) {
  const SparseMatrix& matrix = source.file.matrix;
  const BlockGraph& graph = source.blocks.graph;
  int largest = 0, saddle = 0, semidefinite = 0, shared = 0;
  for (int v = 0; v < graph.size(); ++v) {
    largest = std::max(largest, graph.dimension({v}));
    saddle += graph.kind({v}) == NodeKind::saddle;
    semidefinite += graph.kind({v}) == NodeKind::semidefinite;
    shared += graph.kind({v}) == NodeKind::shared;
  }
  std::string text = fmt::format("{} x {}, {}, {}", matrix.rows, matrix.columns,
                                 count(matrix.entries(), "entry", "entries"),
                                 source.blocks.symmetric ? "symmetric" : "unsymmetric");
  if (source.blocks.added_entries > 0)
    text += fmt::format(" ({} added to make the pattern symmetric)", count(source.blocks.added_entries, "zero", "zeros"));
  if (source.file.repeated > 0) text += fmt::format(", {} added up", count(source.file.repeated, "repeated entry", "repeated entries"));
  if (source.seeded) text += ", a pattern: values are seeded, the diagonal dominant";
  text += fmt::format("; {} {} (largest {})", count(graph.size(), "block", "blocks"),
                      map.empty() ? "found" : "from " + map, count(largest, "row", "rows"));
  if (saddle > 0) text += fmt::format(", {} saddle", saddle);
  if (semidefinite > 0) text += fmt::format(", {} semidefinite", semidefinite);
  if (shared > 0) text += fmt::format(", {} shared", shared);
  return text;
}

}  // namespace cli

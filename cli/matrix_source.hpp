#pragma once

#include <functional>
#include <string>
#include <vector>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/io/matrix_market.hpp"

/// Where a matrix and its blocks come from, for the commands that take one.
namespace cli {

struct MatrixSource {
  graphsolve::io::MatrixFile file;
  graphsolve::BlockStructure blocks;
  std::vector<graphsolve::BlockCoupling> couplings;  ///< of the block map that was given
  bool seeded = false;  ///< the file is a pattern: values were made up
};

/// Reads the matrix; blocks from the map, or found when `map` is empty. A pattern gets seeded values: symmetric when
/// the file is, the diagonal dominant. Throws DescriptionError that names the file.
MatrixSource load_matrix(const std::string& path, const std::string& map);

/// The blocks as a file for --blocks: read again it gives the same graph.
std::string block_map_text(const MatrixSource& source);

/// Runs what may throw errors of graphsolve (std::invalid_argument, FileError), and throws them as DescriptionErrors;
/// `name` is put before those that name no file.
void translate_errors(const std::string& name, const std::function<void()>& work);

/// "1 row", "7 blocks".
std::string count(long long n, const char* one, const char* many);

/// One line for people: "494 x 494, 1666 entries, symmetric; 450 blocks found (largest 4), 12 of them saddle".
std::string describe(const MatrixSource& source, const std::string& map);

}  // namespace cli

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"

namespace graphsolve {

/// What is wrong with a matrix, by the names of its blocks. Made after the fact, not in a hurry: it allocates, and its
/// cost is that of a general sparse LU. Data here, one readable text from to_string().
struct Diagnosis {
  struct Entry {
    std::string row_node, column_node;
    int row = 0, column = 0;  ///< within the block
    double value = 0;
  };
  std::vector<Entry> not_finite;  ///< NaN or infinite entries of the matrix; all else is left empty when there are any

  std::optional<std::string> failed;          ///< node of the pivot where the factorization ended
  std::vector<std::string> failed_neighbours;  ///< its neighbours in the graph

  struct Group {
    std::vector<std::string> nodes;  ///< that depend on each other
    int redundant_rows = 0;
  };
  std::vector<Group> redundant;  ///< from the rows that the factorization left out

  std::optional<Inertia> inertia;  ///< symmetric kinds only
  int boosts = 0;                  ///< of the factorization: so many of inertia->zero are of a sign that is not known

  struct Row {
    std::string node;
    int row = 0;
  };
  std::vector<Row> zero_rows;  ///< rows without any entry
  int rows = 0;
  int structural_rank = 0;  ///< most rows and columns that can be paired by entries; less than rows: singular for any values

  struct Share {
    std::string node;
    double share = 0;  ///< of the squared length, sums to 1
  };
  std::vector<Share> near_null;   ///< blocks of the vector that A shortens most, largest first; shares above 1e-6
  double smallest_singular = 0;   ///< estimate, |A v| / |v| with that v
  double largest_singular = 0;    ///< estimate of the largest column: max |a_j|
};

/// graph: that of the factorization.  factorization: after factorize() with the matrix kept.  outcome: of that call.
/// Throws std::invalid_argument when the matrix was not kept.
Diagnosis diagnose(const BlockGraph& graph, const Factorization& factorization, const Factorization::Outcome& outcome);

/// Does the matrix shorten some vector v to rounding, |A v| <= 4e-15 ||A| |v||, whatever the number of its rows and the units
/// of rows and columns? Asked twice: with largest entries scaled to near 1, and with the middles of rows and columns near 1
/// first. By two sweeps of inverse iteration with the factors, the vector found being judged by the matrix; where pivots were
/// boosted, rows left out, or factors disagree with the matrix, by a general sparse LU. A solution with a small backward error
/// does not say so: many singular systems are solved to rounding. Of a RobustSolver: its factorization(), Report::outcome.
/// Arguments and throws as diagnose(). False where the matrix holds a number that is none.
bool is_singular(const Factorization& factorization, const Factorization::Outcome& outcome);

/// Some lines of text, each one finding.
std::string to_string(const Diagnosis& diagnosis);

}  // namespace graphsolve

#include "graph/structural_rank.hpp"

#include <vector>

namespace graphsolve {

namespace {

struct Matching {
  std::vector<int> column_of_row, seen, reached_from;  // per row
  std::vector<int> queue;
};

/// Looks for a path from a free column to a free row and turns it over.
bool augment(const Eigen::SparseMatrix<double>& a, int start, Matching& m) {
  m.queue.assign(1, start);
  for (std::size_t q = 0; q < m.queue.size(); ++q) {
    const int column = m.queue[q];
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, column); entry; ++entry) {
      int row = static_cast<int>(entry.row());
      if (m.seen[row] == start) continue;
      m.seen[row] = start;
      m.reached_from[row] = column;
      if (m.column_of_row[row] >= 0) {
        m.queue.push_back(m.column_of_row[row]);
        continue;
      }
      for (;;) {  // back along the path: every column takes the row it was reached through
        const int taker = m.reached_from[row];
        int given_up = -1;
        if (taker != start)
          for (Eigen::SparseMatrix<double>::InnerIterator own(a, taker); own; ++own)
            if (m.column_of_row[own.row()] == taker) given_up = static_cast<int>(own.row());
        m.column_of_row[row] = taker;
        if (taker == start) return true;
        row = given_up;
      }
    }
  }
  return false;
}

Matching no_matching(const Eigen::SparseMatrix<double>& a) {
  const auto n = static_cast<std::size_t>(a.rows());
  return {std::vector<int>(n, -1), std::vector<int>(n, -1), std::vector<int>(n, -1), {}};
}

/// Gives the column a row, its own or after others moved.
bool match(const Eigen::SparseMatrix<double>& a, int column, Matching& m) {
  for (Eigen::SparseMatrix<double>::InnerIterator entry(a, column); entry; ++entry)
    if (m.column_of_row[entry.row()] < 0) {
      m.column_of_row[entry.row()] = column;
      return true;
    }
  return augment(a, column, m);
}

}  // namespace

int structural_rank(const Eigen::SparseMatrix<double>& a) {
  Matching m = no_matching(a);
  int rank = 0;
  for (int column = 0; column < a.cols(); ++column) rank += match(a, column, m);
  return rank;
}

bool has_full_column_rank(const Eigen::SparseMatrix<double>& a) {
  Matching m = no_matching(a);
  for (int column = 0; column < a.cols(); ++column)
    if (!match(a, column, m)) return false;
  return true;
}

}  // namespace graphsolve

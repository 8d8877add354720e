#include <algorithm>
#include <cstdio>

#include "graphsolve/diagnosis.hpp"

namespace graphsolve {

namespace {

constexpr std::size_t most = 8;  ///< names in one line

std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i > 0 ? ", '" : "'") + names[i] + "'";
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string near_null_line(const Diagnosis& d) {
  std::string text = "smallest singular value about " + number(d.smallest_singular) + " (largest column " +
                     number(d.largest_singular) + "); its vector lies in";
  for (std::size_t i = 0; i < std::min(d.near_null.size(), most); ++i)
    text += (i > 0 ? ", '" : " '") + d.near_null[i].node + "' " + number(100 * d.near_null[i].share) + " %";
  return text + "\n";
}

/// A boosted pivot had no size, and whether it hides a zero is not known. Each changed the matrix by a rank of one with a
/// sign, so that the others are bounds.
std::string inertia_line(const Diagnosis& d) {
  const std::string at_least = d.boosts > 0 ? "at least " : "";
  std::string text = "inertia: " + at_least + std::to_string(d.inertia->positive) + " positive, " + at_least +
                     std::to_string(d.inertia->negative) + " negative, " + std::to_string(d.inertia->zero - d.boosts) + " zero";
  if (d.boosts > 0) text += ", " + std::to_string(d.boosts) + " not known (pivots without size of their own, boosted)";
  return text + "\n";
}

}  // namespace

std::string to_string(const Diagnosis& d) {
  std::string text;
  for (std::size_t i = 0; i < std::min(d.not_finite.size(), most); ++i) {
    const auto& e = d.not_finite[i];
    text += "entry (" + std::to_string(e.row) + ", " + std::to_string(e.column) + ") of block ('" + e.row_node + "', '" +
            e.column_node + "') is " + number(e.value) + "\n";
  }
  if (d.not_finite.size() > most) text += "and " + std::to_string(d.not_finite.size() - most) + " more such entries\n";
  if (!d.not_finite.empty()) return text;
  if (d.failed) {
    text += "the elimination ended at block '" + *d.failed + "'";
    text += d.failed_neighbours.empty() ? ", which has no neighbours\n" : ", neighbour of " + quoted(d.failed_neighbours) + "\n";
  }
  for (const auto& group : d.redundant)
    text += std::to_string(group.redundant_rows) + (group.redundant_rows == 1 ? " row" : " rows") + " too many among " +
            quoted(group.nodes) + "\n";
  for (std::size_t i = 0; i < std::min(d.zero_rows.size(), most); ++i)
    text += "row " + std::to_string(d.zero_rows[i].row) + " of '" + d.zero_rows[i].node + "' has no entry\n";
  if (d.zero_rows.size() > most) text += "and " + std::to_string(d.zero_rows.size() - most) + " more rows without entries\n";
  if (d.structural_rank < d.rows)
    text += "structural rank " + std::to_string(d.structural_rank) + " of " + std::to_string(d.rows) +
            ": singular whatever the values\n";
  if (d.inertia) text += inertia_line(d);
  if (!d.near_null.empty()) text += near_null_line(d);
  return text;
}

}  // namespace graphsolve

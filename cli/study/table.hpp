#pragma once

#include <string>
#include <vector>

namespace cli::study {

/// Aligned columns for a terminal: the first to the left, the others to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> heads);
  /// One cell per head (asserted).
  void add(std::vector<std::string> cells);
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;  ///< the heads are row 0
};

/// At most this many significant digits, without an exponent from 0.001 to 99999; "-" for what is not finite.
std::string number(double value, int digits = 3);

}  // namespace cli::study

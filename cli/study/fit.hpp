#pragma once

#include <span>
#include <string>

namespace cli::study {

/// y = factor x^exponent, fitted by least squares to the logarithms.
struct PowerLaw {
  double factor = 0, exponent = 0;
  double low = 0, high = 0;  ///< 95 % interval of the exponent (Student's t); infinite for two points
  int points = 0;
  [[nodiscard]] double at(double x) const;
};

/// x, y: equal lengths, >= 2, all > 0, not all x equal (asserted).
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y);

/// How y grows with what is counted: "linear in the contacts", as far as the interval of the exponent allows to say so.
std::string growth_in_words(const PowerLaw& law, const std::string& counts);

/// y = fixed + rate x, fitted to the relative deviations.
struct Line {
  double fixed = 0, rate = 0;
  double deviation = 0;  ///< largest of |fixed + rate x - y| / y
};

/// As above.
Line fit_line(std::span<const double> x, std::span<const double> y);

/// x at which the broken line through the points, straight in the logarithms, first passes y.
/// Points in order of x, x and y > 0; NaN when no two neighbours enclose y.
double crossing(std::span<const double> x, std::span<const double> y, double level);

}  // namespace cli::study

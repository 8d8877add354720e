#include "study/fit.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace cli::study {

namespace {

/// 97.5 % point of Student's t.
double student(int freedom) {
  constexpr std::array table{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                             2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086};
  if (freedom < 1) return std::numeric_limits<double>::infinity();
  if (freedom <= static_cast<int>(table.size())) return table[freedom - 1];
  return 1.960 + 2.5 / freedom;  // within 0.001
}

}  // namespace

double PowerLaw::at(double x) const { return factor * std::pow(x, exponent); }

PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y) {
  assert(x.size() == y.size() && x.size() >= 2);
  const int n = static_cast<int>(x.size());
  double mean_x = 0, mean_y = 0;
  for (int i = 0; i < n; ++i) {
    assert(x[i] > 0 && y[i] > 0);
    mean_x += std::log(x[i]) / n;
    mean_y += std::log(y[i]) / n;
  }
  double xx = 0, xy = 0;
  for (int i = 0; i < n; ++i) {
    const double dx = std::log(x[i]) - mean_x;
    xx += dx * dx;
    xy += dx * (std::log(y[i]) - mean_y);
  }
  assert(xx > 0);
  PowerLaw law{.exponent = xy / xx, .points = n};
  law.factor = std::exp(mean_y - law.exponent * mean_x);
  double rest = 0;
  for (int i = 0; i < n; ++i) {
    const double off = std::log(y[i]) - mean_y - law.exponent * (std::log(x[i]) - mean_x);
    rest += off * off;
  }
  const double error = n > 2 ? std::sqrt(rest / (n - 2) / xx) : 1;
  law.low = law.exponent - student(n - 2) * error;
  law.high = law.exponent + student(n - 2) * error;
  return law;
}

Line fit_line(std::span<const double> x, std::span<const double> y) {
  assert(x.size() == y.size() && x.size() >= 2);
  // Least squares of (fixed + rate x) / y - 1: the two normal equations.
  double aa = 0, ab = 0, bb = 0, a = 0, b = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double p = 1 / y[i], q = x[i] / y[i];
    aa += p * p, ab += p * q, bb += q * q, a += p, b += q;
  }
  const double determinant = aa * bb - ab * ab;
  assert(determinant > 0);
  Line line{.fixed = (a * bb - b * ab) / determinant, .rate = (b * aa - a * ab) / determinant};
  for (std::size_t i = 0; i < x.size(); ++i)
    line.deviation = std::max(line.deviation, std::abs((line.fixed + line.rate * x[i]) / y[i] - 1));
  return line;
}

double crossing(std::span<const double> x, std::span<const double> y, double level) {
  assert(x.size() == y.size());
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (std::min(y[i - 1], y[i]) > level || std::max(y[i - 1], y[i]) < level) continue;
    if (y[i - 1] == y[i]) return x[i - 1];
    const double part = std::log(level / y[i - 1]) / std::log(y[i] / y[i - 1]);
    return x[i - 1] * std::pow(x[i] / x[i - 1], part);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::string growth_in_words(const PowerLaw& law, const std::string& counts) {
  if (!std::isfinite(law.exponent)) return "too few sizes were solved to say how it grows";
  if (law.low > 1.1) return "more than linear in the " + counts;
  if (law.high > 1.1) return "nearly linear in the " + counts;
  if (law.exponent < 0.9) return "less than linear in the " + counts;
  return "linear in the " + counts;
}

}  // namespace cli::study

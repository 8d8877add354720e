#pragma once

#include <string>
#include <vector>

/// Pictures through gnuplot, which runs as a program of its own.
namespace cli::study {

struct Series {
  enum class Style { line_with_points, points, line };
  std::string label;
  Style style = Style::line_with_points;
  int colour = 0;            ///< 0 .. 7, colours that differ for everyone
  int mark = 0;              ///< 0 .. 7, shape of the points
  std::vector<double> x, y;  ///< > 0; others are left out
};

/// Both axes logarithmic.
struct Picture {
  std::string file;              ///< without folder, "scaling-disc.svg"
  std::string title;             ///< the finding; may have several lines
  std::string x_label, y_label;  ///< with units
  std::string note;              ///< small, at the bottom: where the data come from
  std::vector<Series> series;
};

/// What gnuplot is told; writes to `path`.
std::string gnuplot_script(const Picture& picture, const std::string& path);

[[nodiscard]] bool have_gnuplot();

/// Writes the SVG; it appears complete or not at all. False when gnuplot failed (it says why on stderr).
[[nodiscard]] bool draw(const Picture& picture, const std::string& folder);

}  // namespace cli::study

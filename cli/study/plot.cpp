#include "study/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <system_error>

namespace cli::study {

namespace {

constexpr std::array colours{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999"};
constexpr std::array marks{7, 5, 9, 13, 6, 4, 8, 12};  // filled circle, square, triangle, diamond; then open ones

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string style(const Series& series) {
  const std::string line = fmt::format("lc rgb '{}'", colours[series.colour % colours.size()]);
  const std::string mark = fmt::format("pt {} ps 0.8", marks[series.mark % marks.size()]);
  switch (series.style) {
    case Series::Style::line:
      return fmt::format("with lines lw 1.5 dt 2 {}", line);
    case Series::Style::points:
      return fmt::format("with points {} {}", line, mark);
    default:
      return fmt::format("with linespoints lw 2 {} {}", line, mark);
  }
}

/// Numbers where they are readable, powers of ten where they are not.
std::string axis_format(const Picture& picture, const std::vector<double> Series::*values) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const Series& series : picture.series)
    for (const double value : series.*values)
      if (value > 0) low = std::min(low, value), high = std::max(high, value);
  return low >= 1e-3 && high < 1e5 ? "%g" : "10^{%T}";
}

}  // namespace

std::string gnuplot_script(const Picture& picture, const std::string& path) {
  std::string script = "set terminal svg size 960,680 dynamic font 'Helvetica,17' background rgb 'white'\n";
  script += fmt::format("set output {}\n", quoted(path));
  script += fmt::format("set title {} noenhanced font ',20'\n", quoted(picture.title));
  script += fmt::format("set xlabel {} noenhanced\nset ylabel {} noenhanced\n", quoted(picture.x_label),
                        quoted(picture.y_label));
  script += fmt::format("set format x '{}'\nset format y '{}'\n", axis_format(picture, &Series::x),
                        axis_format(picture, &Series::y));
  script += "set logscale xy\nset grid xtics ytics lc rgb '#dddddd' lt 1\nset border 3\nset tics nomirror\n";
  script +=
      "set key at screen 0.12, 0.165 left top horizontal reverse Left noenhanced maxcols 2 font ',15' samplen 3 width "
      "4\n";
  script += fmt::format("set label 1 {} at screen 0.985, 0.02 right noenhanced font ',11' tc rgb '#666666'\n",
                        quoted(picture.note));
  script += "set bmargin at screen 0.29\nset rmargin 3\n";
  std::string plots;
  for (std::size_t i = 0; i < picture.series.size(); ++i) {
    const Series& series = picture.series[i];
    script += fmt::format("$data{} << EOD\n", i);
    for (std::size_t k = 0; k < series.x.size(); ++k)
      if (series.x[k] > 0 && series.y[k] > 0) script += fmt::format("{:.9g} {:.9g}\n", series.x[k], series.y[k]);
    script += "EOD\n";
    plots += fmt::format("{}$data{} {} title {}", i ? ", " : "", i, style(series), quoted(series.label));
  }
  return script + "plot " + plots + "\n";
}

bool have_gnuplot() { return std::system("command -v gnuplot >/dev/null 2>&1") == 0; }

bool draw(const Picture& picture, const std::string& folder) {
  namespace fs = std::filesystem;
  const fs::path path = fs::path(folder) / picture.file;
  const fs::path part = path.string() + ".part";
  // If gnuplot ends early, writing to it must not end us.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::FILE* pipe = popen("gnuplot", "w");
  bool fine = pipe != nullptr;
  if (fine) {
    const std::string script = gnuplot_script(picture, part.string());
    fine = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
    fine = pclose(pipe) == 0 && fine;
  }
  std::signal(SIGPIPE, before);
  std::error_code error;
  fine ? fs::rename(part, path, error) : void(fs::remove(part, error));
  return fine && !error;
}

}  // namespace cli::study

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "graphsolve/io/draw.hpp"
#include "io/shown.hpp"

namespace graphsolve::io {

namespace {

constexpr double side = 640, left = 24, top = 84;  // of the plot [px]
constexpr int most_named_nodes = 150;
constexpr int pixels = 320;  // per side of an aggregated plot

// Colours that also people with defective colour vision tell apart (Okabe and Ito); the matrix is dark.
constexpr const char* matrix_colour = "#3b4252";
constexpr std::array colours{"#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#b8a800"};
constexpr const char* other_colour = "#999999";

std::string number(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, std::round(value * 100) / 100).ptr};
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : shown(text)) {
    if (c == '&') out += "&amp;";
    else if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '"') out += "&quot;";
    else out += c;
  }
  return out;
}

/// One block of the lower triangle: pivots row >= column; cause -1: of the matrix, else a rank (0: most scalars).
struct Cell {
  int row, column, cause;
};

/// Blocks with their causes, the causes ranked by the scalars they make.
struct Picture {
  std::vector<Cell> cells;
  std::vector<std::string> names;     ///< by rank
  std::vector<std::int64_t> scalars;  ///< of fill by rank, one triangle
  std::vector<std::int64_t> first;    ///< row of every pivot in elimination order, and the end
};

/// Causes in the order of their weight.
std::vector<int> ranks_of(const std::vector<std::int64_t>& weight) {
  std::vector<int> order(weight.size()), rank(weight.size());
  for (std::size_t c = 0; c < order.size(); ++c) order[c] = static_cast<int>(c);
  std::ranges::stable_sort(order, [&](int a, int b) { return weight[a] > weight[b]; });
  for (std::size_t r = 0; r < order.size(); ++r) rank[order[r]] = static_cast<int>(r);
  return rank;
}

Picture gather(const Symbolic& symbolic, const FillCauses& causes) {
  Picture picture;
  picture.first.push_back(0);
  const std::size_t count = causes.names.empty() ? 1 : causes.names.size();
  std::vector<std::int64_t> weight(count, 0);
  std::size_t fills = 0;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    picture.first.push_back(picture.first.back() + symbolic.dimension(k));
    picture.cells.push_back({k, k, -1});
    const auto coupled = symbolic.coupled(k);
    for (int e = 0; e < static_cast<int>(coupled.size()); ++e) {
      int cause = -1;
      if (symbolic.is_fill(k, e)) {
        cause = fills < causes.of_fill.size() ? causes.of_fill[fills] : 0;
        ++fills;
        weight[cause] += std::int64_t{symbolic.dimension(k)} * symbolic.dimension(coupled[e]);
      }
      picture.cells.push_back({coupled[e], k, cause});
    }
  }
  const std::vector<int> rank = ranks_of(weight);
  for (Cell& cell : picture.cells)
    if (cell.cause >= 0) cell.cause = rank[cell.cause];
  picture.names.resize(count, "fill");
  picture.scalars.resize(count);
  for (std::size_t c = 0; c < count; ++c) {
    if (!causes.names.empty()) picture.names[rank[c]] = causes.names[c];
    picture.scalars[rank[c]] = weight[c];
  }
  return picture;
}

/// Colour index of a rank: the weakest share one.
int colour_index(int cause) { return std::min(cause, static_cast<int>(colours.size())); }
const char* colour(int index) {
  return index < 0 ? matrix_colour : index < static_cast<int>(colours.size()) ? colours[index] : other_colour;
}

std::string draw_blocks(const Picture& picture, const BlockGraph& graph, const Symbolic& symbolic) {
  const double scale = side / static_cast<double>(picture.first.back());
  const double gap = std::min(0.5, 0.08 * scale);
  std::string svg;
  const auto draw = [&](int row, int column, const Cell& cell) {
    const double x = left + scale * static_cast<double>(picture.first[column]), y = top + scale * static_cast<double>(picture.first[row]);
    const double w = scale * symbolic.dimension(column) - gap, h = scale * symbolic.dimension(row) - gap;
    svg += "<rect x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(w) + "\" height=\"" + number(h) +
           "\" fill=\"" + colour(colour_index(cell.cause)) + "\"><title>" +
           escaped(graph.name(symbolic.node(row)));
    if (row != column) svg += " - " + escaped(graph.name(symbolic.node(column)));
    svg += ": " + std::to_string(symbolic.dimension(row)) + " x " + std::to_string(symbolic.dimension(column));
    if (cell.cause >= 0) svg += ", fill: " + escaped(picture.names[cell.cause]);
    svg += "</title></rect>\n";
  };
  for (const Cell& cell : picture.cells) {
    draw(cell.row, cell.column, cell);
    if (cell.row != cell.column) draw(cell.column, cell.row, cell);
  }
  return svg;
}

/// Scalars by colour in every pixel. A block larger than a pixel is spread over those it covers, by area.
class Raster {
 public:
  explicit Raster(std::int64_t rows) : per_pixel_(static_cast<double>(rows) / pixels), area_(layers) {
    for (auto& layer : area_) layer.assign(pixels * pixels, 0.0f);
  }

  void add(double y0, double y1, double x0, double x1, int layer) {
    const int i0 = index(y0), i1 = last(y1), j0 = index(x0), j1 = last(x1);
    for (int i = i0; i <= i1; ++i)
      for (int j = j0; j <= j1; ++j)
        area_[layer][i * pixels + j] += static_cast<float>(overlap(y0, y1, i) * overlap(x0, x1, j));
  }

  /// Pixels of one look in one path each, runs of equal ones joined.
  [[nodiscard]] std::string draw() const {
    std::map<std::pair<int, int>, std::string> paths;  // by colour and opacity
    const double step = side / pixels;
    for (int i = 0; i < pixels; ++i) {
      for (int j = 0, end = 0; j < pixels; j = end) {
        const auto look = look_of(i, j);
        for (end = j + 1; end < pixels && look_of(i, end) == look;) ++end;
        if (look.second == 0) continue;
        paths[look] += "M" + number(left + j * step) + " " + number(top + i * step) + "h" + number((end - j) * step) +
                       "v" + number(step) + "h-" + number((end - j) * step) + "z";
      }
    }
    std::string svg;
    for (const auto& [look, path] : paths)
      svg += std::string("<path fill=\"") + colour(look.first) + "\" fill-opacity=\"" + number(look.second * 0.2) +
             "\" d=\"" + path + "\"/>\n";
    return svg;
  }

  static constexpr int layers = static_cast<int>(colours.size()) + 2;  ///< matrix, causes, the others

 private:
  [[nodiscard]] int index(double row) const { return std::min(pixels - 1, static_cast<int>(row / per_pixel_)); }
  [[nodiscard]] int last(double row) const {
    return std::clamp(static_cast<int>(std::ceil(row / per_pixel_)) - 1, 0, pixels - 1);
  }
  [[nodiscard]] double overlap(double from, double to, int pixel) const {
    return std::max(0.0, std::min(to, (pixel + 1) * per_pixel_) - std::max(from, pixel * per_pixel_));
  }
  /// The colour with most scalars, and an opacity 0 .. 5 by the part of the pixel that is filled.
  [[nodiscard]] std::pair<int, int> look_of(int i, int j) const {
    int strongest = 0;
    double sum = 0;
    for (int layer = 0; layer < layers; ++layer) {
      const double here = area_[layer][i * pixels + j];
      sum += here;
      if (here > area_[strongest][i * pixels + j]) strongest = layer;
    }
    if (sum <= 0) return {0, 0};
    const double part = std::sqrt(sum / (per_pixel_ * per_pixel_));
    return {strongest - 1, std::clamp(static_cast<int>(std::ceil(5 * part)), 2, 5)};
  }

  double per_pixel_;
  std::vector<std::vector<float>> area_;
};

std::string draw_pixels(const Picture& picture) {
  Raster raster(picture.first.back());
  for (const Cell& cell : picture.cells) {
    const double y0 = static_cast<double>(picture.first[cell.row]), y1 = static_cast<double>(picture.first[cell.row + 1]);
    const double x0 = static_cast<double>(picture.first[cell.column]), x1 = static_cast<double>(picture.first[cell.column + 1]);
    const int layer = colour_index(cell.cause) + 1;
    raster.add(y0, y1, x0, x1, layer);
    if (cell.row != cell.column) raster.add(x0, x1, y0, y1, layer);
  }
  return raster.draw();
}

std::string text(double x, double y, int size, std::string_view content, const char* more = "") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" font-size=\"" + std::to_string(size) + "\" " + more + ">" +
         escaped(content) + "</text>\n";
}

/// What fits beside the plot; never cut inside of a UTF-8 character.
std::string shortened(const std::string& label) {
  constexpr std::size_t most = 40;
  if (label.size() <= most) return label;
  std::size_t end = most - 3;
  while (end > 0 && (static_cast<unsigned char>(label[end]) & 0xc0) == 0x80) --end;
  return label.substr(0, end) + "...";
}

std::string legend(const Picture& picture) {
  std::string svg;
  double y = top + 12;
  const double x = left + side + 20;
  std::int64_t all = 0, rest = 0;
  for (const std::int64_t scalars : picture.scalars) all += scalars;
  // "3 cycles of 12 blocks: a, b, ..." in two lines.
  const auto entry = [&](const char* fill, const std::string& name, const std::string& detail) {
    const std::size_t colon = name.find(": ");
    const std::string label = name.substr(0, colon);
    svg += "<rect x=\"" + number(x) + "\" y=\"" + number(y - 11) + "\" width=\"14\" height=\"14\" rx=\"2\" fill=\"" + fill +
           "\"/>\n" + text(x + 22, y, 13, shortened(label));
    if (colon != std::string::npos) svg += text(x + 22, y += 16, 11, shortened(name.substr(colon + 2)), "fill=\"#667\"");
    if (!detail.empty()) svg += text(x + 22, y + 16, 11, detail, "fill=\"#667\"");
    y += detail.empty() ? 26 : 42;
  };
  const auto share = [&](std::int64_t scalars) {
    return std::to_string(scalars) + (scalars == 1 ? " scalar, " : " scalars, ") + number(100.0 * static_cast<double>(scalars) / static_cast<double>(all)) +
           " % of the fill";
  };
  entry(matrix_colour, "the matrix", "");
  for (std::size_t c = 0; c < picture.scalars.size(); ++c) {
    if (picture.scalars[c] == 0) continue;
    if (c < colours.size()) entry(colours[c], picture.names[c], share(picture.scalars[c]));
    else rest += picture.scalars[c];
  }
  if (rest > 0) entry(other_colour, "smaller causes", share(rest));
  return svg;
}

}  // namespace

double fill_ratio(const Symbolic& symbolic) {
  // A diagonal block of d rows counts d (d + 1) / 2, a coupling once.
  const auto& c = symbolic.counts();
  return static_cast<double>(c.stored_scalars + symbolic.rows()) / static_cast<double>(c.matrix_scalars + symbolic.rows());
}

std::string spy_svg(const BlockGraph& graph, const Symbolic& symbolic, const SpyOptions& options) {
  const Picture picture = gather(symbolic, options.causes);
  const auto& counts = symbolic.counts();
  std::string title = options.title;
  if (title.empty())
    title = counts.fill_blocks == 0 ? "No fill: the factor is as sparse as the matrix"
                                    : std::to_string(counts.fill_blocks) + " fill blocks: the factor is " +
                                          number(fill_ratio(symbolic)) + " times the matrix";
  const double width = left + side + 300, height = top + side + 24;
  std::string svg = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
                    number(width) + "\" height=\"" + number(height) + "\" viewBox=\"0 0 " + number(width) + " " +
                    number(height) + "\" font-family=\"sans-serif\" fill=\"#223\">\n<rect width=\"100%\" height=\"100%\" "
                    "fill=\"#ffffff\"/>\n";
  svg += text(left, 34, 20, title, "font-weight=\"bold\"") + text(left, 60, 13, options.subtitle, "fill=\"#667\"");
  svg += "<rect x=\"" + number(left) + "\" y=\"" + number(top) + "\" width=\"" + number(side) + "\" height=\"" + number(side) +
         "\" fill=\"#fafafa\" stroke=\"#ccccd4\"/>\n";
  // Pixels may be thinner than what a screen shows: no smoothing between them.
  const bool blocks = graph.size() <= most_named_nodes;
  svg += blocks ? "<g>\n" : "<g shape-rendering=\"crispEdges\">\n";
  svg += blocks ? draw_blocks(picture, graph, symbolic) : draw_pixels(picture);
  return svg + "</g>\n" + legend(picture) + "</svg>\n";
}

}  // namespace graphsolve::io

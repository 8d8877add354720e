#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "interior_point/impl.hpp"
#include "symbolic/same_nodes.hpp"
#include "simd/vector_kernels.hpp"

/// What is made once, lists of instances by component, and what every solve begins with. The loop itself is in
/// loop.cpp, points to start from in starts.cpp, what ends it in judge.cpp.
namespace graphsolve {

namespace {

constexpr double least_diagonal = 1e-4;  ///< of what a row is coupled by, to be its scale
constexpr double saddle_shift = 1e-12;  ///< of the diagonal of a constraint's pivot block; Newton takes it out again

void check(const InteriorPointSettings& settings) {
  const auto positive = [](double value, const char* name) {
    if (!(value > 0 && std::isfinite(value)))
      throw std::invalid_argument(std::string("interior point: ") + name + " is " + std::to_string(value) +
                                  ", and must be a number > 0");
  };
  positive(settings.tolerance, "tolerance");
  positive(settings.largest_product, "largest_product");
  positive(settings.start_part, "start_part");
  if (!(settings.leave_out >= 0 && settings.leave_out < 1))
    throw std::invalid_argument("interior point: leave_out is " + std::to_string(settings.leave_out) +
                                ", and must be a number from 0 to 1");
  if (settings.max_iterations < 1)
    throw std::invalid_argument("interior point: max_iterations is " + std::to_string(settings.max_iterations) +
                                ", and must be at least 1");
}

std::int64_t count_instances(const Problem& problem) {
  std::int64_t count = 0;
  for (const Term* term : problem.terms()) count += term->size();
  for (const PortBatch* ports : problem.ports()) count += ports->size();
  return count;
}

}  // namespace

InteriorPoint::Impl::Impl(Problem& problem, std::shared_ptr<const Symbolic> symbolic, InteriorPointSettings settings)
    : problem_(problem), settings_(settings), factorization_(std::move(symbolic)) {
  check(settings);
  const Symbolic& s = factorization_.symbolic();
  check_same_nodes(s, problem_.graph(), "interior point");
  wiring_ = problem_.take_wiring();  // from here on nobody else may use the terms
  std::vector<BlockHandle> claims;
  const Wiring wiring(s, problem_.graph(), &claims);
  const int components = s.components();
  std::vector<int> component_of;
  const auto add_lists = [&](auto& batch, std::vector<Lists>& lists) {
    batch.wire(wiring);
    component_of.resize(batch.size());
    for (int i = 0; i < batch.size(); ++i) component_of[i] = s.component(batch.nodes(i).front());
    make_lists(lists.emplace_back(), component_of);
  };
  for (Term* term : problem_.terms()) add_lists(*term, term_lists_);
  for (PortBatch* ports : problem_.ports()) {
    add_lists(*ports, port_lists_);
    auto& given = port_lists_.back().given;
    given.resize(ports->size());
    std::iota(given.begin(), given.end(), 0);
  }
  instances_ = count_instances(problem_);
  factorization_.leave_unzeroed(claims);

  for (auto* v : {&x_, &dx_, &rhs_, &residual_}) v->assign(s.rows(), 0.0);
  row_scale_.assign(s.rows(), std::numeric_limits<double>::quiet_NaN());
  std::ranges::copy(problem_.row_scale(), row_scale_.begin());
  default_row_.resize(s.rows());
  default_rows_.assign(components, 0);
  for (int k = 0; k < s.pivots(); ++k)
    for (int i = s.row(k); i < s.row(k) + s.dimension(k); ++i)
      if (std::isnan(row_scale_[i])) {
        default_row_[i] = true;
        ++default_rows_[s.component(s.node(k))];
        ++defaults_;
      }
  if (defaults_ > 0) reach_.resize(s.rows());
  for (auto* v : {&error_, &product_, &mu_, &alpha_, &ratio_, &sum_, &correction_, &scale_, &change_, &port_error_})
    v->assign(components, 0.0);
  for (auto* v : {&degree_, &expected_iterations_}) v->assign(components, 0);
  course_.resize(components);
  at_start_.assign(components, 0);
  find_row_ranges();
  kernels_ = &simd::vector_kernels();
  factorization_.allow_refinement();
  factorization_.set_saddle_shift(saddle_shift, settings_.leave_out);
  reports_.resize(components);
  selected_.resize(components);
  std::iota(selected_.begin(), selected_.end(), 0);
  running_.reserve(components);
  listed_.reserve(components);
  some_.reserve(components);
}

/// What was added after the solver was made has no rows and blocks.
void InteriorPoint::Impl::check_point(std::size_t size) const {
  if (size != x_.size())
    throw std::invalid_argument("start of " + std::to_string(size) + " numbers, the graph has " +
                                std::to_string(x_.size()) + " rows");
  const std::size_t terms = problem_.terms().size(), ports = problem_.ports().size();
  if (terms != term_lists_.size() || ports != port_lists_.size())
    throw std::logic_error("interior point: made of " + std::to_string(term_lists_.size()) + " batches of terms and " +
                           std::to_string(port_lists_.size()) + " of ports, and the problem has " +
                           std::to_string(terms) + " and " + std::to_string(ports) +
                           " by now: make it after the last add");
  if (const std::int64_t now = count_instances(problem_); now != instances_)
    throw std::logic_error("interior point: made of " + std::to_string(instances_) + " terms and ports, and the batches of the "
                           "problem hold " + std::to_string(now) + " by now: make it after the last add");
  if (!problem_.wired(wiring_))
    throw std::logic_error("interior point: another InteriorPoint, or check_terms, has wired terms of this problem since: "
                           "only the last one may use them");
}

/// Adds a range to those from `first` on, or to the last of them.
void InteriorPoint::Impl::join(std::vector<RowRange>& ranges, std::size_t first, const RowRange& next) {
  if (ranges.size() > first && ranges.back().end == next.begin) ranges.back().end = next.end;
  else ranges.push_back(next);
}

void InteriorPoint::Impl::find_row_ranges() {
  const Symbolic& s = factorization_.symbolic();
  std::vector<RowRange> rows;
  row_range_begin_.reserve(s.components() + 1);
  for (int c = 0; c < s.components(); ++c) {
    row_range_begin_.push_back(static_cast<int>(row_ranges_.size()));
    rows.clear();
    for (int k = s.component_begin(c); k < s.component_begin(c + 1); ++k)
      rows.push_back({s.row(k), s.row(k) + s.dimension(k)});
    std::sort(rows.begin(), rows.end(), [](const RowRange& a, const RowRange& b) { return a.begin < b.begin; });
    const std::size_t first = row_ranges_.size();
    for (const RowRange& next : rows) join(row_ranges_, first, next);
  }
  row_range_begin_.push_back(static_cast<int>(row_ranges_.size()));
  row_ranges_.shrink_to_fit();
  running_rows_.reserve(row_ranges_.size());
}

void InteriorPoint::Impl::make_lists(Lists& lists, std::span<const int> component_of_instance) {
  lists.component.assign(component_of_instance.begin(), component_of_instance.end());
  lists.begin.assign(factorization_.symbolic().components() + 1, 0);
  lists.all.reserve(lists.component.size());
  lists.running.reserve(lists.component.size());
  std::vector<int> everything(lists.component.size());
  std::iota(everything.begin(), everything.end(), 0);
  sort_by_component(lists, everything);
}

/// Counting sort: within a component the given order is kept.
void InteriorPoint::Impl::sort_by_component(Lists& lists, std::span<const int> instances) {
  auto& begin = lists.begin;
  std::fill(begin.begin(), begin.end(), 0);
  for (const int i : instances) ++begin[lists.component[i]];
  std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), 0);
  lists.all.resize(instances.size());
  for (const int i : instances) lists.all[begin[lists.component[i]]++] = i;
  for (int c = static_cast<int>(begin.size()) - 1; c > 0; --c) begin[c] = begin[c - 1];
  begin[0] = 0;
}

namespace {

/// First number that is there twice, or -1. Long lists mostly come in ascending order.
int repeated(std::span<const int> list, std::vector<int>& scratch) {
  if (std::ranges::adjacent_find(list, std::greater_equal()) == list.end()) return -1;
  scratch.assign(list.begin(), list.end());
  std::ranges::sort(scratch);
  const auto found = std::ranges::adjacent_find(scratch);
  return found == scratch.end() ? -1 : *found;
}

}  // namespace

void InteriorPoint::Impl::activate(int batch, std::span<const int> instances) {
  if (batch < 0 || batch >= static_cast<int>(port_lists_.size()))
    throw std::invalid_argument("activate: there is no batch " + std::to_string(batch) + " of ports");
  Lists& lists = port_lists_[batch];
  if (std::ranges::equal(instances, lists.given)) return;
  for (const int i : instances)
    if (i < 0 || i >= static_cast<int>(lists.component.size()))
      throw std::invalid_argument("activate: batch " + std::to_string(batch) + " has no port " + std::to_string(i));
  lists_changed_ = true;  // and lists.running is free
  if (const int twice = repeated(instances, lists.running); twice >= 0)
    throw std::invalid_argument("activate: port " + std::to_string(twice) + " of batch " + std::to_string(batch) +
                                " is named twice");
  lists.given.assign(instances.begin(), instances.end());
  sort_by_component(lists, instances);
}

void InteriorPoint::Impl::select(std::span<const int> components) {
  const int all = factorization_.symbolic().components();
  for (const int c : components)
    if (c < 0 || c >= all)
      throw std::invalid_argument("select: there is no component " + std::to_string(c) + ", but 0 to " + std::to_string(all - 1));
  if (const int twice = repeated(components, some_); twice >= 0)
    throw std::invalid_argument("select: component " + std::to_string(twice) + " is named twice");
  selected_.assign(components.begin(), components.end());
}

/// Lists of what runs. Where nothing does nobody asks for them, and the next solve mostly runs what this one did.
void InteriorPoint::Impl::set_running() {
  if (running_.empty() || (!lists_changed_ && std::ranges::equal(running_, listed_))) return;
  lists_changed_ = false;
  listed_.assign(running_.begin(), running_.end());
  const auto fill = [&](Lists& lists) {
    ++lists.version;
    lists.running.clear();
    for (const int c : running_)
      for (int k = lists.begin[c]; k < lists.begin[c + 1]; ++k) lists.running.push_back(lists.all[k]);
  };
  running_rows_.clear();
  for (const int c : running_)
    for (const RowRange& rows : rows_of(c)) join(running_rows_, 0, rows);
  for (auto& lists : term_lists_) fill(lists);
  for (auto& lists : port_lists_) fill(lists);
}

void InteriorPoint::Impl::begin(std::span<const double> x, double force_factor, std::span<const double> noise) {
  check_point(x.size());
  if (!noise.empty() && noise.size() != reports_.size())
    throw std::invalid_argument("noise of " + std::to_string(noise.size()) + " numbers, the graph has " +
                                std::to_string(reports_.size()) + " components");
  std::copy(x.begin(), x.end(), x_.begin());
  start_ = x;
  noise_ = noise;
  running_.assign(selected_.begin(), selected_.end());
  set_running();
  default_scales_ = std::ranges::any_of(running_, [&](int c) { return default_rows_[c] > 0; });
  reach_known_ = false;
  for (const int c : running_) {
    expected_iterations_[c] = reports_[c].iterations;
    at_start_[c] = static_cast<char>(reports_[c].iterations == 0 ? 2 : std::max(0, at_start_[c] - 1));
    reports_[c] = {};
    course_[c] = {};
    alpha_[c] = 1;
    scale_[c] = 0;
    degree_[c] = 0;
  }
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b) {
    ports[b]->remember(running(port_lists_[b]), force_factor);
    for (const int i : port_lists_[b].running) {
      const int c = port_lists_[b].component[i];
      degree_[c] += ports[b]->degree(i);
      scale_[c] = std::max(scale_[c], ports[b]->scale(i));
    }
  }
}

/// Of each row, the largest entry beside its own node. A residual that is all rounding of multipliers over a diagonal of
/// nearly nothing never falls below a tolerance.
void InteriorPoint::Impl::find_reach() {
  const Symbolic& s = factorization_.symbolic();
  const double* values = factorization_.values().data();
  for (const int c : running_)
    for (const RowRange& rows : rows_of(c)) std::fill(reach_.begin() + rows.begin, reach_.begin() + rows.end, 0.0);
  for (const int c : running_) {
    if (default_rows_[c] == 0) continue;
    for (int k = s.component_begin(c); k < s.component_begin(c + 1); ++k) {
      const Symbolic::Pivot& p = s.pivot(k);
      const auto later = s.coupled(k);
      const std::int64_t* offset = s.block_offsets(p);
      const auto take = [&](std::int64_t panel, int row, int count, int columns) {
        for (int i = 0; i < count * columns; ++i)
          keep_largest(reach_[row + i % count], std::abs(values[panel + i * static_cast<std::int64_t>(p.stride)]));
      };
      for (std::size_t e = 0; e < later.size(); ++e) {
        if (s.is_fill(k, static_cast<int>(e))) continue;
        const int other = s.dimension(later[e]);
        take(p.upper + offset[e] * p.stride, p.row, p.dimension, other);
        take(p.lower + offset[e] * p.stride, s.row(later[e]), other, p.dimension);
      }
    }
  }
  reach_known_ = true;
}

/// Of the rows that the caller gave none: what a residual is depends on where x is. A diagonal that is no number leaves no
/// scale, and no solution.
void InteriorPoint::Impl::set_default_scales() {
  if (!reach_known_) find_reach();
  const Symbolic& s = factorization_.symbolic();
  for (const int c : running_) {
    if (default_rows_[c] == 0) continue;
    for (int k = s.component_begin(c); k < s.component_begin(c + 1); ++k)
      for (int i = 0; i < s.dimension(k); ++i) {
        const int row = s.row(k) + i;
        if (!default_row_[row]) continue;
        const double diagonal = factorization_.values()[s.pivot(k).diagonal + i * (s.dimension(k) + 1) * s.pivot(k).stride];
        row_scale_[row] = !std::isfinite(diagonal) ? std::numeric_limits<double>::quiet_NaN()
                          : diagonal > 0           ? 1 / std::max(diagonal, least_diagonal * reach_[row])
                                                   : 1.0;
      }
  }
}

void InteriorPoint::Impl::set_row_scale(NodeId node, std::span<const double> scale) {
  problem_.check_row_scale(node, scale);
  const int row = problem_.graph().row(node);
  for (std::size_t i = 0; i < scale.size(); ++i) {
    if (default_row_[row + i]) {
      --default_rows_[factorization_.symbolic().component(node)];
      if (--defaults_ == 0) std::vector<double>().swap(reach_);
    }
    default_row_[row + i] = false;
    row_scale_[row + i] = scale[i];
  }
}

Factorization::Outcome InteriorPoint::Impl::factorize_terms(std::span<const double> x) {
  check_point(x.size());
  std::copy(x.begin(), x.end(), x_.begin());
  run_all();
  factorization_.set_zero();
  const auto terms = problem_.terms();
  double* values = factorization_.values().data();
  for (std::size_t b = 0; b < terms.size(); ++b) terms[b]->evaluate(running(term_lists_[b]), x_, residual_, values);
  factorization_.set_saddle_shift(0);  // dependent rows are to be seen
  factorization_.keep_matrix(true);    // and named by diagnose()
  const Factorization::Outcome outcome = factorization_.factorize();
  factorization_.set_saddle_shift(saddle_shift, settings_.leave_out);
  return outcome;
}

}  // namespace graphsolve

#include "simd/bundles.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

namespace graphsolve::simd {

namespace {

/// Filled level by level from the roots, because the lanes of a level follow those of the one above.
class Bundler {
 public:
  Bundler(const Symbolic& symbolic, int begin, int end, std::span<const int> shape)
      : s_(symbolic), begin_(begin), shape_(shape), level_(end - begin, 0), place_(end - begin) {
    const int n = end - begin;
    int levels = 0;
    for (int k = 0; k < n; ++k) {
      levels = std::max(levels, level_[k] + 1);
      if (const int p = parent(k); p >= 0) level_[p] = std::max(level_[p], level_[k] + 1);
    }
    by_level_.resize(levels);
    for (int k = 0; k < n; ++k) by_level_[level_[k]].push_back(k);
  }

  std::vector<Bundle> run() {
    std::vector<std::vector<Bundle>> of_level(by_level_.size());
    std::vector<int> place(level_.size(), -1);  // of a bundle by number, which count from the roots on
    for (std::size_t i = by_level_.size(); i-- > 0;) {
      fill_level(by_level_[i]);
      of_level[i].swap(level_bundles_);
    }
    std::vector<Bundle> all;
    all.reserve(placed_);
    for (const auto& some : of_level)
      for (const Bundle& bundle : some) {
        place[place_[bundle.first_pivot()].bundle] = static_cast<int>(all.size());
        all.push_back(bundle);
      }
    std::vector<Bundle> result;
    result.reserve(all.size());
    for (const int i : subtree_after_subtree(all, place)) result.push_back(all[i]);
    return result;
  }

 private:
  struct Place {
    int bundle = -1, lane = 0, lanes = 1;
  };
  struct Item {
    int shape, bundle, ordinal, lane, pivot;  ///< bundle, lane: of the parent; ordinal: among siblings of one shape
    [[nodiscard]] bool beside(const Item& other) const {
      return shape == other.shape && bundle == other.bundle && ordinal == other.ordinal;
    }
  };

  [[nodiscard]] int parent(int k) const {
    const int p = s_.parent(begin_ + k);
    return p < 0 ? -1 : p - begin_;
  }

  void fill_level(std::vector<int>& pivots) {
    const auto of = [&](int k) { return std::tuple(shape_[begin_ + k], parent(k), k); };
    std::sort(pivots.begin(), pivots.end(), [&](int a, int b) { return of(a) < of(b); });
    items_.clear();
    for (std::size_t i = 0; i < pivots.size(); ++i) {
      const int k = pivots[i], p = parent(k);
      const Place above = p < 0 ? Place{} : place_[p];
      const bool sibling = i > 0 && p >= 0 && parent(pivots[i - 1]) == p && items_.back().shape == shape_[begin_ + k];
      items_.push_back({shape_[begin_ + k], above.bundle, sibling ? items_.back().ordinal + 1 : 0, above.lane, k});
    }
    const auto key = [](const Item& i) { return std::tie(i.shape, i.bundle, i.ordinal, i.lane, i.pivot); };
    std::sort(items_.begin(), items_.end(), [&](const Item& a, const Item& b) { return key(a) < key(b); });
    for (std::size_t i = 0, end; i < items_.size(); i = end) {
      for (end = i + 1; end < items_.size() && items_[end].shape == items_[i].shape;) ++end;
      fill_shape(std::span(items_).subspan(i, end - i));
    }
  }

  /// Pivots of one level and one shape.
  void fill_shape(std::span<const Item> items) {
    const int most = lanes_for(static_cast<int>(items.size()));
    const std::size_t first = level_bundles_.size();
    rest_.clear();
    for (std::size_t i = 0, end; i < items.size(); i = end) {
      for (end = i + 1; end < items.size() && items[end].beside(items[i]);) ++end;
      take_class(items.subspan(i, end - i), most);
    }
    fill_up(std::span(level_bundles_).subspan(first), placed_ - static_cast<int>(level_bundles_.size() - first));
    take_rest();
  }

  /// Children of one bundle, at most one per lane: side by side below their parents, if that leaves few of the `most`
  /// lanes empty that a bundle at this level can have.
  void take_class(std::span<const Item> items, int most) {
    const Place above = items[0].bundle < 0 ? Place{} : place_[parent(items[0].pivot)];
    if (items[0].bundle < 0 || most < 4 || above.lanes != most || static_cast<int>(items.size()) < most - 1) {
      rest_.insert(rest_.end(), items.begin(), items.end());
      return;
    }
    Bundle bundle{.lanes = above.lanes, .used = 0, .pivot = {}};
    for (const Item& i : items) put(bundle, placed_, i.lane, i.pivot);
    add(bundle);
  }

  /// What is left over goes into empty lanes if all of it finds room there: a bundle less is worth more than lanes that
  /// follow their parents.
  void fill_up(std::span<Bundle> some, int number) {
    std::size_t room = 0;
    for (const Bundle& b : some) room += b.lanes - std::popcount(b.used);
    if (rest_.size() > room) return;
    for (Bundle& b : some) {
      for (int l = 0; l < b.lanes && !rest_.empty(); ++l) {
        if (b.used >> l & 1u) continue;
        put(b, number, l, rest_.back().pivot);
        rest_.pop_back();
      }
      repeat_in_empty_lanes(b);
      ++number;
    }
  }

  void take_rest() {
    for (std::size_t i = 0; i < rest_.size(); i += lanes) {
      const auto some = std::span(rest_).subspan(i, std::min<std::size_t>(lanes, rest_.size() - i));
      Bundle bundle{.lanes = lanes_for(static_cast<int>(some.size())), .used = 0, .pivot = {}};
      for (std::size_t l = 0; l < some.size(); ++l) put(bundle, placed_, static_cast<int>(l), some[l].pivot);
      add(bundle);
    }
    rest_.clear();
  }

  /// The order of `all`, which is level by level: what comes below a bundle is eliminated right before it, so that what it
  /// changes is still in the cache. Subtrees that are small stay level by level, because neighbours on a level do not
  /// wait for each other. place: in `all`, by number.
  std::vector<int> subtree_after_subtree(std::span<const Bundle> all, std::span<const int> place) const {
    constexpr std::int64_t small = 8192;  // doubles: a fraction of any L2 cache
    const auto below = bundles_below(all, place);
    struct Visit {
      int bundle;
      std::size_t next, begin;
      std::int64_t size;
    };
    struct Range {
      std::size_t begin, end;
    };
    std::vector<Visit> path;
    std::vector<Range> ranges;  // largest small subtrees
    std::vector<int> order;
    std::vector<char> seen(all.size(), 0);
    const auto visit = [&](int i) {
      seen[i] = 1;
      path.push_back({i, 0, order.size(), s_.pivot(begin_ + all[i].pivot[0]).scalars() * all[i].lanes});
    };
    visit(static_cast<int>(all.size()) - 1);  // the root
    while (!path.empty()) {
      Visit& top = path.back();
      const auto& children = below[top.bundle];
      while (top.next < children.size() && seen[children[top.next]]) ++top.next;
      if (top.next < children.size()) {
        visit(children[top.next]);
        continue;
      }
      order.push_back(top.bundle);
      if (top.size <= small) {
        while (!ranges.empty() && ranges.back().begin >= top.begin) ranges.pop_back();
        ranges.push_back({top.begin, order.size()});
      }
      const std::int64_t size = top.size;
      path.pop_back();
      if (!path.empty()) path.back().size += size;
    }
    for (const Range& r : ranges) std::sort(order.begin() + r.begin, order.begin() + r.end);
    return order;
  }

  /// Of each of `all` those with children of its pivots, ascending.
  std::vector<std::vector<int>> bundles_below(std::span<const Bundle> all, std::span<const int> place) const {
    std::vector<std::vector<int>> below(all.size());
    for (int i = 0; i < static_cast<int>(all.size()); ++i)
      for (int l = 0; l < lanes; ++l) {
        const int p = parent(all[i].pivot[l]);
        if (!(all[i].used >> l & 1u) || p < 0) continue;
        auto& some = below[place[place_[p].bundle]];
        if (some.empty() || some.back() != i) some.push_back(i);
      }
    return below;
  }

  void put(Bundle& bundle, int number, int lane, int pivot) {
    bundle.pivot[lane] = pivot;
    bundle.used |= 1u << lane;
    place_[pivot] = {number, lane, bundle.lanes};
  }
  static void repeat_in_empty_lanes(Bundle& bundle) {
    const int first = bundle.first_pivot();
    for (int l = 0; l < lanes; ++l)
      if (!(bundle.used >> l & 1u)) bundle.pivot[l] = first;
  }
  void add(Bundle& bundle) {
    repeat_in_empty_lanes(bundle);
    level_bundles_.push_back(bundle);
    ++placed_;
  }

  const Symbolic& s_;
  int begin_;
  std::span<const int> shape_;
  std::vector<int> level_;  ///< steps from the leaves
  std::vector<Place> place_;
  std::vector<std::vector<int>> by_level_;
  std::vector<Item> items_, rest_;
  std::vector<Bundle> level_bundles_;
  int placed_ = 0;
};

}  // namespace

std::vector<Bundle> bundles(const Symbolic& symbolic, int begin, int end, std::span<const int> shape) {
  return Bundler(symbolic, begin, end, shape).run();
}

}  // namespace graphsolve::simd

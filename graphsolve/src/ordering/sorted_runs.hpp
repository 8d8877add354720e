#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace graphsolve {

/// A set of numbers in one list of sorted runs, the first one short or each at least twice as long as the next. So a
/// large set takes in numbers one by one at O(log) moves for each, wherever they belong, and finds one in O(log^2).
class SortedRuns {
 public:
  /// Run by run.
  [[nodiscard]] const std::vector<int>& entries() const { return list_; }
  [[nodiscard]] std::size_t size() const { return list_.size(); }

  [[nodiscard]] bool contains(int number) const {
    auto end = list_.end();
    for (std::size_t r = begins_.size(); r-- > 0;) {
      const auto begin = list_.begin() + begins_[r];
      if (std::binary_search(begin, end, number)) return true;
      end = begin;
    }
    return std::binary_search(list_.begin(), end, number);
  }

  /// Takes in numbers in ascending order, none of which is there. Returns how many entries were written.
  std::size_t add(std::span<const int> numbers, std::vector<int>& scratch) {
    std::size_t written = numbers.size();
    begins_.push_back(static_cast<int>(list_.size()));
    list_.insert(list_.end(), numbers.begin(), numbers.end());
    while (!begins_.empty()) {
      const auto begin = begins_.back();
      const auto before = begins_.size() > 1 ? begins_[begins_.size() - 2] : 0;
      const auto length = static_cast<int>(list_.size()) - begin;
      if (begin - before > short_run && begin - before >= 2 * length) break;
      written += join_last(before, begin, scratch);
    }
    return written;
  }

  template <class F>
  void erase_if(F&& gone) {
    std::erase_if(list_, gone);
    if (!begins_.empty()) std::sort(list_.begin(), list_.end());
    begins_.clear();
  }

  /// Forgets all, and gives the memory back.
  void clear() {
    std::vector<int>().swap(list_);
    std::vector<int>().swap(begins_);
  }

 private:
  static constexpr int short_run = 64;  ///< merged with whatever comes: one run is found in faster

  /// Merges the last run into the one before it, from the back: what is less than all of the last stays where it is.
  std::size_t join_last(int before, int begin, std::vector<int>& scratch) {
    scratch.assign(list_.begin() + begin, list_.end());
    const auto first = list_.begin() + before;
    auto left = list_.begin() + begin, out = list_.end();
    while (!scratch.empty()) {
      if (left != first && left[-1] > scratch.back()) {
        *--out = *--left;
      } else {
        *--out = scratch.back();
        scratch.pop_back();
      }
    }
    begins_.pop_back();
    return static_cast<std::size_t>(list_.end() - out);
  }

  std::vector<int> list_;
  std::vector<int> begins_;  ///< of the runs after the first
};

}  // namespace graphsolve

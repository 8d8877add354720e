#pragma once

#include <algorithm>

namespace physics {

/// Numbering of equal copies side by side: packs of up to `width` copies, equal items of a pack next to each other, so
/// that vectors over copies read and write neighbours. With one copy the numbering is that of its items.
class Interleaving {
 public:
  static constexpr int width = 8;

  explicit Interleaving(int copies) : copies_(copies) {}
  [[nodiscard]] int copies() const { return copies_; }
  /// items: how many a copy has.
  [[nodiscard]] int index(int copy, int item, int items) const {
    return first_of_pack(copy) * items + item * pack(copy) + copy % width;
  }
  [[nodiscard]] int item(int index, int items) const {
    const int first = index / (items * width) * width;
    return (index - first * items) / pack(first);
  }
  /// f(copy, item) in the order of the numbering.
  template <class F>
  void each(int items, F&& f) const {
    for (int first = 0; first < copies_; first += width)
      for (int item = 0; item < items; ++item)
        for (int copy = first; copy < first + pack(first); ++copy) f(copy, item);
  }

 private:
  [[nodiscard]] static int first_of_pack(int copy) { return copy - copy % width; }
  [[nodiscard]] int pack(int copy) const { return std::min(width, copies_ - first_of_pack(copy)); }
  int copies_;
};

}  // namespace physics

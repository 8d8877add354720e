#pragma once

namespace physics {

/// Numbering of equal copies side by side: equal items next to each other, so that vectors over copies read and write
/// neighbours. With one copy the numbering is that of its items.
class Interleaving {
 public:
  static constexpr int width = 8;  ///< so many copies fill the vectors

  explicit Interleaving(int copies) : copies_(copies) {}
  [[nodiscard]] int copies() const { return copies_; }
  [[nodiscard]] int index(int copy, int item) const { return item * copies_ + copy; }
  /// f(copy, item) in the order of the numbering.
  template <class F>
  void each(int items, F&& f) const {
    for (int item = 0; item < items; ++item)
      for (int copy = 0; copy < copies_; ++copy) f(copy, item);
  }

 private:
  int copies_;
};

}  // namespace physics

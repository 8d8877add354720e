#pragma once

// For the kernels of graphsolve and physics; outside the version promise (docs/architecture.md).

#include <array>
#include <cstdint>

#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/symbolic.hpp"

namespace graphsolve::simd {

/// One block of the matrix per lane, all of one form, as kernels on packs write to them (put_blocks in pack_memory-inl.hpp).
class LaneBlocks {
 public:
  void set(int lane, const BlockHandle& block) {
    place_[lane] = block.offset;
    stride_[lane] = block.stride;
    present_ |= 1u << lane;
  }
  /// Once all are set: finds out how many lie side by side.
  void finish() {
    dense_ = true;
    for (int l = 0; l < lanes; ++l) dense_ &= !(present_ >> l & 1u) || stride_[l] == 1;
    for (together_ = lanes; together_ > 1 && !side_by_side(together_);) together_ /= 2;
  }
  [[nodiscard]] unsigned present() const { return present_; }
  /// Of entry (0, 0) of that lane's block, in the values.
  [[nodiscard]] std::int64_t place(int lane) const { return place_[lane]; }
  /// From an entry to the next.
  [[nodiscard]] int stride(int lane) const { return stride_[lane]; }
  /// 8, 4, 2 or 1: so many lanes, from each multiple on, have their entries side by side, and `stride` is theirs in common.
  [[nodiscard]] int together() const { return together_; }
  /// Is no block interleaved with others?
  [[nodiscard]] bool dense() const { return dense_; }
  /// Where the entries of so many lanes from a multiple on begin; -1 when none of these has a block.
  [[nodiscard]] std::int64_t run(int first, int& stride) const {
    for (int l = first; l < first + together_; ++l)
      if (present_ >> l & 1u) {
        stride = stride_[l];
        return place_[l] - (l - first);
      }
    return -1;
  }

 private:
  [[nodiscard]] bool side_by_side(int width) const {
    for (int first = 0; first < lanes; first += width) {
      std::int64_t begin = -1;
      int stride = 0;
      for (int l = first; l < first + width; ++l) {
        if (!(present_ >> l & 1u)) continue;
        if (begin < 0) begin = place_[l] - (l - first), stride = stride_[l];
        if (place_[l] - (l - first) != begin || stride_[l] != stride) return false;
        if (begin < 0 || begin % stride + width > stride) return false;  // a register would reach beyond the pack
      }
    }
    return true;
  }

  std::array<std::int64_t, lanes> place_{};
  std::array<int, lanes> stride_{};
  unsigned present_ = 0;
  int together_ = 1;
  bool dense_ = false;
};

}  // namespace graphsolve::simd

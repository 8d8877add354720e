#pragma once

// For members of other headers; outside the version promise (docs/architecture.md).

#include <cstddef>
#include <new>
#include <vector>

namespace graphsolve {

/// Begins at a multiple of 64 bytes, so that eight doubles lie in one line of the cache.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) noexcept {}  // NOLINT: allocators convert
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), alignment)); }
  void deallocate(T* p, std::size_t) noexcept { ::operator delete(p, alignment); }
  friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};
using AlignedVector = std::vector<double, AlignedAllocator<double>>;

}  // namespace graphsolve

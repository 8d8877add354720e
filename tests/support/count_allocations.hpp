#pragma once

// Counts what is taken from the heap. To be included by one source file of a program: it replaces the program's malloc,
// because that is where both operator new and Eigen end. Memory still comes from the C library.

#include <malloc.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

// Sanitizers bring their own malloc, and must keep it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define TESTS_COUNT_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TESTS_COUNT_ALLOCATIONS 0
#endif
#endif
#ifndef TESTS_COUNT_ALLOCATIONS
#define TESTS_COUNT_ALLOCATIONS 1
#endif

namespace allocation {

inline constexpr bool counted = TESTS_COUNT_ALLOCATIONS != 0;
inline std::atomic<bool> armed{false};
inline std::atomic<long> count{0};
inline std::atomic<std::int64_t> bytes{0};

inline void note(std::size_t size) {
  if (!armed.load(std::memory_order_relaxed)) return;
  count.fetch_add(1, std::memory_order_relaxed);
  bytes.fetch_add(static_cast<std::int64_t>(size), std::memory_order_relaxed);
}

/// From here to the end of its life all allocations of the program are counted; tests run one after another.
class Counting {
 public:
  Counting() {
    count = 0;
    bytes = 0;
    armed = true;
  }
  ~Counting() { armed = false; }
  Counting(const Counting&) = delete;
  Counting& operator=(const Counting&) = delete;
  [[nodiscard]] static long so_far() { return count; }
  [[nodiscard]] static std::int64_t bytes_so_far() { return bytes; }  ///< asked for, freed or not
};

/// Bytes of the heap that are in use, with what the allocator adds to each piece.
inline std::int64_t bytes_in_use() {
#if TESTS_COUNT_ALLOCATIONS
  const struct mallinfo2 info = mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
#else
  return 0;
#endif
}

}  // namespace allocation

#if TESTS_COUNT_ALLOCATIONS
// free() need not change.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  allocation::note(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  allocation::note(count * size);
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  allocation::note(size);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  allocation::note(size);
  return __libc_memalign(alignment, size);
}
}
#endif

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
inline std::atomic<std::int64_t> in_use{0};

inline void note([[maybe_unused]] const void* memory, std::size_t size) {
#if TESTS_COUNT_ALLOCATIONS
  if (memory) in_use.fetch_add(static_cast<std::int64_t>(malloc_usable_size(const_cast<void*>(memory))) + 8, std::memory_order_relaxed);
#endif
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

inline void note_freed([[maybe_unused]] void* memory) {
#if TESTS_COUNT_ALLOCATIONS
  if (memory) in_use.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(memory)) + 8, std::memory_order_relaxed);
#endif
}

/// Bytes of the heap that are in use, with what the allocator adds to each piece.
inline std::int64_t bytes_in_use() { return in_use; }

#if TESTS_COUNT_ALLOCATIONS
inline const int no_pages = mallopt(M_MMAP_THRESHOLD, 1 << 25);  ///< large pieces would be rounded up to pages
#endif

}  // namespace allocation

#if TESTS_COUNT_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);

void* malloc(std::size_t size) {
  void* memory = __libc_malloc(size);
  allocation::note(memory, size);
  return memory;
}
void* calloc(std::size_t count, std::size_t size) {
  void* memory = __libc_calloc(count, size);
  allocation::note(memory, count * size);
  return memory;
}
void* realloc(void* memory, std::size_t size) {
  allocation::note_freed(memory);
  memory = __libc_realloc(memory, size);
  allocation::note(memory, size);
  return memory;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  void* memory = __libc_memalign(alignment, size);
  allocation::note(memory, size);
  return memory;
}
void free(void* memory) {
  allocation::note_freed(memory);
  __libc_free(memory);
}
}
#endif

#include <algorithm>
#include <stdexcept>

#include "factorization/given.hpp"
#include "factorization/impl.hpp"

/// Zeros before new numbers are added.
namespace graphsolve {

void Factorization::Impl::set_zero() {
  complete_ = false;  // refactorize() has nothing to build on
  for (const int c : taking_part_.everybody()) standing_.lose_factor(c);
  for (const auto& group : symbolic_->program().groups())
    std::fill(values_.begin() + group.begin, values_.begin() + given_end(group, symmetric()), 0.0);
}

void Factorization::Impl::set_zero(std::span<const int> components) {
  complete_ = false;
  taking_part_.set(components);
  for (const int c : components) standing_.lose_factor(c);
  const auto zero = [&](std::int64_t begin, std::int64_t end) {
    std::fill(values_.begin() + begin, values_.begin() + end, 0.0);
  };
  taking_part_.each_extent(
      symmetric(),
      [&](std::size_t group, std::int64_t begin, std::int64_t end) {
        if (zeroed_begin_.empty()) return zero(begin, end);
        for (int i = zeroed_begin_[group]; i < zeroed_begin_[group + 1]; ++i) zero(zeroed_[i].begin, zeroed_[i].end);
      },
      [&](int k) { each_given(symbolic_->pivot(k), symmetric(), [&](std::int64_t at) { values_[at] = 0; }); });
}

/// What is left between the blocks. Of interleaved ones all lanes have to be named: the last lane's has its end where
/// that of all of them is.
void Factorization::Impl::leave_unzeroed(std::span<const BlockHandle> blocks) {
  std::vector<BlockHandle> sorted(blocks.begin(), blocks.end());
  std::ranges::sort(sorted, {}, &BlockHandle::offset);
  const auto scalars = [](const BlockHandle& b) { return static_cast<std::int64_t>(b.rows) * b.columns * b.stride; };
  std::vector<Range> left_out;
  for (std::size_t i = 0; i < sorted.size();) {
    const BlockHandle& first = sorted[i];
    std::size_t lanes = 1;
    while (i + lanes < sorted.size() && sorted[i + lanes].offset < first.offset + first.stride) ++lanes;
    for (std::size_t l = 1; l < lanes; ++l)
      if (sorted[i + l].offset == sorted[i + l - 1].offset)
        throw std::logic_error("a block of the matrix is claimed by two terms");
    if (lanes == static_cast<std::size_t>(first.stride)) left_out.push_back({first.offset, first.offset + scalars(first)});
    i += lanes;
  }
  const auto groups = symbolic_->program().groups();
  zeroed_.clear();
  zeroed_begin_.assign(1, 0);
  std::size_t next = 0;
  for (const auto& group : groups) {
    std::int64_t begin = group.begin;
    const std::int64_t end = given_end(group, symmetric());
    for (; next < left_out.size() && left_out[next].begin < group.end; ++next) {
      if (left_out[next].begin >= end) continue;
      if (left_out[next].begin > begin) zeroed_.push_back({begin, left_out[next].begin});
      begin = left_out[next].end;
    }
    if (begin < end) zeroed_.push_back({begin, end});
    zeroed_begin_.push_back(static_cast<int>(zeroed_.size()));
  }
}

}  // namespace graphsolve

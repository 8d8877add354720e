#include "factorization/participants.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace graphsolve {

Participants::Participants(const Symbolic& symbolic)
    : symbolic_(symbolic), everybody_(symbolic.components()), lanes_(symbolic.program().groups().size(), 0),
      named_(symbolic.components(), false) {
  std::iota(everybody_.begin(), everybody_.end(), 0);
  components_.reserve(everybody_.size());
}

void Participants::check(std::span<const int> components) {
  for (const int c : components)
    if (c < 0 || c >= symbolic_.components())
      throw std::invalid_argument("there is no component " + std::to_string(c) + ", but 0 to " +
                                  std::to_string(symbolic_.components() - 1));
  const auto twice = std::ranges::find_if(components, [&](int c) { return std::exchange(named_[c], true); });
  for (const int c : components) named_[c] = false;
  if (twice != components.end())
    throw std::invalid_argument("component " + std::to_string(*twice) + " is named twice");
}

void Participants::set(std::span<const int> components) {
  const simd::Program& program = symbolic_.program();
  components_.assign(components.begin(), components.end());
  std::fill(lanes_.begin(), lanes_.end(), std::uint8_t{0});
  for (const int c : components) {
    std::uint8_t& lanes = lanes_[program.group_of(c)];
    lanes = static_cast<std::uint8_t>(lanes | program.copy_bit(c));
  }
}

void Participants::leave_out(int component) {
  const simd::Program& program = symbolic_.program();
  std::uint8_t& lanes = lanes_[program.group_of(component)];
  lanes = static_cast<std::uint8_t>(lanes & ~program.copy_bit(component));
}

bool Participants::include(int pivot) const {
  const simd::Program& program = symbolic_.program();
  const int c = symbolic_.component(symbolic_.node(pivot));
  return (lanes_[program.group_of(c)] & program.copy_bit(c)) != 0;
}

}  // namespace graphsolve

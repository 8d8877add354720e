#include "rollout_copy.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <span>

#include "physics/simulator.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

void set_values(physics::Mechanism& mechanism, std::span<const physics::Variation> variations,
                std::span<const double> values) {
  for (std::size_t i = 0; i < variations.size(); ++i) physics::set_value(mechanism, variations[i].key, values[i]);
}

/// Does the scene stay one with these values?
bool will_do(physics::Mechanism mechanism, std::span<const physics::Variation> variations, std::span<const double> values) {
  try {
    set_values(mechanism, variations, values);
    (void)physics::Simulator(mechanism);
    return true;
  } catch (const DescriptionError&) {
    return false;
  }
}

/// "friction = 0.5, mass = 2"
std::string listed(std::span<const physics::Variation> variations, std::span<const double> values) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < variations.size(); ++i) parts.push_back(fmt::format("{} = {}", variations[i].key, values[i]));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

physics::Mechanism make_copy(const RolloutRequest& request, long long copy) {
  physics::Mechanism mechanism = request.mechanism;
  set_values(mechanism, request.variations, physics::draw(request.variations, request.seed, copy));
  return mechanism;
}

DescriptionError about_copy(const RolloutRequest& request, const physics::CopyError& error) {
  const std::vector<double> values = physics::draw(request.variations, request.seed, error.copy());
  const std::span<const physics::Variation> variations(request.variations);
  const std::span<const double> drawn(values);
  std::size_t set = 0;  // so many, in their order, until it is wrong
  while (set <= variations.size() && will_do(request.mechanism, variations.first(set), drawn.first(set))) ++set;
  const std::string all = variations.empty() ? "" : fmt::format(" ({})", listed(variations, drawn));
  if (set == 0 || set > variations.size()) return DescriptionError(fmt::format("copy {}{}: {}", error.copy(), all, error.reason()));
  const std::string others = set == 1 ? "" : fmt::format(" beside {}", listed(variations.first(set - 1), drawn));
  return DescriptionError(fmt::format("copy {}: vary '{}': the value {} will not do{}: {}", error.copy(),
                                      variations[set - 1].key, drawn[set - 1], others, error.reason()));
}

}  // namespace cli

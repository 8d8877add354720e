#include "terms/motor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {

double motor_target(const Motor& motor, double time) {
  if (const auto* constant = std::get_if<double>(&motor.target)) return *constant;
  if (const auto* sine = std::get_if<SineTarget>(&motor.target))
    return sine->offset + sine->amplitude * std::sin(2 * std::numbers::pi * sine->frequency * time + sine->phase);
  const auto& table = std::get<TableTarget>(motor.target);
  if (table.empty()) return 0;
  const auto after = std::upper_bound(table.begin(), table.end(), time,
                                      [](double t, const std::pair<double, double>& entry) { return t < entry.first; });
  if (after == table.begin()) return after->second;
  const auto before = after - 1;
  if (after == table.end()) return before->second;
  return before->second + (time - before->first) / (after->first - before->first) * (after->second - before->second);
}

}  // namespace physics

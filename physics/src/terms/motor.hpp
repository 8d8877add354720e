#pragma once

#include "physics/mechanism.hpp"

namespace physics {

/// Target of a motor at a time [rad or m].
double motor_target(const Motor& motor, double time);

}  // namespace physics

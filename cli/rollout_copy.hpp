#pragma once

#include "rollout_file.hpp"

/// The copies of a rollout, and what is said of one that is wrong.
namespace cli {

/// The scene with the values of this copy.
physics::Mechanism make_copy(const RolloutRequest& request, long long copy);

/// The same error with the key and the value that make the copy wrong; where it is not one key, with all of them.
physics::DescriptionError about_copy(const RolloutRequest& request, const physics::CopyError& error);

}  // namespace cli

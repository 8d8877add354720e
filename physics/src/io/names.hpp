#pragma once

#include "io/values.hpp"
#include "physics/mechanism.hpp"

/// The words of the format, for both directions.
namespace physics::io {

inline constexpr std::string_view format_name = "graphsolve-scene";
inline constexpr int format_version = 1;

inline constexpr Choice<Start> starts[]{{"standard", Start::standard}, {"half_kick", Start::half_kick}};
inline constexpr Choice<JointType> joint_types[]{{"fixed", JointType::fixed},
                                                 {"revolute", JointType::revolute},
                                                 {"prismatic", JointType::prismatic},
                                                 {"spherical", JointType::spherical}};
inline constexpr Choice<FrictionModel> friction_models[]{{"pyramid", FrictionModel::pyramid},
                                                         {"aligned", FrictionModel::aligned}};
inline constexpr Choice<Shape::Type> shape_types[]{{"sphere", Shape::Type::sphere},
                                                   {"box", Shape::Type::box},
                                                   {"cylinder", Shape::Type::cylinder},
                                                   {"capsule", Shape::Type::capsule},
                                                   {"mesh", Shape::Type::mesh}};

template <class Enum, std::size_t n>
const char* word(Enum value, const Choice<Enum> (&choices)[n]) {
  for (const auto& choice : choices)
    if (choice.value == value) return choice.name;
  return "";
}

inline bool has_axis(JointType type) { return type == JointType::revolute || type == JointType::prismatic; }

}  // namespace physics::io

#pragma once

#include <span>
#include <string_view>
#include <vector>

/// Eight equal problems at once. Code on packs (pack-inl.hpp) is compiled for several instruction sets and chosen
/// when the program runs; nothing of it is in exported compile flags.
namespace graphsolve::simd {

inline constexpr int lanes = 8;  ///< on every machine, so that data and results do not depend on its registers

enum class InstructionSet {
  plain,   ///< what every machine of this kind has (SSE2 on x86-64)
  avx2,
  avx512,
};
std::string_view name(InstructionSet set);

/// What this machine can run, plain first.
std::vector<InstructionSet> instruction_sets();

/// The one in use: the best that the machine can run, but none beyond the one that the environment variable
/// GRAPHSOLVE_SIMD names, unless use_instruction_set was called. Whatever computes asks first: so where the variable holds
/// another word (nothing counts as unset), this and constructors of Factorization throw std::invalid_argument.
InstructionSet instruction_set();

/// For the whole process, for tests and comparison; not while another thread computes. Throws
/// std::invalid_argument when this machine cannot run it.
void use_instruction_set(InstructionSet set);

}  // namespace graphsolve::simd

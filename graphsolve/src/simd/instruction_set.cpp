#include <cstdlib>
#include <stdexcept>
#include <string>

#include "graphsolve/simd/targets.hpp"
// Highway comes after the choice of targets.
#include <hwy/highway.h>

#include "graphsolve/simd/lanes.hpp"

namespace graphsolve::simd {

namespace {

constexpr InstructionSet all[] = {InstructionSet::plain, InstructionSet::avx2, InstructionSet::avx512};

std::int64_t targets(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512: return HWY_AVX3;
    case InstructionSet::avx2: return HWY_AVX2;
    case InstructionSet::plain: break;
  }
  return HWY_STATIC_TARGET;
}

/// What the processor can do, whatever was chosen before.
std::int64_t machine() {
  static const std::int64_t found = hwy::SupportedTargets();
  return found;
}

bool runs(InstructionSet set) { return set == InstructionSet::plain || (machine() & targets(set)) != 0; }

void choose(InstructionSet set) {
  (void)machine();  // asked before the answer is overruled
  hwy::SetSupportedTargetsForTest(targets(set) | HWY_STATIC_TARGET);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// The most that the environment allows.
InstructionSet allowed() {
  const char* wanted = std::getenv("GRAPHSOLVE_SIMD");
  if (!wanted || !*wanted) return InstructionSet::avx512;
  for (const InstructionSet set : all)
    if (name(set) == wanted) return set;
  throw std::invalid_argument("GRAPHSOLVE_SIMD is '" + std::string(wanted) + "'; there are: plain, avx2, avx512");
}

InstructionSet& chosen() {
  static InstructionSet set = [] {
    InstructionSet best = InstructionSet::plain;
    const InstructionSet most = allowed();
    for (const InstructionSet candidate : all)
      if (candidate <= most && runs(candidate)) best = candidate;
    choose(best);
    return best;
  }();
  return set;
}

}  // namespace

std::string_view name(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512: return "avx512";
    case InstructionSet::avx2: return "avx2";
    case InstructionSet::plain: break;
  }
  return "plain";
}

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : all)
    if (runs(set)) sets.push_back(set);
  return sets;
}

InstructionSet instruction_set() { return chosen(); }

void use_instruction_set(InstructionSet set) {
  if (!runs(set)) throw std::invalid_argument("this machine cannot run " + std::string(name(set)));
  chosen() = set;
  choose(set);
}

}  // namespace graphsolve::simd

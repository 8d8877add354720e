#include "graphsolve/status.hpp"

namespace graphsolve {

std::string_view name(Status status) {
  switch (status) {
    case Status::solved: return "solved";
    case Status::max_iterations: return "max_iterations";
    case Status::stalled: return "stalled";
    case Status::singular: return "singular";
    case Status::not_finite: return "not_finite";
    case Status::step_bound: return "step_bound";
  }
  return "unknown";
}

std::string_view explanation(Status status) {
  switch (status) {
    case Status::solved: return "";
    case Status::max_iterations:
      return "the iterations ran out before the residual reached the tolerance; allow more iterations or a larger "
             "tolerance, or make a smaller change per solve";
    case Status::stalled:
      return "no step made progress from any of the starts tried; the problem may have no solution near here: make a "
             "smaller change per solve";
    case Status::singular:
      return "a pivot block is singular; look for constraints that contradict each other, unknowns that nothing determines, and "
             "nodes of a wrong kind: diagnose() names the block";
    case Status::not_finite:
      return "a value became NaN or infinite; look for infinite or NaN input, or make a smaller change per solve";
    case Status::step_bound:
      return "the solution lies beyond the allowed step; make a smaller change per solve";
  }
  return "";
}

}  // namespace graphsolve

// How far does a box slide, for eight coefficients of friction? One scene, eight copies, stepped side by side.
//
//   build/release/bin/many_copies
//
// `run_batch` asks for each copy, steps them in the lanes of one batch per thread, and hands out what became of them,
// in order: the status of the last step tried, the steps solved, the state at the end. A copy's numbers do not depend
// on how many threads or lanes there are. Expect eight boxes that have slid v^2 / (2 mu g), to 0.1 mm.

#include <cstdio>
#include <exception>

#include "../no_arguments.hpp"
#include "physics/batch_run.hpp"
#include "physics/scenes.hpp"

int main(int count, char** words) try {
  no_arguments(count, words, "How far does a box slide? Eight coefficients of friction, copies side by side.");
  constexpr double speed = 2;
  const physics::Mechanism scene = physics::scenes::sliding_box({.speed = speed});
  const auto friction_of = [](long long copy) { return 0.1 * static_cast<double>(copy + 1); };

  physics::BatchRun run;
  run.last = 8;     // copies 0 to 7
  run.steps = 250;  // of each
  run.threads = 2;
  run.make = [&](long long copy) {  // called by both threads at once
    physics::Mechanism changed = scene;
    for (physics::Contact& contact : changed.contacts) contact.friction = friction_of(copy);
    return changed;
  };
  int failed = 0;
  run.on_result = [&](physics::CopyResult&& result) {  // one at a time, in order of the copies
    const double mu = friction_of(result.copy), way = result.bodies[0].position.x() - scene.bodies[0].position.x();
    std::printf("mu = %.1f: %s, %d steps, slid %.4f m, by the formula %.4f m\n", mu,
                graphsolve::name(result.last.status).data(), result.steps, way, speed * speed / (2 * mu * 9.81));
    if (!result.ok()) std::printf("  stuck at %s\n", result.place.c_str());
    failed += !result.ok();
    return true;  // false ends the run
  };
  physics::run_batch(scene, run);
  std::printf("%d of %lld copies failed\n", failed, run.last);
  return failed > 0 ? 1 : 0;
} catch (const std::exception& error) {  // a copy that is wrong or does not fit the scene: "copy 3: ..."
  std::fprintf(stderr, "many_copies: %s\n", error.what());
  return 2;
}

#include "support/campaign.hpp"

#include <fmt/ostream.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "graphsolve/largest.hpp"
#include "support/certificate.hpp"

namespace campaign {

using namespace physics;

namespace {

/// What rounding alone may show the certificate [m/s]: of positions over dt, and of impulses over the mass, or by an
/// arm over the inertia, that they act on. The extremes make impulses of 1e5 times a body's mass.
double inexactness(const Mechanism& mechanism, const StepRecord& before, const StepRecord& after) {
  constexpr double rounding = 64 * 2.2e-16;
  const double dt = mechanism.time_step;
  double position = 1, impulse = 0, speed = 0, lightest = 1e300, least_inertia = 1e300, arm = 0;
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    const Body& body = mechanism.bodies[i];
    position = std::max(position, before.bodies[i].position.lpNorm<Eigen::Infinity>());
    speed = std::max(speed, after.bodies[i].velocity.norm());
    lightest = std::min(lightest, body.mass);
    least_inertia = std::min(least_inertia, std::sqrt(body.mass * body.inertia.diagonal().minCoeff()));
  }
  for (const Joint& joint : mechanism.joints) arm = std::max({arm, joint.parent_point.norm(), joint.child_point.norm()});
  for (const Contact& contact : mechanism.contacts) arm = std::max(arm, contact.point.norm());
  for (const JointRecord& joint : after.joints) impulse = std::max(impulse, dt * joint.force.norm());
  for (const ContactRecord& contact : after.contacts) impulse = std::max(impulse, dt * contact.normal_force);
  return rounding * (position / dt + speed + impulse / lightest + impulse * arm / least_inertia);
}

/// Over steps in a row: what they have missed of the change of momentum, and what rounding alone may show of that.
struct Summed {
  certificate::Missed missed;
  double inexactness = 0;
};

class Runner {
 public:
  Runner(const Options& options, Report& report) : options_(options), report_(report) {}

  /// Runs one scene until it ends, fails, or `budget` steps are made. Returns the steps made, the failed one too.
  int run_scene(const Family& family, Count& count, int index, int budget) {
    Simulator simulator(scene(family, options_.seed, index), options_.settings);
    ++count.scenes;
    StepRecord before, after;
    Summed summed;
    simulator.write_record(before);
    int made = 0;
    while (made < budget) {
      const auto begin = std::chrono::steady_clock::now();
      const StepResult result = simulator.step();
      count.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      ++made;
      add(count, simulator, result);
      if (!result.ok()) {
        // The state is kept, so that the same step would fail again.
        ++count.failures;
        report_.failures.push_back({family.name, index, simulator.step_index() + 1,
                                    std::string(graphsolve::name(result.status)), result.residual});
        break;
      }
      if (!options_.certify) continue;
      simulator.write_record(after);
      certify(family, index, count, simulator.mechanism(), before, after, summed);
      std::swap(before, after);
    }
    return made;
  }

 private:
  static void add(Count& count, const Simulator& simulator, const StepResult& result) {
    ++count.steps;
    count.substepped += result.substeps > 1;
    count.restarted += result.restarts > 0;
    count.turned += result.new_force_direction;
    count.culling_repeats += result.culling_repeats;
    count.iterations += result.iterations;
    count.most_iterations = std::max(count.most_iterations, result.iterations);
    const double distance = simulator.smallest_distance();
    if (!(distance >= count.distance) && !std::isnan(count.distance)) count.distance = distance;  // NaN stays
    graphsolve::keep_largest(count.joint_error, simulator.largest_joint_error());
  }

  void certify(const Family& family, int index, Count& count, const Mechanism& mechanism, const StepRecord& before,
               const StepRecord& after, Summed& summed) {
    certificate::Certificate verdict = certificate::certify_step(mechanism, before, after, &summed.missed);
    const double of_step = inexactness(mechanism, before, after);
    summed.inexactness = verdict.flagged ? 0 : summed.inexactness + of_step;
    const double allowed = options_.settings.tolerance + of_step;
    verdict.dynamics.value *= allowed / (options_.settings.tolerance + summed.inexactness);
    const auto worst = verdict.worst();
    const double excess = worst.value / allowed;
    ++count.certified;
    graphsolve::keep_largest(count.certificate, excess);
    if (excess <= 1) return;
    ++count.refuted;
    report_.refutations.push_back({family.name, index, after.step, worst.what, excess});
  }

  const Options& options_;
  Report& report_;
};

}  // namespace

namespace {

std::vector<const Family*> choose(const std::vector<std::string>& names) {
  std::vector<const Family*> chosen;
  std::string known;
  for (const Family& family : families()) {
    if (names.empty() || std::ranges::find(names, family.name) != names.end()) chosen.push_back(&family);
    known += (known.empty() ? "" : ", ") + family.name;
  }
  for (const std::string& name : names)
    if (std::ranges::none_of(families(), [&](const Family& family) { return family.name == name; }))
      throw std::invalid_argument("there is no family '" + name + "'; there are: " + known);
  return chosen;
}

}  // namespace

Report run(const Options& options) {
  Report report;
  const std::vector<const Family*> chosen = choose(options.families);
  Runner runner(options, report);
  for (std::size_t f = 0; f < chosen.size(); ++f) {
    Count& count = report.counts.emplace_back();
    count.family = chosen[f]->name;
    const int share = options.steps / static_cast<int>(chosen.size());
    for (int index = options.first_scene, made = 0; made < share; ++index) {
      made += runner.run_scene(*chosen[f], count, index, std::min(options.steps_of_scene, share - made));
      if (options.stop && options.stop()) return report;
    }
  }
  return report;
}

Count Report::total() const {
  Count sum;
  sum.family = "all";
  for (const Count& c : counts) {
    sum.scenes += c.scenes;
    sum.steps += c.steps;
    sum.failures += c.failures;
    sum.substepped += c.substepped;
    sum.restarted += c.restarted;
    sum.turned += c.turned;
    sum.culling_repeats += c.culling_repeats;
    sum.iterations += c.iterations;
    sum.most_iterations = std::max(sum.most_iterations, c.most_iterations);
    sum.distance = std::min(sum.distance, c.distance);
    sum.joint_error = std::max(sum.joint_error, c.joint_error);
    sum.certificate = std::max(sum.certificate, c.certificate);
    sum.certified += c.certified;
    sum.refuted += c.refuted;
    sum.seconds += c.seconds;
  }
  return sum;
}

std::ostream& operator<<(std::ostream& out, const Report& report) {
  fmt::print(out, "{:<12}{:>7}{:>8}{:>6}{:>8}{:>8}{:>7}{:>7}{:>7}{:>10}{:>10}{:>9}{:>8}{:>8}\n", "family", "scenes",
             "steps", "fail", "substep", "restart", "turned", "it", "max", "dist/m", "joint/m", "cert/bar", "refuted",
             "time/s");
  const auto line = [&](const Count& c) {
    fmt::print(out, "{:<12}{:>7}{:>8}{:>6}{:>8}{:>8}{:>7}{:>7.2f}{:>7}{:>10}{:>10.1e}{:>9.2g}{:>8}{:>8.2f}\n",
               c.family, c.scenes, c.steps, c.failures, c.substepped, c.restarted, c.turned,
               static_cast<double>(c.iterations) / std::max(c.steps, 1), c.most_iterations,
               std::isinf(c.distance) ? "-" : fmt::format("{:.1e}", c.distance), c.joint_error,  // no contacts: no distance
               c.certificate, c.refuted, c.seconds);
  };
  for (const Count& c : report.counts) line(c);
  line(report.total());
  for (const Incident& i : report.failures)
    fmt::print(out, "failed: {} scene {} step {}: {} (residual {:.1e})\n", i.family, i.scene, i.step, i.status, i.value);
  std::pair<std::string, int> listed;  // a scene that is refuted once often is in the rest of its steps too
  for (const Incident& i : report.refutations) {
    if (listed == std::pair(i.family, i.scene)) continue;
    listed = {i.family, i.scene};
    fmt::print(out, "refuted: {} scene {} from step {}: {} ({:.1e} of what is allowed)\n", i.family, i.scene, i.step,
               i.status, i.value);
  }
  return out;
}

}  // namespace campaign

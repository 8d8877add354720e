#include "physics/batch_simulator.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "stepper/stepper.hpp"

namespace physics {

namespace {

int at_least_one(int lanes) {
  if (lanes < 1) throw DescriptionError(fmt::format("a batch of {} lanes: at least one is needed", lanes));
  return lanes;
}

/// Bytes that a lane holds, at least: docs/architecture.md counts a third to a half more.
double least_bytes(const Mechanism& scene, const ProblemSize& size, int lanes) {
  const double nodes = 2000.0 * size.body_nodes + 1000.0 * size.joint_nodes;
  return nodes / lanes + 1000.0 * static_cast<double>(scene.contacts.size());
}

/// Before all memory is taken, and whoever else needs some is stopped.
void check_memory(int lanes, double bytes_per_lane) {
  const double needed = bytes_per_lane * lanes;
  const double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed > there)
    throw DescriptionError(fmt::format("a batch of {} lanes needs {:.3g} GB or more, and this machine has {:.3g} GB: "
                                       "take fewer lanes, which copies can use in turn",
                                       lanes, needed / 1e9, there / 1e9));
}

}  // namespace

/// Eight lanes at a time go through a whole step: their numbers stay in the cache, and they fill the vectors.
struct BatchSimulator::Impl {
  struct Cohort {
    std::unique_ptr<Stepper> stepper;
    std::vector<int> running;  ///< its lanes, ascending
  };
  struct Place {
    Stepper& stepper;
    int lane;  ///< of this stepper
  };

  Impl(const Mechanism& scene, int lanes, const SimulatorSettings& options) : count(at_least_one(lanes)) {
    for (int first = 0; first < count; first += Interleaving::width) {
      const int some = std::min(Interleaving::width, count - first);
      const Stepper* same = !cohorts.empty() && some == Interleaving::width ? cohorts.front().stepper.get() : nullptr;
      Cohort& cohort = cohorts.emplace_back(std::make_unique<Stepper>(scene, some, options, same));
      cohort.running.resize(some);
      std::iota(cohort.running.begin(), cohort.running.end(), 0);
      if (first == 0) check_memory(lanes, least_bytes(scene, cohort.stepper->size, some));
    }
    reckon();
  }
  [[nodiscard]] Cohort& cohort(int lane) {
    if (lane < 0 || lane >= count)
      throw std::out_of_range(fmt::format("there is no lane {}, but 0 to {}", lane, count - 1));
    return cohorts[lane / Interleaving::width];
  }
  [[nodiscard]] Place at(int lane) { return {*cohort(lane).stepper, lane % Interleaving::width}; }
  [[nodiscard]] const Lane& lane(int lane) { return at(lane).stepper.lanes[at(lane).lane]; }

  void stop(int lane) { std::erase(cohort(lane).running, lane % Interleaving::width); }
  void run(int lane) {
    auto& running = cohort(lane).running;
    const int own = lane % Interleaving::width;
    const auto place = std::lower_bound(running.begin(), running.end(), own);
    if (place == running.end() || *place != own) running.insert(place, own);
  }
  /// Times and sizes of all cohorts together.
  void reckon() {
    times = {};
    size = {};
    for (const Cohort& cohort : cohorts) {
      times += cohort.stepper->times;
      size += cohort.stepper->size;
    }
  }

  int count;
  std::vector<Cohort> cohorts;
  PhaseTimes times;
  ProblemSize size;
};

BatchSimulator::BatchSimulator(const Mechanism& scene, int lanes, const SimulatorSettings& settings)
    : impl_(std::make_unique<Impl>(scene, lanes, settings)) {}
BatchSimulator::~BatchSimulator() = default;
BatchSimulator::BatchSimulator(BatchSimulator&&) noexcept = default;
BatchSimulator& BatchSimulator::operator=(BatchSimulator&&) noexcept = default;

int BatchSimulator::lanes() const { return impl_->count; }

void BatchSimulator::load(int lane, Mechanism copy) {
  impl_->stop(lane);
  const auto [stepper, own] = impl_->at(lane);
  stepper.load(own, std::move(copy));
  impl_->run(lane);
}

void BatchSimulator::unload(int lane) { impl_->stop(lane); }

bool BatchSimulator::running(int lane) const {
  return std::ranges::binary_search(impl_->cohort(lane).running, lane % Interleaving::width);
}

void BatchSimulator::step() {
  for (auto& [stepper, running] : impl_->cohorts) {
    if (running.empty()) continue;
    stepper->step(running);
    std::erase_if(running, [&](int lane) { return !stepper->lanes[lane].last.ok(); });
  }
  impl_->reckon();
}

const StepResult& BatchSimulator::result(int lane) const { return impl_->lane(lane).last; }
const Mechanism& BatchSimulator::mechanism(int lane) const { return impl_->lane(lane).mechanism; }
int BatchSimulator::step_index(int lane) const { return impl_->lane(lane).step_index; }
double BatchSimulator::start_correction(int lane) const { return impl_->lane(lane).start_correction; }
double BatchSimulator::time(int lane) const { return impl_->lane(lane).time(); }
double BatchSimulator::smallest_distance_before(int lane) const { return impl_->lane(lane).smallest_distance; }

std::string BatchSimulator::failure_place(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.failure_place(own);
}
void BatchSimulator::write_record(int lane, StepRecord& record) const {
  const auto [stepper, own] = impl_->at(lane);
  stepper.write_record(own, record);
}
double BatchSimulator::smallest_distance(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.contacts->smallest_distance(own);
}
double BatchSimulator::largest_joint_error(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.largest_joint_error(own);
}
std::optional<double> BatchSimulator::joint_coordinate(int lane, int joint) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.joint_coordinate(own, joint);
}
std::optional<double> BatchSimulator::joint_rate(int lane, int joint) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.joint_rate(own, joint);
}
double BatchSimulator::energy(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.energy(own);
}
Vec3 BatchSimulator::linear_momentum(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.linear_momentum(own);
}
Vec3 BatchSimulator::angular_momentum(int lane) const {
  const auto [stepper, own] = impl_->at(lane);
  return stepper.angular_momentum(own);
}
const PhaseTimes& BatchSimulator::phase_times() const { return impl_->times; }
const ProblemSize& BatchSimulator::problem_size() const { return impl_->size; }

}  // namespace physics

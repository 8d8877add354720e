#include "physics/batch_simulator.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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

/// Eight lanes at a time go through a whole step: their numbers stay in the cache, and they fill the vectors. One
/// solver has one tolerance: a copy whose gravity asks for another (loosest_tolerance) has a stepper of its own, apart
/// from the others.
struct BatchSimulator::Impl {
  struct Cohort {
    std::unique_ptr<Stepper> stepper;
    std::vector<int> running;  ///< its lanes, ascending
  };
  struct Place {
    Stepper& stepper;
    int lane;  ///< of this stepper
  };

  Impl(const Mechanism& scene, int lanes, const SimulatorSettings& options)
      : count(at_least_one(lanes)), settings(options) {
    for (int first = 0; first < count; first += Interleaving::width) {
      const int some = std::min(Interleaving::width, count - first);
      const Stepper* same = !cohorts.empty() && some == Interleaving::width ? cohorts.front().stepper.get() : nullptr;
      Cohort& cohort = cohorts.emplace_back(std::make_unique<Stepper>(scene, some, options, same));
      cohort.running.resize(some);
      std::iota(cohort.running.begin(), cohort.running.end(), 0);
      if (first == 0) check_memory(lanes, least_bytes(scene, cohort.stepper->size, some));
    }
    apart.resize(count);
    together.reserve(Interleaving::width);
    reckon();
  }
  [[nodiscard]] Cohort& cohort(int lane) {
    if (lane < 0 || lane >= count)
      throw std::out_of_range(fmt::format("there is no lane {}, but 0 to {}", lane, count - 1));
    return cohorts[lane / Interleaving::width];
  }
  [[nodiscard]] Place among_others(int lane) { return {*cohort(lane).stepper, lane % Interleaving::width}; }
  [[nodiscard]] Place at(int lane) {
    const Place place = among_others(lane);
    return apart[lane] ? Place{*apart[lane], 0} : place;
  }
  [[nodiscard]] const Lane& lane(int lane) { return at(lane).stepper.lanes[at(lane).lane]; }

  void stop(int lane) { std::erase(cohort(lane).running, lane % Interleaving::width); }
  void run(int lane) {
    auto& running = cohort(lane).running;
    const int own = lane % Interleaving::width;
    const auto place = std::lower_bound(running.begin(), running.end(), own);
    if (place == running.end() || *place != own) running.insert(place, own);
  }
  void load(int lane, Mechanism copy) {
    stop(lane);
    const auto [stepper, own] = among_others(lane);
    stepper.load(own, std::move(copy));  // looks whether it fits
    const Mechanism& scene = stepper.lanes[own].mechanism;
    std::unique_ptr<Stepper> alone;
    if (std::min(settings.tolerance, loosest_tolerance(scene)) != stepper.settings.tolerance) {
      const auto other = std::ranges::find_if(apart, [](const auto& a) { return a != nullptr; });
      alone = std::make_unique<Stepper>(scene, 1, settings, other == apart.end() ? nullptr : other->get());
    }
    if (apart[lane]) add_work(*apart[lane], past_times, past_work);
    apart[lane] = std::move(alone);
    run(lane);
  }
  void step() {
    for (int first = 0; Cohort& cohort : cohorts) {
      together.clear();
      for (const int own : cohort.running) {
        if (apart[first + own]) apart[first + own]->step(std::array{0});
        else together.push_back(own);
      }
      if (!together.empty()) cohort.stepper->step(together);
      std::erase_if(cohort.running, [&](int own) { return !lane(first + own).last.ok(); });
      first += Interleaving::width;
    }
    reckon();
  }

  /// Of a copy apart: its nodes are counted in its place among the others.
  static void add_work(const Stepper& stepper, PhaseTimes& times, ProblemSize& size) {
    times += stepper.times;
    for (auto part : {&ProblemSize::culled_contacts, &ProblemSize::contact_steps, &ProblemSize::newton_steps})
      size.*part += stepper.size.*part;
  }
  /// Times and sizes of all copies together.
  void reckon() {
    times = past_times;
    size = past_work;
    for (const Cohort& cohort : cohorts) {
      times += cohort.stepper->times;
      size += cohort.stepper->size;
    }
    for (const auto& stepper : apart)
      if (stepper) add_work(*stepper, times, size);
  }

  int count;
  SimulatorSettings settings;
  std::vector<Cohort> cohorts;
  std::vector<std::unique_ptr<Stepper>> apart;  ///< by lane, null for most
  std::vector<int> together;                    ///< scratch: lanes of a cohort that step as one
  PhaseTimes past_times;                        ///< of copies that were apart
  ProblemSize past_work;
  PhaseTimes times;
  ProblemSize size;
};

BatchSimulator::BatchSimulator(const Mechanism& scene, int lanes, const SimulatorSettings& settings)
    : impl_(std::make_unique<Impl>(scene, lanes, settings)) {}
BatchSimulator::~BatchSimulator() = default;
BatchSimulator::BatchSimulator(BatchSimulator&&) noexcept = default;
BatchSimulator& BatchSimulator::operator=(BatchSimulator&&) noexcept = default;

int BatchSimulator::lanes() const { return impl_->count; }

void BatchSimulator::load(int lane, Mechanism copy) { impl_->load(lane, std::move(copy)); }
void BatchSimulator::unload(int lane) { impl_->stop(lane); }

bool BatchSimulator::running(int lane) const {
  return std::ranges::binary_search(impl_->cohort(lane).running, lane % Interleaving::width);
}

void BatchSimulator::step() { impl_->step(); }

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

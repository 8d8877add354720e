#include "physics/batch_simulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "stepper.hpp"

namespace physics {

namespace {

int at_least_one(int lanes) {
  if (lanes < 1) throw DescriptionError(fmt::format("a batch of {} lanes: at least one is needed", lanes));
  return lanes;
}

}  // namespace

struct BatchSimulator::Impl : Stepper {
  Impl(const Mechanism& scene, int count, const SimulatorSettings& options) : Stepper(scene, at_least_one(count), options) {
    running.resize(count);
    std::iota(running.begin(), running.end(), 0);
  }
  void stop(int lane) { std::erase(running, lane); }
  void run(int lane) {
    const auto place = std::lower_bound(running.begin(), running.end(), lane);
    if (place == running.end() || *place != lane) running.insert(place, lane);
  }

  std::vector<int> running;  ///< lanes, ascending
};

BatchSimulator::BatchSimulator(const Mechanism& scene, int lanes, const SimulatorSettings& settings)
    : impl_(std::make_unique<Impl>(scene, lanes, settings)) {}
BatchSimulator::~BatchSimulator() = default;
BatchSimulator::BatchSimulator(BatchSimulator&&) noexcept = default;
BatchSimulator& BatchSimulator::operator=(BatchSimulator&&) noexcept = default;

int BatchSimulator::lanes() const { return static_cast<int>(impl_->lanes.size()); }

void BatchSimulator::load(int lane, Mechanism copy) {
  impl_->stop(lane);
  impl_->load(lane, std::move(copy));
  impl_->run(lane);
}

void BatchSimulator::unload(int lane) { impl_->stop(lane); }

bool BatchSimulator::running(int lane) const {
  return std::binary_search(impl_->running.begin(), impl_->running.end(), lane);
}

void BatchSimulator::step() {
  Impl& s = *impl_;
  if (s.running.empty()) return;
  s.step(s.running);
  std::erase_if(s.running, [&](int lane) { return !s.lanes[lane].last.ok(); });
}

const StepResult& BatchSimulator::result(int lane) const { return impl_->lanes[lane].last; }
std::string BatchSimulator::failure_place(int lane) const { return impl_->failure_place(lane); }
void BatchSimulator::write_record(int lane, StepRecord& record) const { impl_->write_record(lane, record); }
const Mechanism& BatchSimulator::mechanism(int lane) const { return impl_->lanes[lane].mechanism; }
int BatchSimulator::step_index(int lane) const { return impl_->lanes[lane].step_index; }
double BatchSimulator::time(int lane) const { return impl_->lanes[lane].time; }
double BatchSimulator::smallest_distance(int lane) const { return impl_->contacts->smallest_distance(lane); }
double BatchSimulator::smallest_distance_before(int lane) const { return impl_->lanes[lane].smallest_distance; }
double BatchSimulator::largest_joint_error(int lane) const { return impl_->largest_joint_error(lane); }
double BatchSimulator::energy(int lane) const { return impl_->energy(lane); }
Vec3 BatchSimulator::linear_momentum(int lane) const { return impl_->linear_momentum(lane); }
Vec3 BatchSimulator::angular_momentum(int lane) const { return impl_->angular_momentum(lane); }
const PhaseTimes& BatchSimulator::phase_times() const { return impl_->times; }
const ProblemSize& BatchSimulator::problem_size() const { return impl_->size; }

}  // namespace physics

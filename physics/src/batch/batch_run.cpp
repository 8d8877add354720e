#include "physics/batch_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "batch/parallel_for.hpp"
#include "physics/run.hpp"

namespace physics {

namespace {

/// Hands out copies in order and takes results in order. Shared by the threads.
class Queue {
 public:
  explicit Queue(const BatchRun& run) : run_(run), next_(run.first), due_(run.first) {}

  std::optional<long long> next() {
    const std::lock_guard lock(mutex_);
    if (ended_ || next_ >= run_.last) return {};
    return next_++;
  }
  /// Results that come early wait for those before them; there are never more of these than lanes in all.
  void finish(CopyResult&& result) {
    const std::lock_guard lock(mutex_);
    early_.emplace(result.copy, std::move(result));
    while (!ended_ && !early_.empty() && early_.begin()->first == due_) {
      ended_ = !run_.on_result(std::move(early_.begin()->second));
      early_.erase(early_.begin());
      ++due_;
    }
  }
  /// Copies are begun in order, so all before this one have been begun: the lowest that fails is always the same.
  void fail(long long copy, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    if (error_ && failed_ < copy) return;
    failed_ = copy;
    error_ = std::move(error);
  }
  [[nodiscard]] bool ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  const BatchRun& run_;
  mutable std::mutex mutex_;
  long long next_, due_, failed_ = 0;
  std::map<long long, CopyResult> early_;
  std::exception_ptr error_;
  bool ended_ = false;
};

/// One thread's lanes.
class Worker {
 public:
  Worker(const Mechanism& scene, const BatchRun& run, Queue& queue)
      : run_(run), queue_(queue), batch_(scene, run.lanes, run.settings), results_(run.lanes) {
    for (int lane = 0; lane < run.lanes; ++lane) refill(lane);
  }
  void work() {
    while (busy_ > 0 && !queue_.ended() && !(run_.stop && run_.stop())) {
      batch_.step();
      for (int lane = 0; lane < batch_.lanes(); ++lane)
        if (results_[lane]) take(lane);
    }
  }

 private:
  void refill(int lane) {
    results_[lane].reset();
    batch_.unload(lane);
    while (const auto copy = queue_.next()) {
      try {
        load(lane, *copy);
      } catch (const DescriptionError& error) {
        queue_.fail(*copy, std::make_exception_ptr(CopyError(*copy, error)));
        return;
      } catch (...) {
        queue_.fail(*copy, std::current_exception());
        return;
      }
      if (run_.steps > 0) {
        ++busy_;
        return;
      }
      finish(lane);  // a copy of no steps ends where it starts
    }
  }
  void load(int lane, long long copy) {
    batch_.load(lane, run_.make(copy));
    CopyResult& result = results_[lane].emplace();
    result.copy = copy;
    result.start_correction = batch_.start_correction(lane);
    result.energy_start = batch_.energy(lane);
    result.smallest_distance = batch_.smallest_distance(lane);
    if (result.smallest_distance < -inside_a_plane) name_deepest(lane, result);
  }
  /// That which the smallest distance is of: contacts of bodies that cannot move are in the record too, and not in it.
  void name_deepest(int lane, CopyResult& result) const {
    StepRecord record;
    batch_.write_record(lane, record);
    const auto deepest = std::ranges::min_element(
        record.contacts, {}, [&](const ContactRecord& contact) { return std::abs(contact.distance - result.smallest_distance); });
    result.start_contact = static_cast<int>(deepest - record.contacts.begin());
    result.start_depth = -result.smallest_distance;
  }
  void take(int lane) {
    CopyResult& result = *results_[lane];
    const StepResult& step = result.last = batch_.result(lane);
    result.iterations += step.iterations;
    result.most_iterations = std::max(result.most_iterations, step.iterations);
    if (step.ok()) {
      ++result.steps;
      result.substepped_steps += step.substeps > 1;
      result.restarted_steps += step.restarts > 0;
      result.turned_steps += step.new_force_direction;
      result.residual = std::max(result.residual, step.residual);
      result.smallest_distance = std::min(result.smallest_distance, batch_.smallest_distance_before(lane));
      if (result.steps < run_.steps) return;
    } else {
      result.place = batch_.failure_place(lane);
    }
    --busy_;
    finish(lane);
    refill(lane);
  }
  void finish(int lane) {
    CopyResult& result = *results_[lane];
    result.smallest_distance = std::min(result.smallest_distance, batch_.smallest_distance(lane));
    result.joint_error = batch_.largest_joint_error(lane);
    result.energy_end = batch_.energy(lane);
    StepRecord record;
    batch_.write_record(lane, record);
    result.bodies = std::move(record.bodies);
    queue_.finish(std::move(result));
    results_[lane].reset();
  }

  const BatchRun& run_;
  Queue& queue_;
  BatchSimulator batch_;
  std::vector<std::optional<CopyResult>> results_;
  int busy_ = 0;
};

}  // namespace

CopyError::CopyError(long long copy, const DescriptionError& error)
    : DescriptionError(fmt::format("copy {}: {}", copy, error.what()), error.place()), copy_(copy), reason_(error.what()) {}

void run_batch(const Mechanism& scene, const BatchRun& run) {
  if (!run.make) throw std::invalid_argument("run_batch: 'make' is not set, which gives each copy");
  if (!run.on_result) throw std::invalid_argument("run_batch: 'on_result' is not set, which takes the results");
  const long long copies = run.last - run.first;
  if (copies <= 0) return;
  BatchRun used = run;
  used.threads = static_cast<int>(std::clamp<long long>(run.threads, 1, copies));
  used.lanes = static_cast<int>(std::clamp<long long>(run.lanes, 1, (copies + used.threads - 1) / used.threads));
  Queue queue(used);
  parallel_for(used.threads, [&](int) {
    try {
      Worker(scene, used, queue).work();
    } catch (...) {
      queue.fail(-1, std::current_exception());  // the scene itself, or memory
    }
  });
  queue.rethrow();
}

}  // namespace physics

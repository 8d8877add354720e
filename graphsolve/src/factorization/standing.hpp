#pragma once

#include <algorithm>
#include <vector>

namespace graphsolve {

/// What has become of every component: is there a factor to solve with, and a copy of its matrix to refine by?
class Standing {
 public:
  enum class Factor : char { none, failed, there };

  explicit Standing(int components) : state_(components) {}
  [[nodiscard]] Factor factor(int component) const { return state_[component].factor; }
  [[nodiscard]] bool is_kept(int component) const { return state_[component].kept; }
  [[nodiscard]] bool all_kept() const { return std::ranges::all_of(state_, &State::kept); }

  /// Its numbers were written over.
  void begin(int component, bool kept) { state_[component] = {Factor::none, kept}; }
  void end(int component, bool sound) { state_[component].factor = sound ? Factor::there : Factor::failed; }
  /// Its factor was written over; the copy of the matrix is what it was.
  void lose_factor(int component) { state_[component].factor = Factor::none; }

 private:
  struct State {
    Factor factor = Factor::none;
    bool kept = false;
  };
  std::vector<State> state_;
};

}  // namespace graphsolve

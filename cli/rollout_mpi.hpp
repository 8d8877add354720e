#pragma once

#include <string>
#include <vector>

/// The processes of an MPI run; one process where there is none.
namespace cli {

class Processes {
 public:
  /// Joins the others when the program was started by mpirun. Throws DescriptionError when it was, but was built without
  /// MPI.
  Processes();
  ~Processes();
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int count() const { return count_; }
  /// Entrywise sums over all processes, which all have to call this; equal lengths.
  void sum(std::vector<long long>& values) const;
  /// Of the values of all processes, which all have to call this.
  [[nodiscard]] double largest(double value) const;
  /// Texts of all processes in their order, for the first; nothing for the others. All have to call this.
  [[nodiscard]] std::vector<std::string> gather(const std::string& text) const;
  /// Ends all processes with this exit code; returns when there is only one.
  void abort(int code) const;

 private:
  int rank_ = 0, count_ = 1;
};

}  // namespace cli

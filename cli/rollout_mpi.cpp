#include "rollout_mpi.hpp"

#include <cstdlib>
#include <numeric>

#include "physics/mechanism.hpp"

#ifdef GRAPHSOLVE_HAS_MPI
#include <mpi.h>
#endif

namespace cli {

namespace {

/// What Open MPI, MPICH and their kin tell the processes they start: how many there are; 0 without mpirun.
int started_by_mpirun() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 0;
}

}  // namespace

#ifdef GRAPHSOLVE_HAS_MPI

Processes::Processes() {
  if (started_by_mpirun() == 0) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}
Processes::~Processes() {
  if (started_by_mpirun() > 0) MPI_Finalize();
}
void Processes::sum(std::vector<long long>& values) const {
  if (count_ > 1)
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
}
double Processes::largest(double value) const {
  if (count_ > 1) MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return value;
}
std::vector<std::string> Processes::gather(const std::string& text) const {
  if (count_ == 1) return {text};
  const int size = static_cast<int>(text.size());
  std::vector<int> sizes(count_), begins(count_ + 1);
  MPI_Gather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (rank_ == 0) std::partial_sum(sizes.begin(), sizes.end(), begins.begin() + 1);
  std::string all(begins.back(), ' ');
  MPI_Gatherv(text.data(), size, MPI_CHAR, all.data(), sizes.data(), begins.data(), MPI_CHAR, 0, MPI_COMM_WORLD);
  std::vector<std::string> texts;
  for (int rank = 0; rank < count_ && rank_ == 0; ++rank) texts.push_back(all.substr(begins[rank], sizes[rank]));
  return texts;
}
void Processes::abort(int code) const {
  if (count_ > 1) MPI_Abort(MPI_COMM_WORLD, code);
}

#else

Processes::Processes() {
  if (started_by_mpirun() > 1)
    throw physics::DescriptionError(
        "started by mpirun, but built without MPI: install libopenmpi-dev and build anew, or run the shards one by one "
        "with --shard");
}
Processes::~Processes() = default;
void Processes::sum(std::vector<long long>&) const {}
double Processes::largest(double value) const { return value; }
std::vector<std::string> Processes::gather(const std::string& text) const { return {text}; }
void Processes::abort(int) const {}

#endif

}  // namespace cli

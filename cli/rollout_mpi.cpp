#include "rollout_mpi.hpp"

#include <cstdlib>

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
void Processes::abort(int) const {}

#endif

}  // namespace cli

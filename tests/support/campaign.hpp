#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

#include "physics/mechanism.hpp"
#include "physics/simulator.hpp"

/// The campaign of extremes: seeded families of scenes, each with one thing far out of the ordinary, and a runner
/// that counts what happened and lists every step that failed. Equal seed and index give the equal scene.
namespace campaign {

struct Family {
  std::string name;
  std::string extreme;  ///< what is far out, for tables
  physics::Mechanism (*make)(class Random&);
};

/// Numbers that are the same on every platform, which those of <random>'s distributions are not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits();
  double uniform(double low, double high);
  double logarithmic(double low, double high);  ///< both > 0
  int integer(int low, int high);               ///< inclusive
  bool coin() { return (bits() >> 32 & 1) != 0; }

 private:
  std::uint64_t state_;
};

physics::Vec3 direction(Random& random);  ///< of length 1, evenly
/// Its inertia is that of a homogeneous one.
physics::Body box(const std::string& name, const physics::Vec3& size, double mass);

const std::vector<Family>& families();

/// Scene number `index` of a family.
physics::Mechanism scene(const Family& family, std::uint64_t seed, int index);

struct Options {
  int steps = 100'000;  ///< in all, shared equally by the families
  int steps_of_scene = 200;
  int first_scene = 0;  ///< of each family
  std::uint64_t seed = 1;
  bool certify = true;  ///< judge every step by the certificate
  std::vector<std::string> families;  ///< only these; empty: all
  physics::SimulatorSettings settings;
  std::function<bool()> stop;  ///< asked after every scene, where it is set: the report is of those made
};

/// A step that failed, or one that claims to be solved and that the certificate refutes.
struct Incident {
  std::string family;
  int scene = 0;  ///< number within the family
  int step = 0;
  std::string status;  ///< or what the certificate found
  double value = 0;    ///< residual, or the certificate over what it allows
};

struct Count {
  std::string family;
  int scenes = 0, steps = 0, failures = 0;
  int substepped = 0, restarted = 0, turned = 0;  ///< steps with substeps, restarts, new force directions
  int culling_repeats = 0;
  long long iterations = 0;
  int most_iterations = 0;
  double distance = std::numeric_limits<double>::infinity();  ///< smallest [m]
  double joint_error = 0;                                     ///< largest [m, rad]
  double certificate = 0;  ///< largest over what it allows, of solved steps without flags
  int certified = 0, refuted = 0;
  double seconds = 0;
};

struct Report {
  std::vector<Count> counts;  ///< by family
  std::vector<Incident> failures, refutations;
  [[nodiscard]] Count total() const;
};

/// Throws std::invalid_argument when there is no such family, physics::DescriptionError when the settings are wrong.
Report run(const Options& options);

/// A table of the families, then every failure, and the first refutation of each scene.
std::ostream& operator<<(std::ostream& out, const Report& report);

}  // namespace campaign

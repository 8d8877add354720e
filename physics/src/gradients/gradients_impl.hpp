#pragma once

#include <vector>

#include "gradients/normals_first.hpp"
#include "graphsolve/factorization.hpp"
#include "physics/gradients.hpp"
#include "terms/sensitivity.hpp"
#include "simd/gradient_kernels.hpp"
#include "stepper/stepper.hpp"

namespace physics {

struct StepGradient::Impl {
  /// Bodies whose velocities are the right-hand sides of one pass of jacobian().
  static constexpr int bodies_per_pass = pass_columns / 6;
  /// Derivatives of the velocities of one pass, a column per input.
  using Pass = NormalsFirst::Pass;

  /// Puts the simulator back before its last step for as long as it lives; then it is as it was, to the last bit.
  class Rewound {
   public:
    explicit Rewound(Impl& owner);
    ~Rewound();
    Rewound(const Rewound&) = delete;
    Rewound& operator=(const Rewound&) = delete;

   private:
    void exchange();
    Impl& owner_;
  };

  Impl(Simulator::Impl& owner, const GradientSettings& options);
  GradientStatus evaluate();
  void add_load_arms();
  void find_yielding_normals();
  [[nodiscard]] Lane& lane() const { return simulator.lanes.front(); }
  void check(std::string_view name, std::size_t given, int wanted) const;
  [[nodiscard]] int bodies() const { return static_cast<int>(next.size()); }
  [[nodiscard]] int columns(StepInput input) const;
  [[nodiscard]] int offset(StepInput input) const;

  void vector_jacobian(std::span<const double> adjoint, std::span<double> gradient);
  void jacobian(StepInput input, std::span<double> out);
  void solve_pass(int first, int count);
  void multiply(StepInput input);
  void multiply_state();

  Simulator::Impl& simulator;
  GradientSettings settings;
  bool ready = false;
  double dt = 0, impulse_time = 0;
  graphsolve::Factorization matrix;
  Sensitivity sensitivity;
  std::vector<double> x;         ///< unknowns where the derivative is taken
  std::vector<double> unknowns;  ///< of the simulator, kept while it is rewound
  std::vector<NextPose> next;
  std::vector<int> row;          ///< of each moving body
  std::vector<double> adjoint;   ///< by row
  std::vector<double> scratch;   ///< by row
  NormalsFirst normals;
  Eigen::MatrixXd solutions;     ///< rows x pass_columns
  Pass transposed;               ///< of it, pass_columns x rows
  Pass product;                  ///< pass_columns x inputs
  double stiffness = 0;          ///< bound on z/s over the island's mass
  std::vector<double> gyration;  ///< smallest radius of each moving body [m]
};

}  // namespace physics

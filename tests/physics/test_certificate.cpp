// The certificate must pass what an independent oracle computed, and must fail for every way to be wrong that we
// could think of: a certificate that cannot fail is worth nothing.

#include <gtest/gtest.h>

#include <functional>

#include "support/certificate.hpp"
#include "support/reference_files.hpp"

namespace test_certificate {

using certificate::Certificate;
using certificate::certify;
using certificate::certify_step;
using certificate::Finding;
using physics::ContactRecord;
using physics::StepRecord;
using physics::Vec3;

constexpr double bar = 1e-8;               // of a solver at default settings
constexpr double oracle_accuracy = 1e-11;  // what the references certify at

class ReferenceCertificate : public testing::TestWithParam<std::string> {};

TEST_P(ReferenceCertificate, CertifiesAtTheOraclesAccuracy) {
  const physics::Trajectory trajectory = reference::read(GetParam());
  const Certificate result = certify(trajectory);
  EXPECT_GE(result.steps, 24);
  EXPECT_EQ(result.flagged, 0);
  EXPECT_LE(result.residual(), oracle_accuracy) << result;
  EXPECT_LE(result.momentum.value, oracle_accuracy);
  // The files give distances with six digits.
  EXPECT_LE(result.distance_difference.value, 5e-6);
  EXPECT_GE(result.smallest_distance, -1e-14);
}

INSTANTIATE_TEST_SUITE_P(All, ReferenceCertificate, testing::ValuesIn(reference::names()),
                         [](const auto& parameter) { return parameter.param; });

/// One way to be wrong: changes the record after the step; false when it would change nothing in this record.
struct Fault {
  const char* name;
  std::function<bool(const physics::Mechanism&, StepRecord&)> inject;
  std::vector<Finding Certificate::*> caught_by;  // any of these must exceed the bar
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

ContactRecord* pressed(StepRecord& record) {
  for (ContactRecord& contact : record.contacts) {
    if (contact.normal_force > 0.1) return &contact;
  }
  return nullptr;
}

std::function<bool(const physics::Mechanism&, StepRecord&)> on_pressed(std::function<bool(ContactRecord&)> change) {
  return [change](const physics::Mechanism&, StepRecord& record) {
    ContactRecord* contact = pressed(record);
    return contact && change(*contact);
  };
}

bool swap_facets(ContactRecord& contact, bool force_too) {
  std::vector<double>& beta = contact.facet_forces;
  if (beta.size() != 4 || std::abs(beta[2] - beta[1]) < 1e-3) return false;
  std::swap(beta[1], beta[2]);
  if (force_too) contact.friction_force += (beta[1] - beta[2]) * (Vec3::UnitX() + Vec3::UnitY());
  return true;
}

const std::vector<Fault> faults{
    {"NormalForceScaledBy1001", on_pressed([](ContactRecord& c) { return c.normal_force *= 1.001, true; }),
     {&Certificate::dynamics}},
    {"NormalForceNegative", on_pressed([](ContactRecord& c) { return c.normal_force *= -1e-3, true; }),
     {&Certificate::tension}},
    {"FrictionForceScaledBy1001", on_pressed([](ContactRecord& c) {
       if (c.friction_force.norm() < 1e-2) return false;
       c.friction_force *= 1.001;
       for (double& beta : c.facet_forces) beta *= 1.001;
       return true;
     }),
     {&Certificate::dynamics}},
    {"FrictionBeyondTheCone", on_pressed([](ContactRecord& c) {
       double sum = 0;
       for (const double beta : c.facet_forces) sum += beta;
       if (sum < 0.019) return false;
       const double factor = 1.001 * 0.5 * c.normal_force / sum;
       c.friction_force *= factor;
       for (double& beta : c.facet_forces) beta *= factor;
       return true;
     }),
     {&Certificate::pyramid, &Certificate::friction_pairs, &Certificate::dynamics}},
    {"FacetsSwapped", on_pressed([](ContactRecord& c) { return swap_facets(c, false); }), {&Certificate::pyramid}},
    {"FacetsSwappedWithTheirForce", on_pressed([](ContactRecord& c) { return swap_facets(c, true); }),
     {&Certificate::dynamics}},
    {"FacetNegative", on_pressed([](ContactRecord& c) {
       for (const int i : {0, 2}) c.facet_forces[i] -= 1e-3 * c.normal_force;
       return c.facet_forces[0] < 0 || c.facet_forces[2] < 0;
     }),
     {&Certificate::pyramid}},
    {"FrictionOutOfTheTangentPlane", on_pressed([](ContactRecord& c) {
       c.friction_force.z() += 1e-3;
       c.normal_force -= 1e-3;
       return true;
     }),
     {&Certificate::pyramid}},
    {"BasisCrooked", on_pressed([](ContactRecord& c) { return c.tangent = Vec3(1, 0, 1e-3), true; }),
     {&Certificate::pyramid}},
    {"PositionShifted", [](const physics::Mechanism&, StepRecord& r) {
       return r.bodies[0].position.x() += 1e-6, true;
     },
     {&Certificate::kinematics}},
    {"PositionAndVelocityShifted", [](const physics::Mechanism& m, StepRecord& r) {
       r.bodies[0].position.y() += 1e-6;
       r.bodies[0].velocity.y() += 1e-6 / m.time_step;
       return true;
     },
     {&Certificate::dynamics, &Certificate::joints}},
    {"OrientationTurned", [](const physics::Mechanism&, StepRecord& r) {
       r.bodies[0].orientation.coeffs() += Eigen::Vector4d(0, 0, 1e-7, 0);
       return true;
     },
     {&Certificate::kinematics}},
    {"NotANumber", [](const physics::Mechanism&, StepRecord& r) {
       return r.bodies[0].velocity.z() = std::numeric_limits<double>::quiet_NaN(), true;
     },
     {&Certificate::kinematics}},
    {"DistanceMisreported", on_pressed([](ContactRecord& c) { return c.distance += 1e-5, true; }),
     {&Certificate::distance_difference}},
};

class FaultInEveryReference : public testing::TestWithParam<Fault> {};

TEST_P(FaultInEveryReference, IsCaught) {
  const Fault& fault = GetParam();
  int tried = 0;
  for (const std::string& name : reference::names()) {
    const physics::Trajectory trajectory = reference::read(name);
    for (std::size_t k = 1; k < trajectory.steps.size(); ++k) {
      const StepRecord& before = trajectory.steps[k - 1];
      StepRecord after = trajectory.steps[k];
      if (after.step != before.step + 1 || !fault.inject(trajectory.mechanism, after)) continue;
      ++tried;
      const Certificate result = certify_step(trajectory.mechanism, before, after);
      bool caught = false;
      for (const auto measure : fault.caught_by) caught = caught || !((result.*measure).value <= 10 * bar);
      EXPECT_TRUE(caught) << name << " step " << after.step << ": " << result;
    }
  }
  EXPECT_GE(tried, 10);
}

INSTANTIATE_TEST_SUITE_P(Certificate, FaultInEveryReference, testing::ValuesIn(faults),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(Certificate, CatchesTheWrongSignOfTheOldGyroscopicTerm) {
  // With it, p+(w') = p+(w): the spin stays as it is and the gyroscopic torque is gone.
  const physics::Trajectory trajectory = reference::read("free_top");
  const StepRecord& before = trajectory.steps[0];
  StepRecord after = trajectory.steps[1];
  const Vec3 w = before.bodies[0].angular_velocity, e = trajectory.mechanism.time_step / 2 * w;
  after.bodies[0].angular_velocity = w;
  const double c = std::sqrt(1 - e.squaredNorm());
  after.bodies[0].orientation = before.bodies[0].orientation * physics::Quat(c, e.x(), e.y(), e.z());
  const Certificate result = certify_step(trajectory.mechanism, before, after);
  EXPECT_LE(result.kinematics.value, 1e-12);
  EXPECT_GT(result.dynamics.value, 1e-3);
}

TEST(Certificate, CatchesForceOnAnOpenContact) {
  const physics::Trajectory trajectory = reference::read("cylinder_c8");
  StepRecord after = trajectory.steps[1];
  after.contacts[3].normal_force = 1;
  const Certificate result = certify_step(trajectory.mechanism, trajectory.steps[0], after);
  EXPECT_GT(result.gap_pairs.value, 1e-3);
  EXPECT_GT(result.dynamics.value, 1e-3);
}

TEST(Certificate, CatchesFrictionAlongTheSlip) {
  // Friction turned round and the velocity it would make: dynamics hold, the friction law does not.
  const physics::Trajectory trajectory = reference::read("incline_box");
  StepRecord after = trajectory.steps[1];
  Vec3 gain = Vec3::Zero();
  for (ContactRecord& contact : after.contacts) {
    std::swap(contact.facet_forces[0], contact.facet_forces[2]);
    contact.friction_force = -contact.friction_force;
    gain += 2 * trajectory.mechanism.time_step * contact.friction_force;
  }
  after.bodies[0].velocity += gain;
  after.bodies[0].position += trajectory.mechanism.time_step * gain;
  const Certificate result = certify_step(trajectory.mechanism, trajectory.steps[0], after);
  EXPECT_GT(result.friction_pairs.value, 1e-3);
  EXPECT_LE(result.pyramid.value, 1e-11);
}

TEST(Certificate, RefusesRecordsThatDoNotFollowEachOther) {
  const physics::Trajectory trajectory = reference::read("pendulum");
  EXPECT_THROW(certify_step(trajectory.mechanism, trajectory.steps[0], trajectory.steps[2]), std::invalid_argument);
}

}  // namespace test_certificate

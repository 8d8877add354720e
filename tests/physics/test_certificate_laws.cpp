// Parts of the certificate that the reference files do not reach, on steps solved by hand: recorded joint forces,
// merged bodies, the half kick, spheres, loads, flagged steps.

#include <gtest/gtest.h>

#include <cmath>

#include "steps_by_hand.hpp"
#include "support/certificate.hpp"
#include "support/reference_files.hpp"

namespace test_certificate_laws {

using by_hand::about;
using by_hand::record;
using by_hand::rounding;
using certificate::Certificate;
using certificate::certify_step;
using physics::BodyRecord;
using physics::StepRecord;
using physics::Vec3;

/// A step of the reference pendulum with the joint wrench that explains it.
struct RecordedPendulum {
  physics::Trajectory trajectory = reference::read("pendulum");
  physics::Mechanism& mechanism = trajectory.mechanism;
  StepRecord before = trajectory.steps[20], after = trajectory.steps[21];

  RecordedPendulum() {
    before = trajectory.steps[19];
    after = trajectory.steps[20];
    const physics::Body& body = mechanism.bodies[0];
    physics::JointRecord joint;
    joint.force = body.mass * ((after.bodies[0].velocity - before.bodies[0].velocity) / mechanism.time_step -
                               mechanism.gravity);
    after.joints = {joint};
  }
  [[nodiscard]] Certificate judge() const { return certify_step(mechanism, before, after); }
};

TEST(CertificateOfJoints, RecordedForceOfThePlanarPendulumExplainsItsMotion) {
  const Certificate result = RecordedPendulum().judge();
  EXPECT_LE(result.residual(), 1e-11) << result;
}

TEST(CertificateOfJoints, RecordedForceScaledBy1001IsCaught) {
  RecordedPendulum pendulum;
  pendulum.after.joints[0].force *= 1.001;
  EXPECT_GT(pendulum.judge().dynamics.value, 1e-6);
}

TEST(CertificateOfJoints, TorqueAboutAFreeAxisIsCaught) {
  RecordedPendulum pendulum;
  pendulum.after.joints[0].torque.y() = 1e-3;
  EXPECT_GT(pendulum.judge().wrench.value, 1e-6);
}

TEST(CertificateOfJoints, TorqueAboutALockedAxisIsCaughtInTheDynamicsOnly) {
  RecordedPendulum pendulum;
  pendulum.after.joints[0].torque.x() = 1e-3;
  const Certificate result = pendulum.judge();
  EXPECT_LE(result.wrench.value, rounding);
  EXPECT_GT(result.dynamics.value, 1e-6);
}

/// A constraint's torque is the gradient of what it locks, here by central differences. At a hinge that is open by 0.01 rad
/// it has a component about the parent's axis, one about the child's, and none about their middle.
TEST(CertificateOfJoints, TorqueOfAnOpenHingeIsTheGradientOfWhatItLocks) {
  RecordedPendulum pendulum;
  const physics::Joint& hinge = pendulum.mechanism.joints[0];
  physics::Quat& child = pendulum.before.bodies[0].orientation;
  child = about(Vec3::UnitX(), 0.005) * child;  // the parent is the world, the axis y
  const auto locked = [&](const Vec3& turn) {
    return 2 * (physics::Quat(1, turn.x() / 2, turn.y() / 2, turn.z() / 2) * child * hinge.orientation.conjugate()).z();
  };
  Vec3 torque;
  for (int k = 0; k < 3; ++k) torque[k] = (locked(1e-5 * Vec3::Unit(k)) - locked(-1e-5 * Vec3::Unit(k))) / 2e-5;
  ASSERT_GT(std::abs(torque.y()), 0.004);
  pendulum.after.joints[0].torque = torque;
  const double allowed = 1e-9;  // of the differences
  EXPECT_LE(pendulum.judge().wrench.value, allowed);
  pendulum.after.joints[0].torque += Vec3(0, 1e-3, 0);
  EXPECT_GT(pendulum.judge().wrench.value, 1e-6);
}

TEST(CertificateOfJoints, OpenedJointIsCaught) {
  RecordedPendulum pendulum;
  pendulum.after.bodies[0].position.z() += 1e-6;
  EXPECT_NEAR(pendulum.judge().joint_error.value, 1e-6, 1e-12);
}

/// Two unequal masses merged by a fixed joint, spinning freely about z around their common centre.
struct Dumbbell {
  physics::Mechanism mechanism;
  StepRecord before, after;

  Dumbbell() {
    const double dt = mechanism.time_step = 0.01, w = 5, e = dt / 2 * w;
    mechanism.gravity.setZero();
    mechanism.start = physics::Start::standard;
    const double place[] = {-0.2, 0.6}, mass[] = {3, 1};
    for (int i = 0; i < 2; ++i) {
      physics::Body body;
      body.name = i == 0 ? "big" : "small";
      body.mass = mass[i];
      body.inertia = 0.01 * mass[i] * physics::Mat3::Identity();
      mechanism.add(body);
    }
    physics::Joint weld;
    weld.name = "weld";
    weld.parent = {0};
    weld.child = {1};
    weld.parent_point = {0.8, 0, 0};
    mechanism.add(weld);
    const double angle = 2 * std::asin(e);
    const auto at = [&](int k) {
      StepRecord r = record(k, dt, {});
      for (const double x : place) {
        const auto point = [&](int n) { return Vec3(x * std::cos(n * angle), x * std::sin(n * angle), 0); };
        r.bodies.push_back({point(k), about(Vec3::UnitZ(), std::sin(k * angle / 2)), (point(k) - point(k - 1)) / dt,
                            {0, 0, w}});
      }
      r.joints.resize(1);
      return r;
    };
    before = at(1);
    after = at(2);
  }
  [[nodiscard]] Certificate judge() const { return certify_step(mechanism, before, after); }
};

TEST(CertificateOfMergedBodies, FreeDumbbellIsJudgedAsOneBody) {
  EXPECT_LE(Dumbbell().judge().residual(), rounding) << Dumbbell().judge();
}

TEST(CertificateOfMergedBodies, ForceFreeMembersDoNotPassAsTwoBodies) {
  Dumbbell dumbbell;
  dumbbell.after.joints[0].torque = Vec3::Constant(1e-300);  // recorded: now the joint must explain the motion
  EXPECT_GT(dumbbell.judge().dynamics.value, 0.01);
}

TEST(CertificateOfMergedBodies, BreakingTheWeldIsCaught) {
  Dumbbell dumbbell;
  dumbbell.after.bodies[1].orientation = dumbbell.after.bodies[1].orientation * about(Vec3::UnitX(), 1e-6);
  EXPECT_NEAR(dumbbell.judge().joint_error.value, 2e-6, 1e-9);
}

TEST(CertificateOfMergedBodies, ChangedTotalMomentumIsCaught) {
  Dumbbell dumbbell;
  for (BodyRecord& body : dumbbell.before.bodies) body.velocity.x() += 1e-6;
  EXPECT_GT(dumbbell.judge().dynamics.value, 9e-7);
  EXPECT_GT(dumbbell.judge().momentum.value, 9e-7);
}

TEST(CertificateOfTheStart, HalfKickHasHalfTheGravityAndHalfTheLoad) {
  physics::Mechanism mechanism;
  mechanism.time_step = 0.01;
  mechanism.start = physics::Start::half_kick;
  physics::Body ball;
  ball.name = "ball";
  ball.mass = 2;
  ball.inertia = physics::Mat3::Identity();
  mechanism.add(ball);
  physics::Load load;
  load.body = {0};
  load.force = {4, 0, 0};
  mechanism.add(load);
  const Vec3 v0(1, 2, 3), v1 = v0 + 0.005 * (mechanism.gravity + Vec3(2, 0, 0));
  const StepRecord before = record(0, 0.01, {{Vec3::Zero(), physics::Quat::Identity(), v0, Vec3::Zero()}});
  const StepRecord after = record(1, 0.01, {{0.01 * v1, physics::Quat::Identity(), v1, Vec3::Zero()}});
  EXPECT_LE(certify_step(mechanism, before, after).residual(), rounding);
  mechanism.start = physics::Start::standard;
  EXPECT_GT(certify_step(mechanism, before, after).dynamics.value, 0.01);
}

/// A sliding sphere of radius r: friction mu m g against the slip, torque r mu m g.
struct SlidingSphere {
  physics::Mechanism mechanism;
  StepRecord before, after;

  SlidingSphere() {
    const double dt = mechanism.time_step = 0.001, r = 0.1, mass = 1.5, moment = 0.4 * mass * r * r, mu = 0.2;
    mechanism.start = physics::Start::standard;
    physics::Body ball;
    ball.name = "ball";
    ball.mass = mass;
    ball.inertia = moment * physics::Mat3::Identity();
    mechanism.add(ball);
    physics::Contact contact;
    contact.name = "surface";
    contact.body = {0};
    contact.friction = mu;
    contact.radius = r;
    mechanism.add(contact);
    const double weight = mass * 9.81, v = 1 - dt * mu * 9.81;
    // c(w) J w = dt r mu m g, from rest
    const double p = dt * r * mu * weight / moment;
    double w = p;
    for (int i = 0; i < 10; ++i) w = p / std::sqrt(1 - dt * dt * w * w / 4);
    before = record(7, dt, {{{0, 0, r}, physics::Quat::Identity(), {1, 0, 0}, Vec3::Zero()}});
    after = record(8, dt, {{{dt * v, 0, r}, about(Vec3::UnitY(), dt * w / 2), {v, 0, 0}, {0, w, 0}}});
    after.contacts = {{0, weight, {-mu * weight, 0, 0}, {mu * weight, 0, 0, 0}, Vec3(-1, 0, 0)}};
  }
  [[nodiscard]] Certificate judge() const { return certify_step(mechanism, before, after); }
};

TEST(CertificateOfSpheres, FrictionActsAtTheLowestPoint) {
  EXPECT_LE(SlidingSphere().judge().residual(), rounding) << SlidingSphere().judge();
}

TEST(CertificateOfSpheres, HalvedFrictionTorqueIsCaught) {
  SlidingSphere sphere;
  BodyRecord& ball = sphere.after.bodies[0];
  ball.angular_velocity /= 2;
  ball.orientation = about(Vec3::UnitY(), sphere.mechanism.time_step / 2 * ball.angular_velocity.y());
  EXPECT_GT(sphere.judge().dynamics.value, 1e-4);
}

TEST(CertificateOfSpheres, TurnedBasisIsReportedAsAngleAndBarredAsPair) {
  SlidingSphere sphere;
  const double angle = 0.1, force = sphere.after.contacts[0].facet_forces[0];
  const Vec3 t1(-std::cos(angle), -std::sin(angle), 0);
  sphere.after.contacts[0].tangent = t1;
  sphere.after.contacts[0].friction_force = force * t1;
  const Certificate result = sphere.judge();
  EXPECT_NEAR(result.slip_angle.value, angle, 1e-9);
  EXPECT_GT(result.dynamics.value, 1e-5);
  EXPECT_LE(result.pyramid.value, rounding);
}

TEST(CertificateOfFlaggedSteps, OnlyJointsAndDistancesAreJudged) {
  SlidingSphere sphere;
  sphere.after.contacts[0].friction_force.x() *= 2;
  sphere.after.solver = physics::SolverRecord{.substeps = 2};
  EXPECT_EQ(sphere.judge().flagged, 1);
  EXPECT_LE(sphere.judge().residual(), rounding);
  sphere.after.bodies[0].position.z() -= 1e-9;
  EXPECT_NEAR(sphere.judge().penetration.value, 1e-6, 1e-9);
}

}  // namespace test_certificate_laws

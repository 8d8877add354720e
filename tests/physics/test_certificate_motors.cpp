// The certificate's law of motors, on steps solved by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "steps_by_hand.hpp"
#include "support/certificate.hpp"

namespace test_certificate_motors {

using by_hand::about;
using by_hand::record;
using by_hand::rounding;
using certificate::Certificate;
using certificate::certify_step;
using physics::StepRecord;
using physics::Vec3;

/// A wheel on a revolute joint through its centre, driven by a motor, no gravity: c' J w' = c J w + dt effort.
struct DrivenWheel {
  physics::Mechanism mechanism;
  StepRecord before, after;

  explicit DrivenWheel(double turns = 0) {
    const double dt = mechanism.time_step = 0.01, moment = 0.02, w = 3, w_next = 3.4;
    mechanism.gravity.setZero();
    mechanism.start = physics::Start::standard;
    physics::Body wheel;
    wheel.name = "wheel";
    wheel.mass = 2;
    wheel.inertia = Vec3(0.01, moment, 0.01).asDiagonal();
    mechanism.add(wheel);
    physics::Joint hub;
    hub.name = "hub";
    hub.type = physics::JointType::revolute;
    hub.child = {0};
    hub.axis = Vec3::UnitY();
    const double sine = std::sin(0.3), e = dt / 2 * w_next;
    before = record(4, dt, {{Vec3::Zero(), about(Vec3::UnitY(), sine), Vec3::Zero(), {0, w, 0}}});
    after = record(5, dt, {{Vec3::Zero(), before.bodies[0].orientation * about(Vec3::UnitY(), e), Vec3::Zero(),
                            {0, w_next, 0}}});
    const auto half_turn_cosine = [dt](double rate) { return std::sqrt(1 - dt * dt * rate * rate / 4); };
    const double effort = moment * (half_turn_cosine(w_next) * w_next - half_turn_cosine(w) * w) / dt;
    const double change = 2 * std::asin(e), angle = 0.6 + change + 2 * std::numbers::pi * turns;
    physics::Motor motor;
    motor.stiffness = 50;
    motor.damping = 0.7;
    motor.limit = 10;
    // A sine through the target that asks for just this effort.
    const double wanted = angle + (effort + motor.damping * change / dt) / motor.stiffness;
    motor.target = physics::SineTarget{wanted - 0.25, 0.5, 1 / (12 * after.time), 0};
    hub.motor = motor;
    mechanism.add(hub);
    after.joints.resize(1);
    after.joints[0].torque = {0, effort, 0};
    after.joints[0].effort = effort;
  }
  [[nodiscard]] Certificate judge() const { return certify_step(mechanism, before, after); }
};

TEST(CertificateOfMotors, EffortByTheImplicitLawPasses) {
  EXPECT_LE(DrivenWheel().judge().residual(), rounding) << DrivenWheel().judge();
}

TEST(CertificateOfMotors, FullTurnsDoNotMatter) { EXPECT_LE(DrivenWheel(3).judge().residual(), 1e-11); }

TEST(CertificateOfMotors, LawIsUsedWhenNoJointIsRecorded) {
  DrivenWheel wheel;
  wheel.after.joints.clear();
  EXPECT_LE(wheel.judge().residual(), rounding);
  std::get<physics::SineTarget>(wheel.mechanism.joints[0].motor->target).offset += 1e-3;
  EXPECT_GT(wheel.judge().dynamics.value, 1e-4);
}

TEST(CertificateOfMotors, EffortAgainstTheLawIsCaught) {
  DrivenWheel wheel;
  std::get<physics::SineTarget>(wheel.mechanism.joints[0].motor->target).offset += 1e-3;
  EXPECT_GT(wheel.judge().motor.value, 1e-4);
}

TEST(CertificateOfMotors, EffortBeyondTheLimitIsCaught) {
  DrivenWheel wheel;
  wheel.mechanism.joints[0].motor->limit = 0.99 * *wheel.after.joints[0].effort;
  EXPECT_GT(wheel.judge().motor.value, 1e-4);
}

TEST(CertificateOfMotors, TorqueThatIsNotTheEffortIsCaught) {
  DrivenWheel wheel;
  wheel.after.joints[0].torque.y() *= 1.001;
  EXPECT_GT(wheel.judge().wrench.value, 1e-6);
}

}  // namespace test_certificate_motors

#include "report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace cli {

using physics::RunSummary;
using physics::Vec3;

namespace {

std::string text(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z()); }

/// "1 body", "2 bodies".
std::string counted(long long count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

void line(std::string& out, const char* label, const std::string& value) {
  out += fmt::format("{:<22} {}\n", label, value);
}

std::string steps_text(const Report& report) {
  const RunSummary& s = report.result.summary;
  std::string text = fmt::format("{} of {} solved", s.steps, report.steps_wanted);
  for (const auto& [status, count] : s.statuses)
    if (status != graphsolve::Status::solved) text += fmt::format(", {} {}", count, graphsolve::name(status));
  if (report.result.stopped && s.steps < report.steps_wanted) text += report.signal ? ", stopped by request" : ", stopped";
  text += fmt::format("; {:.6g} s simulated in {:.3g} s", s.simulated_time, s.wall_time);
  if (s.wall_time > 0) text += fmt::format(" ({:.3g} times real time)", s.simulated_time / s.wall_time);
  return text;
}

/// Steps that took more than one attempt, and why.
std::string helped_text(const RunSummary& s) {
  std::vector<std::string> parts;
  if (s.substepped_steps) parts.push_back(fmt::format("{} with substeps", s.substepped_steps));
  if (s.restarted_steps) parts.push_back(fmt::format("{} restarted", s.restarted_steps));
  if (s.turned_steps) parts.push_back(fmt::format("{} with the new force direction", s.turned_steps));
  if (s.culling_repeats) parts.push_back(fmt::format("{} repeated for a culled contact", s.culling_repeats));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

std::vector<std::string> left_out(const physics::ProblemSize& size) {
  std::vector<std::string> parts;
  if (size.merged_bodies) parts.push_back(counted(size.merged_bodies, "body", "bodies") + ", merged by fixed joints");
  if (size.frictionless_contacts)
    parts.push_back("friction of " +
                    counted(size.frictionless_contacts, "frictionless contact", "frictionless contacts"));
  if (size.culled_contacts)
    parts.push_back(
        fmt::format("{:.3g} % of all contacts in all steps, out of reach",
                    100.0 * static_cast<double>(size.culled_contacts) / static_cast<double>(size.contact_steps)));
  if (size.newton_steps)
    parts.push_back("interior point in " + counted(size.newton_steps, "step", "steps") + " without contact");
  if (parts.empty()) parts.emplace_back("nothing");
  return parts;
}

std::string time_text(const RunSummary& s) {
  const double scale = 1e6 / std::max(1, s.steps);
  const physics::PhaseTimes& p = s.phases;
  return fmt::format("{:.3g} us: prepare {:.3g}, evaluate {:.3g}, factorize {:.3g}, solve {:.3g}, finish {:.3g}",
                     p.total() * scale, p.prepare * scale, p.evaluate * scale, p.factorize * scale, p.solve * scale,
                     p.finish * scale);
}

/// Does a contact of the scene begin inside its plane, by more than rounding?
bool starts_inside(const RunSummary& s) { return s.distance.step == 0 && s.distance.value < -physics::inside_a_plane; }

/// Nothing but motors and loads can add energy. The integrator does where bodies turn by a large part of a turn in a step.
std::string energy_text(const RunSummary& s, const physics::Mechanism& scene) {
  std::string out = fmt::format("{:.6g} J -> {:.6g} J (change {:.3g} J)", s.energy_start, s.energy_end,
                                s.energy_end - s.energy_start);
  const bool driven = !scene.loads.empty() || std::ranges::any_of(scene.joints, [](const auto& j) { return j.motor.has_value(); });
  const double g = scene.gravity.norm(), kick = g * scene.time_step;
  double mass = 0;
  for (const physics::Body& body : scene.bodies) mass += body.mass;
  // Half a kick at the start, and a fall of a millimetre, are no gain.
  const double noise = 0.01 * std::max(std::abs(s.energy_start), std::abs(s.energy_end)) + mass * (kick * kick + 1e-3 * g);
  if (!driven && s.energy_end - s.energy_start > noise)
    out += starts_inside(s) ? "; gained where the first step threw out what began inside a plane"
                            : "; gained without motor or load: bodies turn too far in a step, try a shorter time step";
  return out;
}

/// "'trunk' moved (0.75, 0.03, 0) m and turned 3.1 degrees"
std::string motion_text(const Motion& m) {
  return fmt::format("'{}' moved ({:.4g}, {:.4g}, {:.4g}) m and turned {:.4g} degrees", m.body, m.moved.x(), m.moved.y(), m.moved.z(),
                     m.turned * 180 / std::numbers::pi);
}

}  // namespace

std::optional<Motion> motion(const Report& report) {
  if (report.start.bodies.empty() || report.end.bodies.empty()) return std::nullopt;
  const physics::BodyRecord &start = report.start.bodies.front(), &end = report.end.bodies.front();
  // Quaternions go on without a jump: after a turn theirs has the other sign.
  const double cosine = start.orientation.coeffs().dot(end.orientation.coeffs());
  return Motion{report.mechanism.bodies.front().name, end.position - start.position,
                2 * std::atan2((start.orientation.conjugate() * end.orientation).vec().norm(), cosine)};
}

std::string for_people(const Report& report) {
  const RunSummary& s = report.result.summary;
  const physics::Mechanism& scene = report.mechanism;
  std::string out;
  line(out, "scene",
       fmt::format("{}: {}, {}, {}; time step {} s", report.scene, counted(std::ssize(scene.bodies), "body", "bodies"),
                   counted(std::ssize(scene.joints), "joint", "joints"),
                   counted(std::ssize(scene.contacts), "contact", "contacts"), scene.time_step));
  line(out, "steps", steps_text(report));
  line(out, "iterations per step",
       fmt::format("mean {:.3g}, max {}", static_cast<double>(s.iterations) / std::max(1, s.steps), s.most_iterations));
  line(out, "helped steps", helped_text(s));
  line(out, "largest residual",
       fmt::format("{:.3g} m/s, step {}{}", s.residual.value, s.residual.step,
                   s.residual.value > report.tolerance ? "; above the tolerance: rounding this far from the origin" : ""));
  if (std::isinf(s.distance.value) && !scene.contacts.empty())
    line(out, "smallest distance", "none: fixed joints hold all bodies with contacts at the world");
  else if (!scene.contacts.empty())
    line(out, "smallest distance", fmt::format("{:.3g} m, step {}{}", s.distance.value, s.distance.step,
         starts_inside(s) ? ": the scene begins inside a plane, which the first step has to undo" : ""));
  if (!scene.joints.empty())
    line(out, "largest joint error", fmt::format("{:.3g} m or rad, step {}", s.joint_error.value, s.joint_error.step));
  line(out, "energy", energy_text(s, scene));
  line(out, "momentum", fmt::format("{} -> {} N s", text(s.momentum_start), text(s.momentum_end)));
  line(out, "angular momentum",
       fmt::format("{} -> {} N m s", text(s.angular_momentum_start), text(s.angular_momentum_end)));
  if (const auto m = motion(report)) line(out, "first body", motion_text(*m));
  const char* label = "left out";
  for (const std::string& part : left_out(s.size)) line(out, std::exchange(label, ""), part);
  if (s.start_correction > report.tolerance)  // not what rounding leaves
    line(out, "start correction", fmt::format("{:.3g} m/s, to agree with the joints; {:.3g} J lost", s.start_correction, s.start_energy_loss));
  for (const std::string& sentence : s.redundancies) line(out, "redundant", sentence);
  line(out, "time per step", time_text(s));
  return out;
}

}  // namespace cli

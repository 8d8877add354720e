#include <cmath>
#include <nlohmann/json.hpp>

#include "report.hpp"

namespace cli {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const physics::Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// JSON has no infinity: null, for example the smallest distance without contacts.
Json to_json(const physics::Extreme& extreme) {
  if (!std::isfinite(extreme.value)) return nullptr;
  return {{"value", extreme.value}, {"step", extreme.step}};
}

Json to_json(const physics::PhaseTimes& p, int steps) {
  const double scale = 1e6 / std::max(1, steps);
  return {{"total", p.total() * scale},       {"prepare", p.prepare * scale}, {"evaluate", p.evaluate * scale},
          {"factorize", p.factorize * scale}, {"solve", p.solve * scale},     {"finish", p.finish * scale}};
}

Json to_json(const physics::ProblemSize& size) {
  return {{"body_nodes", size.body_nodes},
          {"joint_nodes", size.joint_nodes},
          {"rows", size.rows},
          {"islands", size.islands},
          {"operations", size.operations},
          {"fill_blocks", size.fill_blocks},
          {"stored_scalars", size.stored_scalars}};
}

Json left_out(const physics::ProblemSize& size) {
  return {{"merged_bodies", size.merged_bodies},
          {"frictionless_contacts", size.frictionless_contacts},
          {"culled_contact_steps", size.culled_contacts},
          {"contact_steps", size.contact_steps},
          {"steps_without_interior_point", size.newton_steps}};
}

Json outcome(const Report& report) {
  const physics::RunSummary& s = report.result.summary;
  Json statuses = Json::object();
  for (const auto& [status, count] : s.statuses) statuses[std::string(graphsolve::name(status))] = count;
  Json json{{"steps_wanted", report.steps_wanted},
            {"steps_solved", s.steps},
            {"first_step", s.first_step},
            {"statuses", statuses}};
  json["status"] = graphsolve::name(report.result.last.status);
  if (const auto& failure = report.result.failure) {
    json["failed_step"] = failure->step;
    json["place"] = failure->place;
    json["cause"] = failure->cause;
  }
  if (report.signal) json["stopped_by_signal"] = report.signal;
  return json;
}

}  // namespace

std::string as_json(const Report& report) {
  const physics::RunSummary& s = report.result.summary;
  const physics::Mechanism& scene = report.mechanism;
  Json json{{"format", "graphsolve-summary"},
            {"version", 1},
            {"program", "graphsolve " GRAPHSOLVE_VERSION},
            {"scene", report.scene},
            {"bodies", scene.bodies.size()},
            {"joints", scene.joints.size()},
            {"contacts", scene.contacts.size()},
            {"time_step_s", scene.time_step},
            {"tolerance_m_per_s", report.tolerance}};
  json.update(outcome(report));
  json["iterations"] = {{"mean", static_cast<double>(s.iterations) / std::max(1, s.steps)},
                        {"max", s.most_iterations},
                        {"sum", s.iterations}};
  json["helped_steps"] = {{"substeps", s.substepped_steps},
                          {"restarts", s.restarted_steps},
                          {"new_force_direction", s.turned_steps},
                          {"culling_repeats", s.culling_repeats}};
  json["largest_residual_m_per_s"] = to_json(s.residual);
  json["smallest_distance_m"] = to_json(s.distance);
  json["largest_joint_error"] = to_json(s.joint_error);
  json["energy_J"] = {{"start", s.energy_start}, {"end", s.energy_end}};
  json["momentum_N_s"] = {{"start", to_json(s.momentum_start)}, {"end", to_json(s.momentum_end)}};
  if (const auto m = motion(report))
    json["first_body"] = {{"name", m->body}, {"moved_m", to_json(m->moved)}, {"turned_rad", m->turned}};
  json["angular_momentum_N_m_s"] = {{"start", to_json(s.angular_momentum_start)},
                                    {"end", to_json(s.angular_momentum_end)}};
  json["problem"] = to_json(s.size);
  json["left_out"] = left_out(s.size);
  json["start_correction_m_per_s"] = s.start_correction;
  json["start_energy_loss_J"] = s.start_energy_loss;
  json["redundancies"] = s.redundancies;
  json["simulated_time_s"] = s.simulated_time;
  json["wall_time_s"] = s.wall_time;
  json["wall_time_per_step_us"] = to_json(s.phases, s.steps);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // names of files are bytes
}

}  // namespace cli

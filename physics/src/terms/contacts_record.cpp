#include <limits>
#include <type_traits>

#include "terms/contacts.hpp"

/// What contacts remember of a step, and what is recorded of it.
namespace physics {

void Contacts::clear(int lane) {
  each_entry(lane, [](Entry& entry) { entry.active = entry.loaded = false; });
}

void Contacts::save(std::span<const int> lanes) {
  four_.save();
  for (const int lane : lanes)
    each_entry(lane, [&](Entry& entry) {
      entry.saved_active = entry.active;
      double* saved = saved_.data() + entry.saved;
      if (entry.batch == Batch::none) {
        *saved = none_.law(entry.index).force();
      } else if (entry.batch == Batch::any) {
        const auto& law = any_.law(entry.index);
        Eigen::Map<Vec3>{saved} = any_.port(entry.index).tangent1();
        saved[3] = law.normal_impulse();
        for (int i = 0; i < law.facets(); ++i) saved[4 + i] = law.facet_impulse(i);
      }
    });
}

void Contacts::recall(int lane) {
  each_entry(lane, [&](Entry& entry) {
    entry.active = entry.saved_active;
    const double* saved = saved_.data() + entry.saved;
    switch (entry.batch) {
      case Batch::none: return none_.law(entry.index).set_force(*saved);
      case Batch::any: {
        auto& law = any_.law(entry.index);
        any_.port(entry.index).set_tangent(Eigen::Map<const Vec3>(saved));
        if (entry.active) law.set_impulses(saved[3], {saved + 4, static_cast<std::size_t>(law.facets())});
        return;
      }
      case Batch::four: break;
    }
    four_.port(entry.index).set_tangent(four_.port(entry.index).saved_tangent());
    PyramidLane law = four_.law(entry.index);
    double impulse[5];
    for (int k = 0; k < 5; ++k) impulse[k] = law.saved_impulse(k);
    if (entry.active) law.set_impulses(impulse[0], {impulse + 1, 4});
  });
}

void Contacts::load_record(int lane, std::span<const ContactRecord> records, double impulse_time) {
  each_entry(lane, [&](Entry& entry) {
    const ContactRecord& record = records[entry.source];
    visit(entry, [&](auto&& port, auto&& law) {
      entry.active = record.normal_force > 0;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        if (entry.aligned && record.tangent) port.set_tangent(*record.tangent);
        if (static_cast<int>(record.facet_forces.size()) != law.facets()) {
          entry.active = false;
          return;
        }
        facet_impulses_.assign(record.facet_forces.begin(), record.facet_forces.end());
        for (double& impulse : facet_impulses_) impulse *= impulse_time;
        law.set_impulses(record.normal_force * impulse_time, facet_impulses_);
      } else {
        law.set_force(record.normal_force * impulse_time);
      }
    });
  });
}

void Contacts::write_record(int lane, std::span<ContactRecord> records, double impulse_time) const {
  for (std::size_t i = 0; i < world_contacts_.size(); ++i) {
    records[world_contacts_[i]] = {};
    records[world_contacts_[i]].distance = world_distance_[lane * world_contacts_.size() + i];
  }
  each_entry(lane, [&](const Entry& entry) {
    ContactRecord& record = records[entry.source];
    visit(entry, [&](const auto& port, const auto& law) {
      const bool pressed = entry.active && impulse_time > 0;
      record.distance = port.distance(bodies_.pose_now(port.body()));
      record.normal_force = 0;
      record.friction_force.setZero();
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        record.facet_forces.assign(law.facets(), 0.0);
        if (entry.aligned) record.tangent = port.tangent1();
        if (!pressed) return;
        record.normal_force = law.normal_impulse() / impulse_time;
        double t[2];
        law.friction_impulse(t);
        record.friction_force = (t[0] * port.tangent1() + t[1] * port.tangent2()) / impulse_time;
        for (int i = 0; i < law.facets(); ++i) record.facet_forces[i] = law.facet_impulse(i) / impulse_time;
      } else if (pressed) {
        record.normal_force = law.force() / impulse_time;
      }
    });
  });
}

}  // namespace physics

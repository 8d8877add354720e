#pragma once

#include <array>
#include <vector>

#include "terms/contact_port.hpp"
#include "graphsolve/port_batch.hpp"
#include "terms/pyramid_impulses.hpp"
#include "terms/pyramid_law.hpp"
#include "simd/contact_kernels.hpp"

namespace physics {

/// The law of one of the contacts below, wherever its numbers lie. Cheap to copy, valid until contacts are added.
class PyramidLane : public PyramidImpulses<PyramidLane> {
 public:
  PyramidLane(ContactOctet& octet, int lane) : octet_(&octet), lane_(lane) {}

  /// island_mass, stiffness: as for PyramidLaw. Forgets all impulses.
  void describe(double friction, double island_mass, double stiffness, int facets);
  [[nodiscard]] static constexpr int facets() { return 4; }
  [[nodiscard]] double& z(int pair) const { return octet_->z[pair][lane_]; }
  [[nodiscard]] double friction() const { return octet_->friction[lane_]; }
  [[nodiscard]] double scale() const { return octet_->scale[lane_]; }
  [[nodiscard]] static const std::array<double, 2>& direction(int facet) { return cross_facets[facet]; }
  /// What PyramidContacts::save kept.
  [[nodiscard]] double saved_impulse(int pair) const { return octet_->saved_z[pair][lane_]; }
  /// The same as a law of its own.
  [[nodiscard]] PyramidLaw<4> copy() const;

 private:
  ContactOctet* octet_;
  int lane_;
};

/// The port of one of the contacts below, likewise.
class PyramidPort : public PlanePoint<PyramidPort> {
 public:
  static constexpr int rows = 3;
  /// displaced: of the octet, as in ContactTask
  PyramidPort(Bodies& bodies, int body, ContactOctet& octet, unsigned char& displaced, int lane)
      : bodies_(&bodies), body_(body), octet_(&octet), displaced_(&displaced), lane_(lane) {}

  void place(const Vec3& point, const Vec3& normal, double offset, double radius);
  [[nodiscard]] int body() const { return body_; }
  [[nodiscard]] Vec3 point() const { return at(octet_->point); }
  [[nodiscard]] Vec3 normal() const { return at(octet_->normal); }
  [[nodiscard]] Vec3 tangent1() const { return at(octet_->tangent[0]); }
  [[nodiscard]] Vec3 tangent2() const { return at(octet_->tangent[1]); }
  [[nodiscard]] double radius() const { return octet_->radius[lane_]; }
  [[nodiscard]] double plane_offset() const { return octet_->offset[lane_]; }
  void set_tangent(const Vec3& t1);
  void set_slip(SlipMeasure slip);
  [[nodiscard]] Vec3 saved_tangent() const { return at(octet_->saved_tangent); }
  /// As PyramidContacts::look found it.
  [[nodiscard]] Approach approach() const {
    const ContactOctet& o = *octet_;
    return {o.distance[lane_], o.approach[lane_], {o.slip[0][lane_], o.slip[1][lane_]}};
  }
  void prepare() { prepare(bodies_->pose_now(body_)); }
  void prepare(const Pose& pose);
  /// The same as a port of its own.
  [[nodiscard]] ContactPort<3> copy() const;

 private:
  [[nodiscard]] Vec3 at(const Octet* numbers) const {
    return {numbers[0][lane_], numbers[1][lane_], numbers[2][lane_]};
  }
  void set(Octet* numbers, const Vec3& v) const {
    for (int k = 0; k < 3; ++k) numbers[k][lane_] = v[k];
  }
  Bodies* bodies_;
  int body_;
  ContactOctet* octet_;
  unsigned char* displaced_;
  int lane_;
};

/// Contacts with four friction facets, eight at a time: ContactPort<3> with PyramidLaw<4>, computed by kernels for
/// packs. All numbers lie in octets: what a contact is, what a step needs, and the private unknowns of the laws.
class PyramidContacts final : public graphsolve::PortBatch {
 public:
  explicit PyramidContacts(Bodies& bodies) : bodies_(bodies) {}
  int add(int body);
  // Once they are wired.
  [[nodiscard]] PyramidPort port(int i) {
    const int octet = octet_of(place_[i]);
    return {bodies_, seats_[i].body, octets_[octet], displaced_[octet], lane_of(place_[i])};
  }
  [[nodiscard]] PyramidLane law(int i) { return {octets_[octet_of(place_[i])], lane_of(place_[i])}; }
  /// Before a step, of all contacts: distances and velocities at `now`. velocity: the unknowns (v, w) of the last step.
  void look(std::span<const double> velocity);
  /// Keeps impulses and tangents of all contacts.
  void save();

  [[nodiscard]] int size() const override { return static_cast<int>(seats_.size()); }
  [[nodiscard]] std::span<const graphsolve::NodeId> nodes(int i) const override { return {&seats_[i].node, 1}; }
  [[nodiscard]] int degree(int) const override { return ContactOctet::pairs; }
  [[nodiscard]] double scale(int i) const override { return octets_[octet_of(place_[i])].scale[lane_of(place_[i])]; }
  void wire(const graphsolve::Wiring& wiring) override;

  void remember(graphsolve::Instances instances, double factor) override;
  void restore(graphsolve::Instances instances) override;
  void start_warm(graphsolve::Instances instances, std::span<const double> x, std::span<const double> mu,
                  std::span<const double> scale) override;
  void start_cold(graphsolve::Instances instances, double velocity, std::span<const double> scale) override;
  void evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                std::span<const double> scale, std::span<double> error, std::span<double> product) override;
  void condense(graphsolve::Instances instances, std::span<const double> largest_ratio, double* values) override;
  void right_hand_side(graphsolve::Instances instances, std::span<const double> mu, std::span<const double> correction,
                       std::span<double> rhs) override;
  void recover(graphsolve::Instances instances, std::span<const double> dx, std::span<double> ratio) override;
  void complementarity(graphsolve::Instances instances, std::span<const double> alpha,
                       std::span<double> sum) const override;
  void accept(graphsolve::Instances instances, std::span<const double> alpha) override;
  void relax(graphsolve::Instances instances, double damping, std::span<double> change) override;

 private:
  template <class F>
  void each_octet(const graphsolve::Instances& instances, F&& f) const;
  void find_lane_places(const graphsolve::Wiring& wiring);
  void take(Octet& to, const ContactTask& task, int octet, std::span<const double> from) const;
  template <class F>
  void give(const ContactTask& task, int octet, F&& f) const;
  void give_largest(const ContactTask& task, int octet, const Octet& out, std::span<double> by_component) const;
  using When = Bodies::When;
  void point_at_poses(ContactTask& task, int octet, When when) const;
  /// At both, and at the velocities that lead from one to the other.
  void point_at_motion(ContactTask& task, int octet, std::span<const double> x) const;
  template <class T>
  void point_at_rows(T** to, int octet, T* x) const;
  void aim_at_next(std::span<const int> contacts);

  Bodies& bodies_;
  struct Seat {
    graphsolve::NodeId node;
    int body;
  };
  std::vector<Seat> seats_;
  // Contacts in octets, known once they are wired.
  std::vector<int> place_, contact_at_;
  struct LanePlaces {
    std::array<int, graphsolve::simd::lanes> row, component, body;  ///< of the body; its place
    unsigned used;      ///< lanes that have a contact
    bool side_by_side;  ///< eight components that follow each other
  };
  std::vector<LanePlaces> lane_places_;     ///< by octet
  bool in_order_ = false;  ///< contacts of a component lie in octets and lanes in their order
  std::vector<int> beside_;                 ///< by octet: that of its bodies, if they lie in the same lanes
  ContactKernels kernels_{};
  std::vector<char> one_body_;  ///< by octet: its contacts are on the same body
  std::vector<unsigned char> displaced_;  ///< by octet, as in ContactTask
  std::vector<graphsolve::simd::LaneBlocks> blocks_;  ///< by octet
  mutable std::vector<double> product_;               ///< by contact, to be summed up
  mutable std::vector<ContactOctet> octets_;
  mutable OctetGroups groups_;
};

}  // namespace physics

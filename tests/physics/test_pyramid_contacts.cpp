#include "terms/pyramid_contacts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "graphsolve/ordering.hpp"
#include "graphsolve/problem.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/symbolic.hpp"

namespace test_pyramid_contacts {

/// Contacts in packs against the same contacts one by one: ContactPort<3> with PyramidLaw<4>.

using namespace physics;
using graphsolve::NodeId;

/// Bodies in free flight with contacts in general position, once in packs and once one by one.
class PyramidContactsTest : public testing::TestWithParam<graphsolve::simd::InstructionSet> {
 protected:
  void SetUp() override {
    before_ = graphsolve::simd::instruction_set();
    graphsolve::simd::use_instruction_set(GetParam());
  }
  void TearDown() override { graphsolve::simd::use_instruction_set(before_); }

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

  /// Of both kinds, side by side in octets.
  static SlipMeasure slip(int contact) { return contact % 3 == 1 ? SlipMeasure::velocity : SlipMeasure::displacement; }

  void build(int bodies_count, int contacts) {
    bodies.dt = 0.05;
    for (int b = 0; b < bodies_count; ++b) {
      bodies.add({.name = "b", .mass = 1.3 + b, .inertia = Vec3(0.4, 0.7, 0.9).asDiagonal(), .smallest_inertia = 0.4}, {b});
      graph.add_node("b", 6);
      bodies.place(b, vector(1), Quat(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), 1).normalized());
    }
    std::vector<double> friction;
    for (int i = 0; i < contacts; ++i) {
      const Vec3 normal = vector(1).normalized();
      ContactPort<3> port(bodies, i * bodies_count / contacts, vector(0.5), normal, uniform(-1, 0), uniform(0, 0.2));
      port.set_tangent(normal.unitOrthogonal());
      port.set_slip(slip(i));
      port.prepare();
      packs.add(port.body());
      friction.push_back(uniform(0.1, 1.5));
      singles.add(port, PyramidLaw<4>(friction.back(), 2, 1e9));
    }
    symbolic = std::make_unique<graphsolve::Symbolic>(graph, graphsolve::natural_ordering(graph));
    const graphsolve::Wiring wiring(*symbolic, graph);
    bodies.wire(wiring);
    packs.wire(wiring);
    for (int i = 0; i < contacts; ++i) {
      const ContactPort<3>& port = singles.port(i);
      packs.port(i).place(port.point(), port.normal(), port.plane_offset(), port.radius());
      packs.port(i).set_tangent(port.tangent1());
      packs.port(i).set_slip(slip(i));
      packs.law(i).describe(friction[i], 2, 1e9, 4);
    }
    singles.wire(wiring);
    component.resize(contacts);
    for (int i = 0; i < contacts; ++i) component[i] = symbolic->component(packs.nodes(i).front());
    x.resize(symbolic->rows());
    for (double& value : x) value = uniform(-1, 1);
    std::vector<double> nothing(x.size());
    std::vector<int> all(bodies_count);
    for (int b = 0; b < bodies_count; ++b) all[b] = b;
    bodies.evaluate({all, all}, x, nothing, nullptr);
  }

  /// f(batch, out) on both; what comes out has to agree.
  template <class F>
  void expect_equal(const char* what, std::size_t size, F&& f) {
    std::vector<double> expected(size, 0.25), found(size, 0.25);
    f(singles, expected);
    f(packs, found);
    double largest = 1;
    for (const double value : expected) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(found[i], expected[i], 1e-11 * largest) << what << ", " << i;
  }

  void expect_laws_equal(const char* what) {
    for (int i = 0; i < packs.size(); ++i) {
      const PyramidLaw<4> expected = singles.law(i), found = packs.law(i).copy();
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(found.z(k), expected.z(k), 1e-11 * (1 + std::abs(expected.z(k)))) << what << ", contact " << i;
    }
  }

  /// One Newton step of the contacts in `running`, operation by operation.
  void expect_equal_steps(const std::vector<int>& running) {
    const graphsolve::Instances some{running, component};
    const std::size_t components = symbolic->components();
    const auto both = [&](auto&& f) { f(singles), f(packs); };
    const auto per_component = [&](double low, double high) {
      std::vector<double> v(components);
      for (double& value : v) value = uniform(low, high);
      return v;
    };
    const auto mu = per_component(0.1, 0.2), scale = per_component(1, 3), alpha = per_component(0.3, 0.9),
               ratio = per_component(5, 50), correction = per_component(0, 0.01);
    std::vector<double> dx(x.size());
    for (double& value : dx) value = uniform(-0.1, 0.1);

    both([&](auto& b) { b.start_cold({running, component}, 0.7, scale); });
    both([&](auto& b) { b.remember(some, 0.9); });
    both([&](auto& b) { b.start_warm(some, x, mu, scale); });
    expect_laws_equal("start_warm");
    const auto evaluate = [&](auto& b, std::vector<double>& out) {
      const std::span all(out);
      b.evaluate(some, x, all.first(x.size()), scale, all.subspan(x.size(), components), all.last(components));
    };
    expect_equal("evaluate", x.size() + 2 * components, evaluate);
    expect_equal("condense", static_cast<std::size_t>(symbolic->values_size()), [&](auto& b, auto& out) { b.condense(some, ratio, out.data()); });
    for (int k = 0; k < 2; ++k) {  // the second time with the products of the first
      expect_equal("right_hand_side", x.size(),
                   [&](auto& b, auto& out) { b.right_hand_side(some, mu, correction, out); });
      expect_equal("recover", components, [&](auto& b, auto& out) { b.recover(some, dx, out); });
      expect_equal("complementarity", components, [&](auto& b, auto& out) { b.complementarity(some, alpha, out); });
    }
    both([&](auto& b) { b.accept(some, alpha); });
    expect_laws_equal("accept");
    for (const double damping : {1.0, 0.5, 0.0}) {
      expect_equal("relax", components, [&](auto& b, auto& out) { b.relax(some, damping, out); });
      expect_equal("evaluate relaxed", x.size() + 2 * components, evaluate);
    }
    both([&](auto& b) { b.restore(some); });
    expect_laws_equal("restore");
  }

  std::mt19937_64 random{23};
  graphsolve::BlockGraph graph;
  Bodies bodies;
  PyramidContacts packs{bodies};
  graphsolve::PortLawBatch<ContactPort<3>, PyramidLaw<4>> singles;
  std::unique_ptr<graphsolve::Symbolic> symbolic;
  std::vector<int> component;
  std::vector<double> x;

 private:
  graphsolve::simd::InstructionSet before_{};
};

TEST_P(PyramidContactsTest, OfOneBodyDoWhatSingleOnesDo) {
  build(1, 13);
  std::vector<int> all(13);
  for (int i = 0; i < 13; ++i) all[i] = i;
  expect_equal_steps(all);
}

TEST_P(PyramidContactsTest, OfSeveralBodiesDoWhatSingleOnesDo) {
  build(6, 20);
  std::vector<int> all(20);
  for (int i = 0; i < 20; ++i) all[i] = i;
  expect_equal_steps(all);
}

TEST_P(PyramidContactsTest, ThatAreNotConcernedKeepWhatTheyHave) {
  build(6, 20);
  expect_equal_steps({1, 2, 3, 5, 8, 13, 19});
  expect_equal_steps({0, 4, 5, 6, 13, 14});
}

TEST_P(PyramidContactsTest, WithForcesAtTheNewConfigurationDoWhatSingleOnesDo) {
  build(3, 11);
  bodies.force_at_next = true;
  std::vector<int> all(11);
  for (int i = 0; i < 11; ++i) all[i] = i;
  expect_equal_steps(all);
}

/// Otherwise one attempt that ended in NaN would spoil all that follow it.
TEST_P(PyramidContactsTest, OfANewStartForgetAStepThatWasNoNumber) {
  build(1, 5);
  const std::vector<int> all{0, 1, 2, 3, 4};
  const graphsolve::Instances instances{all, component};
  const std::vector<double> mu{0.1}, scale{2}, ratio{1e9}, none{0}, nowhere(x.size(), std::nan(""));
  const auto start_again = [&](auto& batch) {
    std::vector<double> rhs(x.size()), residual(x.size()), values(static_cast<std::size_t>(symbolic->values_size()));
    std::vector<double> error(1), product(1), boundary(1);
    for (const auto& step : {nowhere, x}) {
      batch.start_cold(instances, 0.7, scale);
      batch.evaluate(instances, x, residual, scale, error, product);
      batch.condense(instances, ratio, values.data());
      std::fill(rhs.begin(), rhs.end(), 0.0);
      batch.right_hand_side(instances, mu, none, rhs);
      batch.recover(instances, step, boundary);
    }
    for (const double value : rhs) EXPECT_TRUE(std::isfinite(value));
  };
  start_again(packs);
  start_again(singles);
}

/// A step that is taken back from far away leaves nothing of what was small but its sign.
TEST_P(PyramidContactsTest, StayPositiveWhenAStepIsTakenBackFromFarAway) {
  build(1, 5);
  const std::vector<int> all{0, 1, 2, 3, 4};
  const graphsolve::Instances instances{all, component};
  const std::vector<double> mu{0.1}, scale{2}, ratio{1e9}, none{0}, forth{1}, back{-1};
  std::vector<double> dx(x.size());
  for (double& value : dx) value = uniform(-1e20, 1e20);
  const auto go_and_return = [&](auto& batch) {
    std::vector<double> rhs(x.size()), residual(x.size()), values(static_cast<std::size_t>(symbolic->values_size()));
    std::vector<double> error(1), product(1), boundary(1);
    batch.start_cold(instances, 0.7, scale);
    batch.evaluate(instances, x, residual, scale, error, product);
    batch.condense(instances, ratio, values.data());
    batch.right_hand_side(instances, mu, none, rhs);
    batch.recover(instances, dx, boundary);
    batch.accept(instances, forth);
    batch.accept(instances, back);
    std::vector<double> sum(1);
    batch.complementarity(instances, none, sum);
    EXPECT_GT(sum[0], 0);
    EXPECT_TRUE(std::isfinite(sum[0]));
  };
  go_and_return(packs);
  go_and_return(singles);
  for (int i = 0; i < packs.size(); ++i)
    for (int k = 0; k < 6; ++k) {
      EXPECT_GT(packs.law(i).copy().z(k), 0) << "contact " << i << ", pair " << k;
      EXPECT_GT(singles.law(i).z(k), 0) << "contact " << i << ", pair " << k;
    }
}

INSTANTIATE_TEST_SUITE_P(On, PyramidContactsTest, testing::ValuesIn(graphsolve::simd::instruction_sets()),
                         [](const auto& set) { return std::string(graphsolve::simd::name(set.param)); });

}  // namespace test_pyramid_contacts

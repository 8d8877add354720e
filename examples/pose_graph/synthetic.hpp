#pragma once

#include <fstream>
#include <random>
#include <stdexcept>

#include "spaces.hpp"

/// Small seeded graphs with known noise, written as .g2o files without a guess.
namespace pose_graph {

/// Standard normal numbers by Box and Muller: the same on every standard library.
class Noise {
 public:
  double operator()() {
    const auto uniform = [&] { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; };
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 random_{2020};
};

/// Writes true relative poses with noise of standard deviation `sigma` in every direction of the error.
template <class S>
class EdgeWriter {
 public:
  EdgeWriter(const std::string& path, std::vector<typename S::Pose> truth, double sigma)
      : file_(path), truth_(std::move(truth)), sigma_(sigma) {
    if (!file_) throw std::runtime_error(path + ": cannot be written");
    file_.precision(17);
  }
  void connect(int from, int to) {
    typename S::Vector d;
    for (double& entry : d) entry = sigma_ * noise_();
    if (S::size == 6) d.template tail<3>() *= 2;  // the error is half the rotation vector
    const auto exact = S::compose(S::inverse(truth_[from]), truth_[to]);
    file_ << S::edge_tag << ' ' << from << ' ' << to << ' ';
    S::write(file_, S::retract(exact, d));
    for (int i = 0; i < S::size; ++i)
      for (int j = i; j < S::size; ++j) file_ << ' ' << (i == j ? 1 / (sigma_ * sigma_) : 0.0);
    file_ << '\n';
  }

 private:
  std::ofstream file_;
  std::vector<typename S::Pose> truth_;
  double sigma_;
  Noise noise_;
};

/// 400 steps through a town of 9 x 9 crossings, with turns to the left or right at random; a pose is recognised from
/// the last two at the same crossing.
inline void write_town(const std::string& path) {
  std::mt19937 random(7);
  std::vector<Plane::Pose> truth(1);
  const auto inside = [](const Plane::Pose& p) { return p.t.cwiseAbs().maxCoeff() < 4.5; };
  while (truth.size() < 400) {
    const double turn = random() % 3 == 0 ? (random() % 2 ? 0.5 : -0.5) * std::numbers::pi : 0.0;
    const auto next = Plane::compose(truth.back(), {{1, 0}, turn});
    if (inside(Plane::compose(next, {{1, 0}, 0}))) truth.push_back(next);
  }
  EdgeWriter<Plane> writer(path, truth, 0.03);
  for (int k = 1; k < static_cast<int>(truth.size()); ++k) {
    writer.connect(k - 1, k);
    int met = 0;
    for (int j = k - 2; j >= 0 && met < 2; --j)
      if ((truth[j].t - truth[k].t).norm() < 0.5) writer.connect(j, k), ++met;
  }
}

/// 12 rounds of 20 poses on a sphere; each pose sees the one before and the one a round before.
inline void write_globe(const std::string& path) {
  constexpr int rounds = 12, round = 20;
  std::vector<Space::Pose> truth;
  for (int k = 0; k < rounds * round; ++k) {
    const double east = 2 * std::numbers::pi * k / round, north = std::numbers::pi * (0.1 + 0.8 * k / (rounds * round));
    Space::Pose p;
    p.q = Eigen::AngleAxisd(east, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(north, Eigen::Vector3d::UnitY());
    p.t = p.q * Eigen::Vector3d(0, 0, 10);
    truth.push_back(p);
  }
  EdgeWriter<Space> writer(path, truth, 0.05);
  for (int k = 1; k < rounds * round; ++k) {
    writer.connect(k - 1, k);
    if (k >= round) writer.connect(k - round, k);
  }
}

}  // namespace pose_graph

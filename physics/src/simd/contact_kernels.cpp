#include "simd/contact_kernels.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/contact_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/contact_rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
namespace {

void Look(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  Pack x[6];
  gs::load_transposed(task.x, 6, x, read(task));
  Matrix3 rotation;
  Vector3 position;
  read_pose(task, task.now, [&](auto&& number) HWY_ATTR {
    position = three(number, 0);
    rotation = nine(number, 7);
  });
  const Vector3 normal = load3(o.normal), arm = rotation * load3(o.point) - load(o.radius) * normal;
  const Vector3 u = vector(x) + cross(rotation * vector(x + 3), arm);
  store(dot(normal, position + arm) - load(o.offset), o.distance);
  store(dot(normal, u), o.approach);
  for (int t = 0; t < 2; ++t) store(dot(load3(o.tangent[t]), u), o.slip[t]);
}

void Remember(const ContactTask& task, double factor) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);
  Pack lever[3];
  Matrix3 rotation;
  read_pose(task, task.now, [&](auto&& number) HWY_ATTR { rotation = nine(number, 7); });
  const Vector3 local = transposed_times(rotation, load3(o.normal));
  const Vector3 arm = load3(o.point) - load(o.radius) * local;  // to the lowest point
  const auto keep_lever = [&](const Vector3& force, Octet* to) HWY_ATTR {
    put(cross(arm, force), lever);
    for (int k = 0; k < 3; ++k) keep(lever[k], to[k]);
  };
  keep_lever(local, o.lever[0]);
  for (int t = 0; t < 2; ++t) keep_lever(transposed_times(rotation, load3(o.tangent[t])), o.lever[t + 1]);
  for (int k = 0; k < pairs; ++k) {
    keep(load(o.s[k]), o.remembered_s[k]);
    keep(Pack(factor) * load(o.z[k]), o.remembered_z[k]);
  }
}

void Restore(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);
  for (int k = 0; k < pairs; ++k) {
    keep(load(o.remembered_s[k]), o.s[k]);
    keep(load(o.remembered_z[k]), o.z[k]);
  }
}

void StartWarm(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);
  const Pack mu = load(task.first), m = load(task.second), lighter = Pack(1.0) / m;
  const auto start = [&](int k, const Pack& predicted) HWY_ATTR {
    const Pack d = predicted - load(o.remembered_z[k]) * lighter;
    const Pack larger = Pack(0.5) * (gs::abs(d) + gs::sqrt(d * d + Pack(4.0) * mu * lighter));
    const Mask open = d >= Pack(0.0);
    const Pack major = gs::select(open, larger, m * larger), minor = mu / major;
    keep(gs::select(open, major, minor), o.s[k]);
    keep(gs::select(open, minor, major), o.z[k]);
  };
  const Rows u = measure(task);
  Pack psi(0.0);
  for (int i = 0; i < facets; ++i) psi = gs::max(psi, -along(u, i));
  start(0, u.n);
  for (int i = 0; i < facets; ++i) start(1 + i, along(u, i) + psi);
  start(bound, psi);
}

void StartCold(const ContactTask& task, double velocity) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);
  for (int k = 0; k < pairs; ++k) {
    keep(Pack(velocity), o.s[k]);
    keep(Pack(velocity) * load(task.second), o.z[k]);
  }
}

/// Largest product, and the natural error: what is left when psi is taken from the slip that is.
HWY_INLINE void judge(ContactTask& task, const Pack* s, const Pack* z, const Pack* residual) {
  const Pack lighter = Pack(1.0) / load(task.second);
  Pack slip[facets], psi(0.0);
  Largest largest, product;
  for (int i = 0; i < facets; ++i) {
    slip[i] = s[1 + i] + residual[1 + i] - s[bound];
    psi = gs::max(psi, -slip[i]);
  }
  const Pack off = gs::abs(residual[bound]) * lighter;
  for (int k = 0; k < pairs; ++k) {
    const Pack velocity = z[k] * lighter, slack = k == bound ? off : gs::abs(residual[k]);
    largest.take(slack, 0);
    if (k == bound) largest.take(gs::min(psi, velocity + off), 1);
    else largest.take(gs::min(k == 0 ? s[k] + slack : slip[k - 1] + psi, velocity), 1);
    product.take(s[k] * z[k], k % 2);
  }
  store(largest.value(), task.out);
  store(product.value(), task.also_out);
}

void Evaluate(ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Rows u = measure(task);
  Pack s[pairs], z[pairs], residual[pairs];
  for (int k = 0; k < pairs; ++k) s[k] = load(o.s[k]), z[k] = load(o.z[k]);
  residual[0] = u.n - s[0];
  for (int i = 0; i < facets; ++i) residual[1 + i] = along(u, i) + s[bound] - s[1 + i];
  const Pack most = gs::select(load(o.frozen) > Pack(0.5), load(o.frozen_bound), load(o.friction) * z[0]);
  residual[bound] = most - (z[1] + z[2] + z[3] + z[4]) - z[bound];
  for (int k = 0; k < pairs; ++k) store(residual[k], o.residual[k]);
  judge(task, s, z, residual);
  add_force(task, {z[0], z[1] - z[3], z[2] - z[4]}, -1.0);
}

void Condense(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Pack cap = gs::min(load(task.first), load(o.largest_ratio));
  Pack w[pairs];
  for (int k = 0; k < pairs; ++k) {
    const Pack s = load(o.s[k]), z = load(o.z[k]);
    const Pack inverse = Pack(1.0) / (s * z);  // one division
    store(inverse, o.inverse[k]);
    w[k] = gs::min(z * (z * inverse), cap);
    store(w[k], o.ratio[k]);
  }
  const Pack q = w[bound], p1 = w[1] + w[3], p2 = w[2] + w[4], one_over_sum = Pack(1.0) / (q + (p1 + p2));
  store(one_over_sum, o.one_over_sum);
  const Pack a1 = w[1] - w[3], a2 = w[2] - w[4], coupling = friction(o) * w[0] * one_over_sum;
  const Pack k10 = coupling * a1, k20 = coupling * a2;
  const Pack k11 = (p1 * (q + p2) + Pack(4.0) * w[1] * w[3]) * one_over_sum;
  const Pack k22 = (p2 * (q + p1) + Pack(4.0) * w[2] * w[4]) * one_over_sum;
  const Pack k12 = -(a1 * a2) * one_over_sum;

  // F^T K A column by column; rows of F: directions of force, of A: the same but for the arms.
  Pack force[3][6], rate[3][6], block[36];
  for (int c = 0; c < 3; ++c) {
    force[0][c] = rate[0][c] = load(o.normal[c]);
    force[0][c + 3] = load(o.lever[0][c]);
    rate[0][c + 3] = load(o.rate_normal[c]);
    for (int t = 0; t < 2; ++t) {
      force[t + 1][c] = rate[t + 1][c] = load(o.tangent[t][c]);
      force[t + 1][c + 3] = load(o.lever[t + 1][c]);
      rate[t + 1][c + 3] = load(o.rate_tangent[t][c]);
    }
  }
  for (int c = 0; c < 6; ++c) {
    const Pack f0 = w[0] * rate[0][c];
    const Pack f1 = k10 * rate[0][c] + k11 * rate[1][c] + k12 * rate[2][c];
    const Pack f2 = k20 * rate[0][c] + k12 * rate[1][c] + k22 * rate[2][c];
    for (int r = 0; r < 6; ++r) block[6 * c + r] = force[0][r] * f0 + force[1][r] * f1 + force[2][r] * f2;
  }
  gs::put_blocks(block, 36, task.values, *task.blocks, task.used, 1.0);
}

HWY_INLINE Pack inverse_s(const ContactOctet& o, int pair) { return load(o.z[pair]) * load(o.inverse[pair]); }
HWY_INLINE Pack inverse_z(const ContactOctet& o, int pair) { return load(o.s[pair]) * load(o.inverse[pair]); }

/// Of the row of a pair: its residual, and what its product lacks of mu, as a velocity.
HWY_INLINE Pack shift(const ContactOctet& o, int pair, const Pack& defect) {
  return load(o.residual[pair]) + defect * inverse_z(o, pair);
}

void RightHandSide(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Pack mu = load(task.first), correction = load(task.second);
  const Mask corrected = correction > Pack(0.0);
  Pack weighted[pairs];  // ratio times shift
  const auto defect = [&](int k) HWY_ATTR {
    // Without a correction the last step does not count, not even when it was no number.
    const Pack product = gs::select(corrected, correction * load(o.ds[k]) * load(o.dz[k]), Pack(0.0));
    const Pack d = load(o.s[k]) * load(o.z[k]) - mu + product;
    store(d, o.defect[k]);
    return d;
  };
  for (int k = 0; k < bound; ++k) {
    const Pack d = defect(k);
    weighted[k] = load(o.ratio[k]) * shift(o, k, d);
  }
  const Pack psi = (friction(o) * weighted[0] - (load(o.residual[bound]) + defect(bound) * inverse_s(o, bound)) -
                    (weighted[1] + weighted[2] + weighted[3] + weighted[4])) *
                   load(o.one_over_sum);
  store(psi, o.psi_shift);
  for (int i = 1; i <= facets; ++i) weighted[i] += load(o.ratio[i]) * psi;
  add_force(task, {-weighted[0], weighted[3] - weighted[1], weighted[4] - weighted[2]}, 1.0);
}

void Recover(ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);  // the next right-hand side reads these changes, and may be of other contacts
  Pack dx[6];
  gs::load_transposed(task.x, 6, dx, read(task));
  const Vector3 v = vector(dx), w = vector(dx + 3);
  Rows du = along_tangents(o, v, w);
  du.n = dot(load3(o.normal), v) + dot(load3(o.rate_normal), w);
  Pack psi = friction(o) * load(o.ratio[0]) * du.n;
  for (int i = 0; i < facets; ++i) psi -= load(o.ratio[1 + i]) * along(du, i);
  psi = load(o.psi_shift) + psi * load(o.one_over_sum);
  Largest ratio;
  const auto finish = [&](int k, const Pack& dz) HWY_ATTR {
    const Pack by_z = inverse_z(o, k), ds = -(load(o.defect[k]) + load(o.s[k]) * dz) * by_z;
    keep(dz, o.dz[k]);
    keep(ds, o.ds[k]);
    ratio.take(-dz * by_z, 0);
    ratio.take(-ds * inverse_s(o, k), 1);
  };
  const auto shifted = [&](int k) HWY_ATTR { return shift(o, k, load(o.defect[k])); };
  finish(0, -load(o.ratio[0]) * (du.n + shifted(0)));
  for (int i = 0; i < facets; ++i) finish(1 + i, -load(o.ratio[1 + i]) * (along(du, i) + psi + shifted(1 + i)));
  // As in the other pairs: the impulse from the condensed system, the velocity from the product.
  finish(bound, -load(o.defect[bound]) * inverse_s(o, bound) - load(o.ratio[bound]) * psi);
  store(ratio.value(), task.out);
}

void Complementarity(ContactTask& task) {
  const ContactOctet& o = *task.octet;
  const Pack alpha = load(task.first);
  Pack sum(0.0);
  for (int k = 0; k < pairs; ++k)
    sum += (load(o.s[k]) + alpha * load(o.ds[k])) * (load(o.z[k]) + alpha * load(o.dz[k]));
  store(sum, task.out);
}

/// As Pair::moved; of two numbers, one a NaN, max gives the second.
Pack moved(const Pack& value, const Pack& by) {
  return max(Pack(std::numeric_limits<double>::epsilon()) * abs(by), value + by);
}

void Accept(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  const Keeper keep(task.used);
  const Pack alpha = load(task.first);
  for (int k = 0; k < pairs; ++k) {
    keep(moved(load(o.s[k]), alpha * load(o.ds[k])), o.s[k]);
    keep(moved(load(o.z[k]), alpha * load(o.dz[k])), o.z[k]);
  }
}

ContactKernels Contacts() {
  return {.look = Look,
          .remember = Remember,
          .restore = Restore,
          .start_warm = StartWarm,
          .start_cold = StartCold,
          .evaluate = Evaluate,
          .condense = Condense,
          .right_hand_side = RightHandSide,
          .recover = Recover,
          .complementarity = Complementarity,
          .accept = Accept};
}

}  // namespace
}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(Contacts);

ContactKernels contact_kernels() {
  (void)graphsolve::simd::instruction_set();  // chosen now, if it was not yet
  return HWY_DYNAMIC_DISPATCH(Contacts)();
}

}  // namespace physics
#endif

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Least-squares adjustment of a pose and rejection of arrivals:
 * models/localizers/least_squares/node_adjustment.cc. */

/* Normal equations of the arrivals in use. */
typedef struct equations {
  real H[PACKED], g[DOF], cost;
} equations;

/* Scales of Cauchy's loss in sigmas; 0: squared loss. models/trajectory/trajectory.h: RobustLoss. */
typedef struct loss {
  real late, early;
} loss;

static const loss SQUARED = {0, 0};

static real loss_weight(loss l, real residual, real* cost) {
  const real scale = residual > 0 ? l.late : l.early, s2 = residual * residual, c2 = scale * scale;
  *cost += scale > 0 ? c2 * LOG1P(s2 / c2) / 2 : s2 / 2;
  return scale > 0 ? 1 / (1 + s2 / c2) : 1;
}

/* Sigma of an arrival by itself [s]. place_fix.h: receivers are anywhere about their centre. */
static real single_sigma_s(const octf_work* w, int r) {
  const real s = w->m.site->sigma_s;
  if (!w->m.centre) return s;
  return SQRT(s * s + w->m.site->receiver[r].centre_variance_m2 * square(w->m.site->legs / w->m.speed_mps));
}

/* Sigma with which an arrival is weighted [s]. common/correlated_arrivals.cc: weigh. */
static real weighting_sigma_s(const octf_work* w, int i) {
  const real single = single_sigma_s(w, w->arrivals[i].receiver);
  if (!(w->m.site->robust > 0)) return single;
  return SQRT(square(most(single, w->u.adjust.tail_s[i])) + w->m.site->correlated_s2 * w->u.adjust.shared[i]);
}

/* Counts the other arrivals in use of each arrival's pair. */
static void count_shared(octf_work* w) {
  int i, j;
  if (!(w->m.site->robust > 0)) return;
  for (i = 0; i < w->count; ++i) {
    const octf_arrival* a = &w->arrivals[i];
    int n = 0;
    for (j = 0; j < w->count; ++j) {
      const octf_arrival* b = &w->arrivals[j];
      n += j != i && b->status == OCTF_USED && b->beacon == a->beacon && b->receiver == a->receiver;
    }
    w->u.adjust.shared[i] = (uint8_t)(n < 255 ? n : 255);
  }
}

static real residual_s(const octf_work* w, const frame* T, int i, path* p) {
  predict(&w->m, T, w->arrivals[i].beacon, w->arrivals[i].receiver, p);
  return w->arrivals[i].tof_s - p->tof_s;
}

static void add_row(equations* eq, const path* p, real residual, real weight) {
  int i, j, k = 0;
  for (i = 0; i < DOF; ++i) {
    const real by = weight * p->by_pose[i];
    eq->g[i] += by * residual;
    for (j = 0; j <= i; ++j) eq->H[k++] += by * p->by_pose[j];
  }
}

static void set_equations(const octf_work* w, const octf_pose* T, loss l, equations* eq) {
  const frame f = frame_of(T);
  path p;
  int i;
  memset(eq, 0, sizeof *eq);
  for (i = 0; i < w->count; ++i) {
    real sigma, residual, weight;
    if (w->arrivals[i].status != OCTF_USED) continue;
    residual = residual_s(w, &f, i, &p);
    sigma = l.late > 0 ? single_sigma_s(w, w->arrivals[i].receiver) : weighting_sigma_s(w, i);
    weight = loss_weight(l, residual / sigma, &eq->cost) / (sigma * sigma);
    add_row(eq, &p, residual, weight);
  }
}

/* Levenberg-Marquardt iteration: adjust_node. Returns 1 if it converged. */
PHASE int adjust(const octf_work* w, octf_pose* T, loss l, int iterations, equations* eq) {
  real lambda = 0;
  int k, i, converged = 0;
  set_equations(w, T, l, eq);
  for (k = 0; k < iterations && !converged; ++k) {
    const octf_pose before = *T;
    equations next;
    real largest = 0, gain = 0, step[DOF], scale[DOF], drop;
    memcpy(next.H, eq->H, sizeof next.H);
    for (i = 0; i < DOF; ++i) {
      next.H[at(i, i)] = eq->H[at(i, i)] * (1 + lambda) + (i >= TURN ? VAGUE_ANGLE : 0);
      largest = most(largest, next.H[at(i, i)]);
      step[i] = eq->g[i];
    }
    for (i = 0; i < DOF; ++i) next.H[at(i, i)] += K(0.01) * TINY * (1 + largest);
    if (!factor(next.H, scale, DOF, 0)) break;
    solve(next.H, scale, DOF, step);
    for (i = 0; i < DOF; ++i) gain += eq->g[i] * step[i] / 2;
    if (!is_finite(gain)) break;
    retract(T, step);
    set_equations(w, T, l, &next);
    drop = eq->cost - next.cost;
    if (drop >= -TINY * (1 + eq->cost) && is_finite(next.cost)) {
      converged = gain * (1 + lambda) <= TINY * (1 + eq->cost);
      lambda = drop < gain / 4 ? most(4 * lambda, K(0.1)) : lambda < K(1e-6) ? 0 : lambda / 10;
      *eq = next;
    } else {
      *T = before;
      converged = gain <= 100 * TINY * (1 + eq->cost);
      lambda = most(10 * lambda, K(1e-3));
    }
  }
  return converged;
}

/* Marks the arrivals by their residuals: reject_arrivals. Returns 1 if any mark changed. */
PHASE int reject(octf_work* w, const octf_pose* T, real sigmas) {
  const frame f = frame_of(T);
  path p;
  int i, changed = 0;
  for (i = 0; i < w->count; ++i) {
    octf_arrival* a = &w->arrivals[i];
    const int was_used = a->status == OCTF_USED;
    real residual, gate2, noise;
    uint8_t status = OCTF_USED;
    if (a->status == OCTF_UNUSABLE) continue;
    residual = residual_s(w, &f, i, &p);
    noise = single_sigma_s(w, a->receiver);
    gate2 = square(was_used ? sigmas : K(0.85) * sigmas);
    if (!(residual * residual <= gate2 * (noise * noise + calibration_variance(&w->m, a->beacon, &p))))
      status = residual > 0 ? OCTF_LATE : OCTF_EARLY;
    changed |= was_used != (status == OCTF_USED);
    a->status = status;
  }
  return changed;
}

/* Gives large residuals less weight: widen_tails of common/correlated_arrivals.cc. */
PHASE int widen_tails(octf_work* w, const octf_pose* T) {
  const frame f = frame_of(T);
  path p;
  int i, changed = 0;
  if (!(w->m.site->robust > 0)) return 0;
  for (i = 0; i < w->count; ++i) {
    const real single = single_sigma_s(w, w->arrivals[i].receiver);
    real before, now;
    if (w->arrivals[i].status != OCTF_USED) continue;
    before = most(single, w->u.adjust.tail_s[i]);
    w->u.adjust.tail_s[i] = ABS(residual_s(w, &f, i, &p)) / 2;
    now = most(single, w->u.adjust.tail_s[i]);
    changed |= ABS(now - before) > before / 10;
  }
  return changed;
}

static int adjust_weighted(octf_work* w, octf_pose* T, equations* eq) {
  count_shared(w);
  return adjust(w, T, SQUARED, 100, eq);
}

/* Alternates adjustment and rejection: adjust_and_reject. Returns 1 if it converged. */
PHASE int adjust_and_reject(octf_work* w, octf_pose* T, equations* eq) {
  const real gate = K(4); /* EpochFixOptions::rejection_sigmas */
  int round, converged;
  memset(w->u.adjust.tail_s, 0, sizeof w->u.adjust.tail_s);
  reject(w, T, K(1.5) * gate);
  converged = adjust_weighted(w, T, eq);
  for (round = 0; round < 8 && reject(w, T, gate); ++round) converged = adjust_weighted(w, T, eq);
  for (round = 0; round < 10 && widen_tails(w, T); ++round) converged = adjust_weighted(w, T, eq);
  return converged;
}

static void reset_status(octf_work* w) {
  int i;
  for (i = 0; i < w->count; ++i)
    if (w->arrivals[i].status != OCTF_UNUSABLE) w->arrivals[i].status = OCTF_USED;
}

/* Numbers of arrivals and beacons: Count of epoch_fix.cc. */
typedef struct counts {
  int received, used, beacons, beacons_used, early;
} counts;

static counts count_arrivals(const octf_work* w) {
  counts c = {0, 0, 0, 0, 0};
  int g, k;
  for (g = 0; g < w->groups; ++g) {
    int used = 0;
    for (k = w->first[g]; k < w->first[g + 1]; ++k) {
      const uint8_t status = w->arrivals[w->order[k]].status;
      used += status == OCTF_USED;
      c.early += status == OCTF_EARLY;
    }
    c.received += w->first[g + 1] - w->first[g];
    c.used += used;
    ++c.beacons;
    c.beacons_used += used > 0;
  }
  return c;
}

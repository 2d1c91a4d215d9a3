/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Covariance of a fix with the calibration, protection level, and exclusion of faulty beacons. */

/* Covariance from an information matrix; 0 if a direction is unobserved. epoch_fix.cc: pose_covariance. */
static int invert(const real* information, real covariance[DOF][DOF]) {
  real A[PACKED], scale[DOF];
  int i, j;
  memcpy(A, information, sizeof A);
  for (i = TURN; i < DOF; ++i) A[at(i, i)] += VAGUE_ANGLE;
  if (!factor(A, scale, DOF, UNOBSERVED)) return 0;
  for (i = 0; i < DOF; ++i) {
    memset(covariance[i], 0, sizeof covariance[i]);
    covariance[i][i] = 1;
    solve(A, scale, DOF, covariance[i]);
  }
  for (i = 0; i < DOF; ++i)
    for (j = 0; j < DOF; ++j)
      if (!is_finite(covariance[i][j])) return 0;
  return 1;
}

#if OCTF_PARAMETERS > 0
/* Visits the parameters that an arrival depends on, whitened: for_each_coupling of common/calibration_part.h.
 * Adds weight times the derivatives to g (to_g), or returns the sum of derivatives times h. */
static real couple(const octf_site* site, const octf_arrival* a, const path* p, real weight, real* g,
                   const real* h) {
  const octf_beacon* b = &site->beacon[a->beacon];
  const octf_receiver* r = &site->receiver[a->receiver];
  int16_t columns[14];
  real by[14], sum = 0;
  int i, n = 10;
  for (i = 0; i < 3; ++i) {
    columns[i] = b->column[i];
    by[i] = p->by_beacon[i];
    columns[4 + i] = r->column[i];
    by[4 + i] = p->by_receiver[i];
  }
  columns[3] = b->column[3];
  columns[7] = r->column[3];
  columns[8] = site->delay_column;
  by[3] = by[7] = by[8] = 1;
  columns[9] = site->speed_column;
  by[9] = p->by_speed;
#if OCTF_ATTENUATION
  for (i = 0; i < 4; ++i, ++n) {
    columns[n] = site->attenuation_column[i];
    by[n] = p->by_attenuation[i];
  }
#endif
  for (i = 0; i < n; ++i) {
    if (columns[i] < 0) continue;
    if (g)
      g[columns[i]] += weight * by[i];
    else
      sum += by[i] * h[columns[i]];
  }
  return sum;
}

/* Adds P G C G' P for the covariance P and the coupling G = J' W J_theta of the arrivals in use, column by
 * column, which needs no more memory than two vectors of parameters. common/calibration_part.cc: add_to. */
PHASE void add_calibration(octf_work* w, const octf_pose* T, real P[DOF][DOF]) {
  const frame f = frame_of(T);
  real *g = w->u.adjust.g, *h = w->u.adjust.h, part[DOF][DOF], M[DOF];
  path p;
  int c, i, j, k;
  for (c = 0; c < DOF; ++c) {
    const real* C = w->m.site->covariance;
    memset(g, 0, sizeof w->u.adjust.g);
    memset(h, 0, sizeof w->u.adjust.h);
    memset(M, 0, sizeof M);
    for (k = 0; k < w->count; ++k) {
      real by = 0;
      if (w->arrivals[k].status != OCTF_USED) continue;
      predict(&w->m, &f, w->arrivals[k].beacon, w->arrivals[k].receiver, &p);
      for (i = 0; i < DOF; ++i) by += P[c][i] * p.by_pose[i];
      couple(w->m.site, &w->arrivals[k], &p, by / square(weighting_sigma_s(w, k)), g, h);
    }
    for (i = 0; i < OCTF_PARAMETERS; ++i) {
      for (j = 0; j < i; ++j, ++C) {
        h[i] += *C * g[j];
        h[j] += *C * g[i];
      }
      h[i] += *C++ * g[i];
    }
    for (k = 0; k < w->count; ++k) {
      real weight;
      if (w->arrivals[k].status != OCTF_USED) continue;
      predict(&w->m, &f, w->arrivals[k].beacon, w->arrivals[k].receiver, &p);
      weight = couple(w->m.site, &w->arrivals[k], &p, 0, 0, h) / square(weighting_sigma_s(w, k));
      for (i = 0; i < DOF; ++i) M[i] += weight * p.by_pose[i];
    }
    for (i = 0; i < DOF; ++i) {
      part[c][i] = 0;
      for (j = 0; j < DOF; ++j) part[c][i] += P[i][j] * M[j];
    }
  }
  for (i = 0; i < DOF; ++i) {
    if (part[i][i] < 0) return; /* rounding */
    for (j = 0; j < DOF; ++j) P[i][j] += (part[i][j] + part[j][i]) / 2;
  }
}
#endif

/* Larger eigenvalue of the horizontal part: horizontal_variance of common/separation.h. */
static real horizontal_variance(real P[DOF][DOF]) {
  const real mean = (P[0][0] + P[1][1]) / 2, half = (P[0][0] - P[1][1]) / 2;
  return mean + SQRT(half * half + P[0][1] * P[0][1]);
}

/* Quantile of chi-square at six sigmas: models/changes/chi_square.cc, chi2_gate. */
static real chi2_gate(int n) {
  const real v = K(2) / (K(9) * (real)n), q = 1 - v + 6 * SQRT(v);
  return (real)n * q * q * q;
}

/* Fix without one group of arrivals: BeaconSums::separation of common/separation.cc. */
typedef struct separation {
  int rows, determined;
  real shift_m, variance_m2, misfit;
} separation;

PHASE separation separate(octf_work* w, const frame* f, int group, const equations* all) {
  separation out = {0, 0, 0, 0, 0};
  equations of;
  real P[DOF][DOF], d[DOF], squares = 0, common = 0, shift[2] = {0, 0};
  path p;
  int i, j, k;
  memset(&of, 0, sizeof of);
  for (k = w->first[group]; k < w->first[group + 1]; ++k) {
    const octf_arrival* a = &w->arrivals[w->order[k]];
    real residual, weight;
    if (a->status != OCTF_USED) continue;
    residual = residual_s(w, f, w->order[k], &p);
    weight = 1 / square(weighting_sigma_s(w, w->order[k]));
    add_row(&of, &p, residual, weight);
    squares += weight * residual * residual;
    common += weight * (w->m.site->correlated_s2 + calibration_variance(&w->m, a->beacon, &p));
    ++out.rows;
  }
  if (out.rows == 0) return out;
  for (i = 0; i < PACKED; ++i) of.H[i] = all->H[i] - of.H[i];
  out.determined = invert(of.H, P);
  if (!out.determined) return out;
  out.variance_m2 = horizontal_variance(P);
  for (i = 0; i < DOF; ++i) {
    d[i] = 0;
    for (j = 0; j < DOF; ++j) {
      d[i] += P[i][j] * of.g[j];
      if (i < 2) shift[i] += P[i][j] * (of.g[j] - all->g[j]);
    }
    squares += of.g[i] * d[i];
  }
  out.shift_m = SQRT(shift[0] * shift[0] + shift[1] * shift[1]);
  out.misfit = squares / (1 + common);
  return out;
}

/* Horizontal variance of an information matrix; 0 if it is not determined. */
PHASE real noise_variance(const real* information) {
  real P[DOF][DOF];
  return invert(information, P) ? horizontal_variance(P) : 0;
}

/* Protection level, and the group at fault or -1: BeaconSums::protection. */
PHASE real protection(octf_work* w, const octf_pose* T, real P[DOF][DOF], int* at_fault, int* beacons) {
  const frame f = frame_of(T);
  const real variance = horizontal_variance(P);
  equations all;
  real widened, worst_m = 0, worst_misfit = 1;
  int g, all_determined = 1;
  *at_fault = -1;
  *beacons = 0;
  set_equations(w, T, SQUARED, &all);
  widened = noise_variance(all.H);
  if (!(widened > 0)) return 0;
  widened = most(1, variance / widened);
  for (g = 0; g < w->groups; ++g) {
    const separation s = separate(w, &f, g, &all);
    if (s.rows == 0) continue;
    ++*beacons;
    all_determined &= s.determined;
    if (!s.determined) continue;
    worst_m = most(worst_m, s.shift_m + K(3.899) * SQRT(widened * s.variance_m2));
    if (s.misfit / chi2_gate(s.rows) > worst_misfit) {
      worst_misfit = s.misfit / chi2_gate(s.rows);
      *at_fault = g;
    }
  }
  return all_determined ? most(K(4.941) * SQRT(variance), worst_m) : 0;
}

/* Covariance of an adjusted pose; 0 if it is not determined. */
PHASE int complete(octf_work* w, const equations* eq, octf_fix* fix) {
  if (!invert(eq->H, fix->covariance)) return 0;
#if OCTF_PARAMETERS > 0
  add_calibration(w, &fix->pose, fix->covariance);
#else
  (void)w;
#endif
  return 1;
}

static int set_status(octf_work* w, int group, uint8_t from, uint8_t to) {
  int g, k, any = 0;
  for (g = 0; g < w->groups; ++g)
    for (k = w->first[g]; k < w->first[g + 1] && (group < 0 || g == group); ++k)
      if (w->arrivals[w->order[k]].status == from) {
        w->arrivals[w->order[k]].status = to;
        any = 1;
      }
  return any;
}

/* Bounds the error under one fault and excludes beacons that contradict the others:
 * LeastSquaresLocalizer::protect. */
PHASE void protect(octf_work* w, octf_fix* fix) {
  equations eq;
  int excluded, at_fault, beacons, made = 1;
  for (excluded = 0; made; ++excluded) {
    fix->protection_level_m = protection(w, &fix->pose, fix->covariance, &at_fault, &beacons);
    if (at_fault < 0) return;
    if (excluded == 2 || beacons < 4) break;
    set_status(w, at_fault, OCTF_USED, OCTF_FAULTY);
    made = adjust_weighted(w, &fix->pose, &eq) && complete(w, &eq, fix);
    fix->cost = eq.cost;
  }
  if (set_status(w, -1, OCTF_FAULTY, OCTF_USED)) {
    made = adjust_weighted(w, &fix->pose, &eq) && complete(w, &eq, fix);
    fix->cost = eq.cost;
    if (!made) fix->status = OCTF_NO_CONSENSUS;
  }
  fix->protection_level_m = 0;
}

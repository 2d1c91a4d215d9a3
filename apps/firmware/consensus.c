/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Score of a planar pose under a mixture of direct and late arrivals:
 * models/localizers/least_squares/consensus.cc. */
#if !OCTF_SPATIAL

static const real LN20 = K(2.995732273553991);
enum { NO_GROUP = -1 };

static real late_cap(real cap) { return most(2, cap); }
static real early_cap(real cap) { return most(4, cap + LN20); }
static real cap_of(real residual, real cap) { return residual > 0 ? late_cap(cap) : early_cap(cap); }

/* Sets the variances for a possible error of a candidate: set_extra_sigma. */
static void set_extra_sigma(octf_work* w, real extra_m) {
  const real sigma_m = w->m.site->sigma_s * w->m.speed_mps / w->m.site->legs;
  int g;
  for (g = 0; g < w->groups; ++g) {
    const octf_arrival* a = &w->arrivals[w->order[w->first[g]]];
    const octf_real* C = w->m.site->beacon[a->beacon].covariance;
    const int n = w->first[g + 1] - w->first[g];
    const real range_m = w->u.search.range_m[w->first[g]];
    const real bias2 = most(0, (C[0] + C[5] + C[9]) / 3 + square(w->m.speed_mps) * C[12] +
                                   square(range_m / w->m.speed_mps) * C[14]);
    real variance = sigma_m * sigma_m + extra_m * extra_m + (n == 1 ? bias2 : 0);
    w->u.search.weight[g] = 1 / variance;
    w->u.search.bias2[g] = n == 1 || bias2 < K(0.01) * sigma_m * sigma_m ? 0 : bias2;
    w->u.search.cap[g] = LOG(K(1.4) * w->span_m) - LOG(variance) / 2;
    variance = w->u.search.bias2[g] + variance / (real)n;
    w->u.search.group_cap[g] = LOG(K(1.4) * w->span_m) - LOG(variance) / 2;
  }
}

/* Direction and lever arm of an arrival of the search at a state. */
typedef struct ray {
  real dx, dy, arm_x, arm_y, distance_m;
} ray;

static ray ray_of(const octf_work* w, const octf_state* s, real cosine, real sine, int k) {
  const octf_arrival* a = &w->arrivals[w->order[k]];
  const octf_real *o = w->m.site->receiver[a->receiver].p_m, *b = w->m.site->beacon[a->beacon].p_m;
  ray r;
  r.arm_x = cosine * o[0] - sine * o[1];
  r.arm_y = sine * o[0] + cosine * o[1];
  r.dx = s->x_m + r.arm_x - b[0];
  r.dy = s->y_m + r.arm_y - b[1];
  r.distance_m = SQRT(r.dx * r.dx + r.dy * r.dy + square(o[2] - b[2]));
  return r;
}

static void set_residuals(octf_work* w, const octf_state* s, real cosine, real sine, int g) {
  int k;
  for (k = w->first[g]; k < w->first[g + 1]; ++k)
    w->u.search.residual_m[k] = w->u.search.range_m[k] - ray_of(w, s, cosine, sine, k).distance_m;
}

/* Cost of a direct arrival at a receiver that faces away: share_behind_cost and set_residuals. */
static real behind_cost(const octf_work* w, const octf_state* s, real cosine, real sine, int g, int k) {
#if OCTF_AXES
  const octf_receiver* r = &w->m.site->receiver[w->arrivals[w->order[k]].receiver];
  const real flat = SQRT(r->axis[0] * r->axis[0] + r->axis[1] * r->axis[1]);
  real toward;
  ray v;
  int j, pings = 0;
  if (!(flat > K(0.1))) return 0;
  v = ray_of(w, s, cosine, sine, k);
  toward =
      -(v.dx * (cosine * r->axis[0] - sine * r->axis[1]) + v.dy * (sine * r->axis[0] + cosine * r->axis[1])) /
      flat;
  if (!(toward * ABS(toward) < r->hearing2 * (v.dx * v.dx + v.dy * v.dy))) return 0;
  for (j = w->first[g]; j < w->first[g + 1]; ++j)
    pings += w->arrivals[w->order[j]].receiver == w->arrivals[w->order[k]].receiver;
  return 4 / (real)pings;
#else
  (void)w, (void)s, (void)cosine, (void)sine, (void)g, (void)k;
  return 0;
#endif
}

/* Median residual of a group, the lower one of two. */
static real middle_residual(const octf_work* w, int g) {
  const int first = w->first[g], last = w->first[g + 1];
  const octf_real* r = w->u.search.residual_m;
  int i, j;
  for (i = first; i < last; ++i) {
    int below = 0, equal = 0;
    for (j = first; j < last; ++j) {
      below += r[j] < r[i];
      equal += j < i && r[j] == r[i];
    }
    if (below + equal == (last - first - 1) / 2) return r[i];
  }
  return r[first];
}

/* Cost of a beacon at the residuals, and whether it is received directly: group_cost, divided_group_cost. */
static real group_cost(const octf_work* w, const octf_state* s, real cosine, real sine, int g, int* direct) {
  const int first = w->first[g], last = w->first[g + 1];
  const real weight = w->u.search.weight[g], cap = w->u.search.cap[g], bias2 = w->u.search.bias2[g];
  real plain = 0, S0 = 0, S1 = 0, S2 = 0, behind = 0, bias, among = 0, among_behind = 0, shadowed;
  int k;
  *direct = 1;
  for (k = first; k < last; ++k) {
    const real r = w->u.search.residual_m[k], cost = r * r * weight / 2;
    const real back = behind_cost(w, s, cosine, sine, g, k);
    plain += least(cost + back, cap_of(r, cap));
    S0 += weight;
    S1 += weight * r;
    S2 += cost;
    behind += back;
  }
  if (last - first < 2) return plain;
  if (bias2 > 0) plain = S2 - S1 * S1 / (1 / bias2 + S0) / 2 + behind;
  if (plain <= late_cap(w->u.search.group_cap[g])) return plain;
  bias = middle_residual(w, g);
  for (k = first; k < last; ++k) {
    const real r = w->u.search.residual_m[k] - bias, cost = r * r * weight / 2;
    among += least(cost, cap_of(r, cap));
    among_behind += least(cost + behind_cost(w, s, cosine, sine, g, k), cap_of(r, cap));
  }
  if (bias2 > 0) plain = bias * bias / (bias2 + 1 / S0) / 2 + among_behind;
  if (bias <= 0 && !(bias2 > 0)) return plain;
  shadowed = cap_of(bias, w->u.search.group_cap[g]) + among;
  *direct = plain <= shadowed;
  return least(plain, shadowed);
}

static real score_of(octf_work* w, const octf_state* s, real give_up) {
  const real cosine = COS(s->heading_rad), sine = SIN(s->heading_rad);
  real total = 0;
  int g, direct;
  for (g = 0; g < w->groups && !(total > give_up); ++g) {
    set_residuals(w, s, cosine, sine, g);
    total += group_cost(w, s, cosine, sine, g, &direct);
  }
  return total;
}

/* Adds the normal equations of a group, with its bias eliminated: add_group. Returns its cost. */
static real add_group(octf_work* w, const octf_state* s, real cosine, real sine, int g, real* H, real* step) {
  const real weight = w->u.search.weight[g], bias2 = w->u.search.bias2[g];
  real coupling[3] = {0, 0, 0}, bias_information = bias2 > 0 ? 1 / bias2 : 1, bias_gradient = 0, centre, cost;
  int i, j, k, direct;
  set_residuals(w, s, cosine, sine, g);
  cost = group_cost(w, s, cosine, sine, g, &direct);
  if (!direct) return cost;
  centre = bias2 > 0 ? middle_residual(w, g) : 0;
  for (k = w->first[g]; k < w->first[g + 1]; ++k) {
    const ray r = ray_of(w, s, cosine, sine, k);
    const real d = most(r.distance_m, K(1e-6)), residual = w->u.search.residual_m[k], off = residual - centre;
    const real row[3] = {r.dx / d, r.dy / d, (r.dy * r.arm_x - r.dx * r.arm_y) / d};
    const real v = weight / (1 + off * off * weight * (off > 0 ? K(0.16) : K(0.08163265306122449)));
    for (i = 0; i < 3; ++i) {
      step[i] += v * row[i] * residual;
      for (j = 0; j <= i; ++j) H[at(i, j)] += v * row[i] * row[j];
      coupling[i] += v * row[i];
    }
    bias_information += v;
    bias_gradient += v * residual;
  }
  if (!(bias2 > 0)) return cost;
  for (i = 0; i < 3; ++i) {
    step[i] -= coupling[i] * bias_gradient / bias_information;
    for (j = 0; j <= i; ++j) H[at(i, j)] -= coupling[i] * coupling[j] / bias_information;
  }
  return cost;
}

/* Gauss-Newton iteration with one-sided Cauchy weights: Consensus::refine. */
static void refine(octf_work* w, octf_state* s, real extra_m, int iterations, int without, real* H) {
  const real median = w->m.site->sigma_s * w->m.speed_mps / w->m.site->legs,
             lever = most(w->lever_m, K(1e-3));
  const real least_m = most(K(0.01) * median, K(0.1) * extra_m),
             least_rad = most(K(1e-4), K(0.1) * extra_m / lever);
  const real longest_turn = least(K(0.6), SQRT(6 * SQRT(median * median + extra_m * extra_m) / lever));
  octf_state before = *s;
  real before_cost = 0;
  int k, g, any = 0;
  for (k = 0; k < iterations; ++k) {
    const real cosine = COS(s->heading_rad), sine = SIN(s->heading_rad);
    real A[6], scale[3], step[3] = {0, 0, 0}, cost = 0, length, longest;
    memset(H, 0, 6 * sizeof *H);
    for (g = 0; g < w->groups; ++g)
      if (g != without) cost += add_group(w, s, cosine, sine, g, H, step);
    if (any && cost > before_cost + 1) {
      s->x_m = (s->x_m + before.x_m) / 2;
      s->y_m = (s->y_m + before.y_m) / 2;
      s->heading_rad = wrap(before.heading_rad + wrap(s->heading_rad - before.heading_rad) / 2);
      continue;
    }
    any = 1;
    before = *s;
    before_cost = cost;
    memcpy(A, H, sizeof A);
    A[0] += 1 / square(w->span_m);
    A[2] += 1 / square(w->span_m);
    A[5] += VAGUE_ANGLE;
    if (!factor(A, scale, 3, 0)) return;
    solve(A, scale, 3, step);
    length = SQRT(step[0] * step[0] + step[1] * step[1]);
    longest = most(most(length / (K(0.3) * w->span_m), ABS(step[2]) / longest_turn), 1);
    if (!is_finite(longest)) return;
    s->x_m += step[0] / longest;
    s->y_m += step[1] / longest;
    s->heading_rad = wrap(s->heading_rad + step[2] / longest);
    if (length / longest < least_m && ABS(step[2]) / longest < least_rad) return;
  }
}
#endif

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Iterated extended Kalman filter of a drive: models/localizers/drive/drive_belief.cc with a known speed and
 * with a calibration that widens the gate. */

int octf_filter_start(octf_filter* filter, const octf_fix* fix) {
  if (fix->status != OCTF_OK || fix->covariance[DOF - 1][DOF - 1] > 1) return 0;
  memset(filter, 0, sizeof *filter);
  filter->pose = fix->pose;
  memcpy(filter->covariance, fix->covariance, sizeof filter->covariance);
  filter->acceptance = 1;
  return 1;
}

/* models/physics/pose.cc: log_rotation */
static void log_rotation(const real* q, real* phi) {
  const real n = norm(q), sign = q[3] < 0 ? -1 : 1;
  const real scale = n < K(1e-6) ? 2 * sign : 2 * ATAN2(n, sign * q[3]) * sign / n;
  int i;
  for (i = 0; i < 3; ++i) phi[i] = scale * q[i];
}

/* Moves a pose by a pose in its frame. */
static octf_pose composed(const octf_pose* T, const octf_pose* step) {
  const frame f = frame_of(T);
  octf_pose out;
  int i;
  rotate(f.R, step->p_m, out.p_m);
  for (i = 0; i < 3; ++i) out.p_m[i] += T->p_m[i];
  multiply(T->q, step->q, out.q);
  return out;
}

/* Derivative of the pose after a step by the pose before it: models/physics/pose_step.h, by_step. */
static void by_step(const octf_pose* T, const octf_pose* step, real F[DOF][DOF]) {
  const frame f = frame_of(T);
  int i;
  memset(F, 0, (size_t)(DOF * DOF) * sizeof(real));
  for (i = 0; i < DOF; ++i) F[i][i] = 1;
#if OCTF_SPATIAL
  {
    const frame s = frame_of(step);
    int j;
    for (j = 0; j < 3; ++j) {
      real e[3] = {0, 0, 0}, column[3], turned[3];
      e[j] = 1;
      cross(e, step->p_m, column); /* -[s]x e = e x s */
      rotate(f.R, column, turned);
      for (i = 0; i < 3; ++i) {
        F[i][3 + j] = turned[i];
        F[3 + i][3 + j] = s.R[3 * j + i];
      }
    }
  }
#else
  {
    real moved[3];
    rotate(f.R, step->p_m, moved);
    F[0][2] = -moved[1];
    F[1][2] = moved[0];
  }
#endif
}

void octf_filter_move(octf_filter* filter, const octf_pose* step, octf_real span_s,
                      const octf_odometry* noise) {
  real F[DOF][DOF], FP[DOF][DOF], turn[3], d, a, place2, turn2;
  int i, j, k;
  log_rotation(step->q, turn);
  d = norm(step->p_m);
  a = norm(turn);
  if (!is_finite(d + a)) return;
  place2 = square(noise->distance_sigma_m_per_sqrt_m) * d + square(noise->floor_m);
  turn2 = square(noise->heading_sigma_rad_per_sqrt_m) * d + square(noise->heading_sigma_per_rad * a) +
          square(noise->floor_rad);
  by_step(&filter->pose, step, F);
  for (i = 0; i < DOF; ++i)
    for (j = 0; j < DOF; ++j) {
      FP[i][j] = 0;
      for (k = 0; k < DOF; ++k) FP[i][j] += F[i][k] * filter->covariance[k][j];
    }
  for (i = 0; i < DOF; ++i)
    for (j = 0; j < DOF; ++j) {
      filter->covariance[i][j] = 0;
      for (k = 0; k < DOF; ++k) filter->covariance[i][j] += FP[i][k] * F[j][k];
    }
  for (i = 0; i < DOF; ++i) filter->covariance[i][i] += i < TURN ? place2 : turn2;
  filter->pose = composed(&filter->pose, step);
  if (!(span_s > 0)) return;
  for (i = 0; i < 3; ++i) {
    filter->velocity[i] = step->p_m[i] / span_s;
    filter->velocity[3 + i] = turn[i] / span_s;
  }
}

/* Mean square of the second-order term of an arrival's time: curvature_variance_s2. */
static real curvature_variance(const octf_filter* filter, const octf_site* site, int receiver,
                               const path* p) {
  enum { PLACES = OCTF_SPATIAL ? 3 : 2 };
  const real slope = norm(p->by_beacon);
  real across[PLACES][PLACES], trace = 0, square_trace = 0, turned = 0;
  int i, j, k;
  for (i = 0; i < PLACES; ++i)
    for (j = 0; j < PLACES; ++j) {
      real along = 0;
      for (k = 0; k < PLACES; ++k) along += p->by_pose[k] * filter->covariance[k][j];
      across[i][j] = (filter->covariance[i][j] - p->by_pose[i] * along / (slope * slope)) / p->distance_m;
    }
  for (i = 0; i < PLACES; ++i) {
    trace += across[i][i];
    for (j = 0; j < PLACES; ++j) square_trace += across[i][j] * across[j][i];
  }
  for (i = TURN; i < DOF; ++i) turned += filter->covariance[i][i];
  turned *= norm(site->receiver[receiver].p_m);
  return slope * slope * (trace * trace + 2 * square_trace + 3 * turned * turned) / 4;
}

int octf_filter_update(octf_filter* filter, const octf_site* site, octf_arrival* a, octf_real speed_mps) {
  const real gate2 = 16; /* four sigmas, as of the epoch fix */
  octf_pose T = filter->pose;
  real moved[DOF], gain[DOF], PH[DOF], S = 1, noise2 = 0;
  path p;
  octf_model m;
  int round, i, j;
  m.site = site;
  m.speed_mps = speed_mps;
  m.centre = 0;
  a->status = OCTF_UNUSABLE;
  if (a->beacon >= OCTF_BEACONS || a->receiver >= OCTF_RECEIVERS || !site->beacon[a->beacon].usable ||
      !(a->tof_s > 0 && a->tof_s < 1000) || !(speed_mps > 0))
    return 0;
  memset(moved, 0, sizeof moved);
  for (round = 0; round < 3; ++round) {
    const frame f = frame_of(&T);
    real innovation;
    predict(&m, &f, a->beacon, a->receiver, &p);
    innovation = a->tof_s - p.tof_s;
    S = 0;
    for (i = 0; i < DOF; ++i) {
      innovation += p.by_pose[i] * moved[i];
      PH[i] = 0;
      for (j = 0; j < DOF; ++j) PH[i] += filter->covariance[i][j] * p.by_pose[j];
      S += p.by_pose[i] * PH[i];
    }
    if (round == 0) {
      noise2 = square(site->sigma_s) + curvature_variance(filter, site, a->receiver, &p);
      if (!(innovation * innovation <= gate2 * (S + noise2 + calibration_variance(&m, a->beacon, &p)))) {
        a->status = innovation > 0 ? OCTF_LATE : OCTF_EARLY;
        filter->acceptance -= filter->acceptance / 30;
        return 0;
      }
    }
    S += noise2;
    for (i = 0; i < DOF; ++i) {
      gain[i] = PH[i] / S;
      moved[i] = gain[i] * innovation;
    }
    T = filter->pose;
    retract(&T, moved);
  }
  filter->pose = T;
  for (i = 0; i < DOF; ++i)
    for (j = 0; j <= i; ++j) {
      filter->covariance[i][j] += S * gain[i] * gain[j] - gain[i] * PH[j] - PH[i] * gain[j];
      filter->covariance[j][i] = filter->covariance[i][j];
    }
  filter->acceptance += (1 - filter->acceptance) / 30;
  a->status = OCTF_USED;
  return 1;
}

octf_pose octf_filter_predict(const octf_filter* filter, octf_real span_s) {
  octf_pose step;
  real turn[3];
  int i;
  for (i = 0; i < 3; ++i) {
    step.p_m[i] = filter->velocity[i] * span_s;
    turn[i] = filter->velocity[3 + i] * span_s;
  }
  exp_rotation(turn, step.q);
  return composed(&filter->pose, &step);
}

int octf_filter_is_lost(const octf_filter* filter) { return filter->acceptance < K(0.35); }

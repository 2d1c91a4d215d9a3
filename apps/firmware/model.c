/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Rotations, small linear systems, and the measurement equation. */
#include <math.h>
#include <string.h>

#include "octant_fix.h"

typedef octf_real real;

#define K(x) ((real)(x)) /* a constant in the chosen precision */
#ifdef OCTF_FLOAT
#define SQRT sqrtf
#define ABS fabsf
#define LOG logf
#define LOG1P log1pf
#define EXP expf
#define SIN sinf
#define COS cosf
#define ATAN2 atan2f
#define TINY K(1e-6) /* relative rounding error of a cost */
#define UNOBSERVED K(1e-6)
#else
#define SQRT sqrt
#define ABS fabs
#define LOG log
#define LOG1P log1p
#define EXP exp
#define SIN sin
#define COS cos
#define ATAN2 atan2
#define TINY K(1e-10)
#define UNOBSERVED K(1e-10)
#endif

/* Phases follow one another, so their locals need not be on the stack together, as inlining makes them. */
#if defined(__GNUC__)
#define PHASE static __attribute__((noinline))
#else
#define PHASE static
#endif

enum { DOF = OCTF_DOF, PACKED = DOF * (DOF + 1) / 2, TURN = OCTF_SPATIAL ? 3 : 2 };

static const real PI = K(3.14159265358979323846);
static const real VAGUE_ANGLE = K(0.10132118364233778); /* 1 / pi^2, models/physics/pose.h */

static real least(real a, real b) { return a < b ? a : b; }
static real most(real a, real b) { return a > b ? a : b; }
static real square(real a) { return a * a; }
static real dot(const real* a, const real* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static real norm(const real* a) { return SQRT(dot(a, a)); }
static void cross(const real* a, const real* b, real* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}
static int is_finite(real a) { return a - a == K(0); }
#if !OCTF_SPATIAL
static real wrap(real a) {
  while (a > PI) a -= 2 * PI;
  while (a <= -PI) a += 2 * PI;
  return a;
}
#endif

/* Pose as a matrix, which rotates points faster than a quaternion. */
typedef struct frame {
  real p[3], R[9];
} frame;

static frame frame_of(const octf_pose* T) {
  const real x = T->q[0], y = T->q[1], z = T->q[2], w = T->q[3];
  frame f;
  memcpy(f.p, T->p_m, sizeof f.p);
  f.R[0] = 1 - 2 * (y * y + z * z);
  f.R[1] = 2 * (x * y - z * w);
  f.R[2] = 2 * (x * z + y * w);
  f.R[3] = 2 * (x * y + z * w);
  f.R[4] = 1 - 2 * (x * x + z * z);
  f.R[5] = 2 * (y * z - x * w);
  f.R[6] = 2 * (x * z - y * w);
  f.R[7] = 2 * (y * z + x * w);
  f.R[8] = 1 - 2 * (x * x + y * y);
  return f;
}
static void rotate(const real* R, const real* v, real* out) {
  out[0] = dot(R, v);
  out[1] = dot(R + 3, v);
  out[2] = dot(R + 6, v);
}
static void rotate_back(const real* R, const real* v, real* out) {
  int i;
  for (i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

static void multiply(const real* a, const real* b, real* out) {
  real q[4], scale;
  q[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
  q[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
  q[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
  q[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
  scale = 1 / SQRT(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  out[0] = q[0] * scale;
  out[1] = q[1] * scale;
  out[2] = q[2] * scale;
  out[3] = q[3] * scale;
}
/* models/physics/pose.cc: exp_rotation */
static void exp_rotation(const real* phi, real* q) {
  const real angle = norm(phi), s = angle < K(1e-4) ? K(0.5) : SIN(angle / 2) / angle;
  q[0] = s * phi[0];
  q[1] = s * phi[1];
  q[2] = s * phi[2];
  q[3] = COS(angle / 2);
}
/* models/physics/pose.cc: retract */
static void retract(octf_pose* T, const real* step) {
  real phi[3] = {0, 0, 0}, q[4];
  T->p_m[0] += step[0];
  T->p_m[1] += step[1];
#if OCTF_SPATIAL
  T->p_m[2] += step[2];
  memcpy(phi, step + 3, sizeof phi);
#else
  phi[2] = step[2];
#endif
  exp_rotation(phi, q);
  multiply(T->q, q, T->q);
}
#if !OCTF_SPATIAL
static octf_pose planar_pose(real x, real y, real heading) {
  octf_pose T = {{0, 0, 0}, {0, 0, 0, 1}};
  T.p_m[0] = x;
  T.p_m[1] = y;
  T.q[2] = SIN(heading / 2);
  T.q[3] = COS(heading / 2);
  return T;
}
#endif
octf_real octf_heading_rad(const octf_pose* T) {
  const real* q = T->q;
  return ATAN2(2 * (q[3] * q[2] + q[0] * q[1]), 1 - 2 * (q[1] * q[1] + q[2] * q[2]));
}

/* Symmetric matrices are packed: the lower triangle row by row. */
static int at(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/* Factor of a matrix that is first scaled to a unit diagonal; 0 if a pivot is at most `least_pivot`.
 * models/support/observed.h: ObservedState. */
static int factor(real* A, real* scale, int n, real least_pivot) {
  int i, j, k;
  for (i = 0; i < n; ++i) {
    const real d = A[at(i, i)];
    if (!(d > 0)) return 0;
    scale[i] = 1 / SQRT(d);
  }
  for (i = 0; i < n; ++i)
    for (j = 0; j <= i; ++j) A[at(i, j)] *= scale[i] * scale[j];
  for (j = 0; j < n; ++j) {
    real pivot = A[at(j, j)];
    for (k = 0; k < j; ++k) pivot -= square(A[at(j, k)]);
    if (!(pivot > least_pivot)) return 0;
    pivot = SQRT(pivot);
    A[at(j, j)] = pivot;
    for (i = j + 1; i < n; ++i) {
      real sum = A[at(i, j)];
      for (k = 0; k < j; ++k) sum -= A[at(i, k)] * A[at(j, k)];
      A[at(i, j)] = sum / pivot;
    }
  }
  return 1;
}
static void solve(const real* L, const real* scale, int n, real* b) {
  int i, k;
  for (i = 0; i < n; ++i) {
    b[i] *= scale[i];
    for (k = 0; k < i; ++k) b[i] -= L[at(i, k)] * b[k];
    b[i] /= L[at(i, i)];
  }
  for (i = n - 1; i >= 0; --i) {
    for (k = i + 1; k < n; ++k) b[i] -= L[at(k, i)] * b[k];
    b[i] /= L[at(i, i)];
  }
  for (i = 0; i < n; ++i) b[i] *= scale[i];
}

octf_real octf_speed_mps(const octf_site* site, octf_real temperature_degC) {
  real x = 0, speed = 0;
  int i;
  if (temperature_degC == temperature_degC) {
    x = least(most(temperature_degC, site->least_degC), site->most_degC);
    x = (x - site->temperature_degC) / 50;
  }
  for (i = 6; i >= 0; --i) speed = speed * x + site->speed[i];
  return speed;
}

/* Delays of an arrival besides the time of flight. */
static real delay_of(const octf_site* site, int b, int r) {
  return site->beacon[b].delay_s + site->receiver[r].delay_s;
}

/* Prediction of an arrival: models/physics/measurement.cc, predict_arrival. */
typedef struct path {
  real tof_s, distance_m;
  real u[3];           /* unit vector from the beacon to the receiver */
  real by_pose[DOF];   /* s/m, s/rad */
  real by_beacon[3];   /* s/m */
  real by_receiver[3]; /* s/m, in the vehicle's frame */
  real by_speed;       /* s/(m/s) */
#if OCTF_ATTENUATION
  real by_attenuation[4];
#endif
} path;

#if OCTF_ATTENUATION
/* Walk and its derivatives by the logarithm of the amplitude and by the rise time: walk_at. */
static real walk_s(const octf_site* site, real log_amplitude, real* by_log_amplitude, real* by_rise_time) {
  real share = site->attenuation[4] * EXP(-log_amplitude);
  if (!(share < K(0.995))) share = K(0.995); /* kMostPredictedShare */
  *by_log_amplitude = -site->attenuation[2] * share / (1 - share);
  *by_rise_time = -LOG1P(-share);
  return site->attenuation[2] * *by_rise_time;
}
static real log_amplitude_at(const octf_site* site, real distance_m, real log_gain) {
  return LOG(site->attenuation[0]) - LOG(distance_m) - site->attenuation[1] * distance_m + log_gain;
}
#endif

#if OCTF_ATTENUATION
/* Adds the time-walk, its derivative by the receiver's position in the map, and in `turn` its derivative by a
 * rotation about the vehicle's axes. */
static void add_walk(const octf_model* m, const frame* T, int b, int r, path* out, real* by_point,
                     real* turn) {
  const octf_site* site = m->site;
  real by_log_amplitude, by_rise_time, log_gain = site->beacon[b].log_gain, by_angle = 0;
  real axis[3] = {0, 0, 0}, u_vehicle[3], across[3], by_cosine = 0, cosine = 0;
  int i;
#if OCTF_DIRECTIONAL
  /* log_directivity of models/physics/attenuation.cc */
  if (!m->centre && dot(site->receiver[r].axis, site->receiver[r].axis) > 0) {
    const real tangent = SIN(site->attenuation[3] / 2) / COS(site->attenuation[3] / 2);
    const real scale = -LOG1P(tangent * tangent), exponent = K(-0.34657359027997264) / scale;
    real share, log_share;
    rotate(T->R, site->receiver[r].axis, axis);
    cosine = -dot(axis, out->u);
    share = (1 + cosine) / 2;
    log_share = LOG(most(share, K(1e-6)));
    log_gain += exponent * log_share;
    by_cosine = share > K(1e-6) ? exponent / (1 + cosine) : 0;
    by_angle = log_share * exponent * tangent / scale;
  }
#endif
  out->tof_s +=
      walk_s(site, log_amplitude_at(site, out->distance_m, log_gain), &by_log_amplitude, &by_rise_time);
  for (i = 0; i < 3; ++i)
    by_point[i] += by_log_amplitude * (-(1 / out->distance_m + site->attenuation[1]) * out->u[i] -
                                       by_cosine / out->distance_m * (axis[i] + cosine * out->u[i]));
  rotate_back(T->R, out->u, u_vehicle);
  cross(u_vehicle, site->receiver[r].axis, across);
  for (i = 0; i < 3; ++i) turn[i] = by_log_amplitude * by_cosine * across[i];
  out->by_attenuation[0] = by_log_amplitude / site->attenuation[0];
  out->by_attenuation[1] = -by_log_amplitude * out->distance_m;
  out->by_attenuation[2] = by_rise_time;
  out->by_attenuation[3] = by_log_amplitude * by_angle;
}
#endif

static void predict(const octf_model* m, const frame* T, int b, int r, path* out) {
  const octf_site* site = m->site;
  const real slowness = site->legs / m->speed_mps;
  real o[3] = {0, 0, 0}, arm[3], by_point[3], rotation[3], turn[3] = {0, 0, 0};
  int i;
  if (!m->centre) memcpy(o, site->receiver[r].p_m, sizeof o);
  rotate(T->R, o, arm);
  for (i = 0; i < 3; ++i) out->u[i] = T->p[i] + arm[i] - site->beacon[b].p_m[i];
  out->distance_m = most(norm(out->u), K(1e-6));
  for (i = 0; i < 3; ++i) {
    out->u[i] /= out->distance_m;
    by_point[i] = slowness * out->u[i];
  }
  out->tof_s = slowness * out->distance_m + delay_of(site, b, r);
  out->by_speed = -slowness * out->distance_m / m->speed_mps;
#if OCTF_ATTENUATION
  add_walk(m, T, b, r, out, by_point, turn);
#endif
  for (i = 0; i < 3; ++i) out->by_beacon[i] = -by_point[i];
  rotate_back(T->R, by_point, out->by_receiver);
  cross(o, out->by_receiver, rotation);
  for (i = 0; i < TURN; ++i) out->by_pose[i] = by_point[i];
  for (i = TURN; i < DOF; ++i) out->by_pose[i] = rotation[i + 3 - DOF] + turn[i + 3 - DOF];
}

/* One-way range that explains a time of flight: models/trajectory/observed_range.cc, models/physics/range.cc.
 */
static real range_of(const octf_model* m, const octf_arrival* a) {
  const octf_site* site = m->site;
  const real path_m = (a->tof_s - delay_of(site, a->beacon, a->receiver)) * m->speed_mps;
#if OCTF_ATTENUATION
  real low = K(1e-6), high = path_m / site->legs, d = high;
  int i;
  if (!(path_m > 0)) return high;
  for (i = 0; i < 80; ++i) {
    real by_log_amplitude, ignored, excess, next;
    excess = site->legs * d - path_m +
             m->speed_mps * walk_s(site, log_amplitude_at(site, d, site->beacon[a->beacon].log_gain),
                                   &by_log_amplitude, &ignored);
    if (excess > 0)
      high = d;
    else
      low = d;
    next = d - excess / (site->legs - m->speed_mps * by_log_amplitude * (1 / d + site->attenuation[1]));
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (ABS(next - d) <= TINY * d) return next;
    d = next;
  }
  return d;
#else
  return path_m / site->legs;
#endif
}

/* Quadratic form with a beacon's covariance of x, y, z, delay and speed. */
static real beacon_variance(const octf_beacon* beacon, const real* by) {
  real sum = 0;
  int i, j, k = 0;
  for (i = 0; i < 5; ++i)
    for (j = i; j < 5; ++j, ++k) sum += (i == j ? 1 : 2) * by[i] * by[j] * beacon->covariance[k];
  return most(sum, 0);
}
/* Calibration variance of an arrival's time [s^2]. */
static real calibration_variance(const octf_model* m, int b, const path* p) {
  real by[5];
  memcpy(by, p->by_beacon, sizeof p->by_beacon);
  by[3] = 1;
  by[4] = p->by_speed;
  return beacon_variance(&m->site->beacon[b], by);
}

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * First pose or position in space: models/localizers/least_squares/spatial_start.cc. */
#if OCTF_SPATIAL

/* Eigenvectors (columns of V) and eigenvalues of a symmetric 3 x 3 matrix: Jacobi rotations. */
static void eigen3(real A[3][3], real V[3][3]) {
  int sweep, p, q, i;
  for (p = 0; p < 3; ++p)
    for (q = 0; q < 3; ++q) V[p][q] = p == q;
  for (sweep = 0; sweep < 12; ++sweep)
    for (p = 0; p < 2; ++p)
      for (q = p + 1; q < 3; ++q) {
        const real off = A[p][q];
        real theta, t, c, s;
        if (off == 0) continue;
        theta = (A[q][q] - A[p][p]) / (2 * off);
        t = (theta < 0 ? -1 : 1) / (ABS(theta) + SQRT(theta * theta + 1));
        if (!is_finite(t)) continue;
        c = 1 / SQRT(t * t + 1);
        s = t * c;
        for (i = 0; i < 3; ++i) {
          const real a = A[i][p], b = A[i][q];
          A[i][p] = c * a - s * b;
          A[i][q] = s * a + c * b;
        }
        for (i = 0; i < 3; ++i) {
          const real a = A[p][i], b = A[q][i], v = V[i][p], u = V[i][q];
          A[p][i] = c * a - s * b;
          A[q][i] = s * a + c * b;
          V[i][p] = c * v - s * u;
          V[i][q] = s * v + c * u;
        }
      }
}

static int is_in(uint32_t groups, int g) { return g >= 32 || ((groups >> g) & 1U); }
static const octf_real* beacon_of(const octf_work* w, int g) {
  return w->m.site->beacon[w->arrivals[w->order[w->first[g]]].beacon].p_m;
}

/* Ranges of a set of groups about the centre of their beacons. */
typedef struct squares {
  real centre[3], mean_range2, mean_norm2, A[3][3], b[3];
} squares;

static void set_squares(const octf_work* w, uint32_t groups, squares* s) {
  real n = 0;
  int g, k, i, j, pass;
  memset(s, 0, sizeof *s);
  for (pass = 0; pass < 3; ++pass) {
    for (g = 0; g < w->groups; ++g) {
      real q[3];
      if (!is_in(groups, g)) continue;
      for (i = 0; i < 3; ++i) q[i] = beacon_of(w, g)[i] - s->centre[i];
      for (k = w->first[g]; k < w->first[g + 1]; ++k) {
        const real range2 = square(w->u.search.range_m[k]);
        n += pass == 0;
        s->mean_range2 += pass == 1 ? range2 / n : 0;
        s->mean_norm2 += pass == 1 ? dot(q, q) / n : 0;
        for (i = 0; i < 3; ++i) {
          s->b[i] += pass == 0   ? q[i]
                     : pass == 1 ? 0
                                 : 2 * q[i] * (dot(q, q) - s->mean_norm2 - range2 + s->mean_range2);
          for (j = 0; j < 3 && pass == 2; ++j) s->A[i][j] += 4 * q[i] * q[j];
        }
      }
    }
    for (i = 0; i < 3 && pass == 0; ++i) {
      s->centre[i] = s->b[i] / n;
      s->b[i] = 0;
    }
  }
}

/* Positions from squared ranges, two for coplanar beacons: linear_positions. Returns their number. */
PHASE int linear_positions(const octf_work* w, uint32_t groups, real out[2][3]) {
  squares s;
  real V[3][3], p[3] = {0, 0, 0}, largest, height;
  int i, c, rank = 0, flat = 0;
  set_squares(w, groups, &s);
  eigen3(s.A, V);
  largest = most(most(s.A[0][0], s.A[1][1]), s.A[2][2]);
  for (c = 0; c < 3; ++c) {
    if (!(s.A[c][c] > K(1e-6) * largest)) {
      flat = c;
      continue;
    }
    ++rank;
    for (i = 0; i < 3; ++i)
      p[i] += V[i][c] * (V[0][c] * s.b[0] + V[1][c] * s.b[1] + V[2][c] * s.b[2]) / s.A[c][c];
  }
  height = rank == 2 ? SQRT(most(s.mean_range2 - s.mean_norm2 - dot(p, p), 0)) : 0;
  for (i = 0; i < 3; ++i) {
    out[0][i] = s.centre[i] + p[i] + height * V[i][flat];
    out[1][i] = s.centre[i] + p[i] - height * V[i][flat];
  }
  return rank == 2 ? 2 : 1;
}

/* Distinct solutions, the best first. */
enum { MOST_SOLVED = 4 };
typedef struct solutions {
  octf_pose pose[MOST_SOLVED];
  real cost[MOST_SOLVED], apart_m;
  int n;
} solutions;

/* spatial_start.cc: differs */
static int differs(const octf_pose* a, const octf_pose* b, real apart_m) {
  const real d[3] = {a->p_m[0] - b->p_m[0], a->p_m[1] - b->p_m[1], a->p_m[2] - b->p_m[2]};
  const real same = a->q[0] * b->q[0] + a->q[1] * b->q[1] + a->q[2] * b->q[2] + a->q[3] * b->q[3];
  return !(norm(d) <= apart_m && ABS(same) >= K(0.99875026)); /* cosine of half of 0.1 rad */
}
static int is_known(const solutions* s, const octf_pose* T) {
  int i;
  for (i = 0; i < s->n; ++i)
    if (!differs(&s->pose[i], T, s->apart_m)) return 1;
  return 0;
}
static void add_solution(solutions* s, const octf_pose* T, real cost) {
  int i, j;
  if (!is_finite(cost) || !is_finite(dot(T->p_m, T->p_m))) return;
  for (i = 0; i < s->n; ++i)
    if (!differs(&s->pose[i], T, s->apart_m)) {
      if (s->cost[i] <= cost) return;
      for (j = i; j + 1 < s->n; ++j) s->pose[j] = s->pose[j + 1], s->cost[j] = s->cost[j + 1];
      --s->n;
      break;
    }
  if (s->n == MOST_SOLVED && !(cost < s->cost[MOST_SOLVED - 1])) return;
  if (s->n == MOST_SOLVED) --s->n;
  for (i = s->n++; i > 0 && s->cost[i - 1] > cost; --i)
    s->pose[i] = s->pose[i - 1], s->cost[i] = s->cost[i - 1];
  s->pose[i] = *T;
  s->cost[i] = cost;
}
static int first_of(const solutions* s, octf_pose* T, int* ambiguous) {
  if (s->n == 0) return 0;
  *T = s->pose[0];
  *ambiguous = s->n > 1 && s->cost[1] < s->cost[0] + 2;
  return 1;
}

/* One of 24 rotations: six faces, four turns each: coarse_rotations. */
static void coarse_rotation(int number, real* q) {
  const int face = number / 4, turn = number % 4;
  real tip[3] = {0, 0, 0}, about_z[3] = {0, 0, 0}, a[4], b[4];
  if (face < 4)
    tip[1] = (real)face * PI / 2;
  else
    tip[0] = (face == 4 ? 1 : -1) * PI / 2;
  about_z[2] = (real)turn * PI / 2;
  exp_rotation(tip, a);
  exp_rotation(about_z, b);
  multiply(a, b, q);
}

/* Pose from all coarse rotations at the linear positions: start_spatial. */
PHASE int start_pose(octf_work* w, solutions* s, octf_pose* T, int* ambiguous) {
  const loss wide = {30, 60}, narrow = {3, 5};
  real p[2][3];
  int k, r, n;
  if (w->groups < 3 || w->first[w->groups] < 6) return 0;
  n = linear_positions(w, 0xFFFFFFFFU, p);
  for (k = 0; k < n; ++k)
    for (r = 0; r < 24; ++r) {
      octf_pose at_start;
      equations eq;
      memcpy(at_start.p_m, p[k], sizeof p[k]);
      coarse_rotation(r, at_start.q);
      adjust(w, &at_start, wide, 15, &eq);
      if (is_known(s, &at_start)) continue;
      adjust(w, &at_start, narrow, 15, &eq);
      add_solution(s, &at_start, eq.cost);
    }
  return first_of(s, T, ambiguous);
}

/* Solves from a position of a sample and from its mirror image in the beacons' plane. */
PHASE void add_places(octf_work* w, uint32_t groups, const real* centre, const real* normal, solutions* s) {
  const loss narrow = {3, 5};
  real p[2][3];
  int k, i, side, n = linear_positions(w, groups, p);
  for (k = 0; k < n; ++k)
    for (side = 0; side < 2; ++side) {
      octf_pose T = {{0, 0, 0}, {0, 0, 0, 1}};
      const real off[3] = {p[k][0] - centre[0], p[k][1] - centre[1], p[k][2] - centre[2]};
      const real height = dot(off, normal);
      equations eq;
      for (i = 0; i < 3; ++i) T.p_m[i] = p[k][i] - (side ? 2 * height * normal[i] : 0);
      if (!is_finite(dot(T.p_m, T.p_m)) || is_known(s, &T)) continue;
      adjust(w, &T, narrow, 40, &eq);
      add_solution(s, &T, eq.cost);
    }
}

/* Position from samples of four beacons: start_place, samples_of. */
PHASE int start_place(octf_work* w, solutions* s, octf_pose* T, int* ambiguous) {
  const int groups = w->groups < 32 ? w->groups : 32;
  real centre[3] = {0, 0, 0}, spread[3][3], V[3][3], normal[3];
  uint32_t set, draw = 1;
  int g, i, j, flat = 0;
  if (w->groups < 3) return 0;
  memset(spread, 0, sizeof spread);
  for (g = 0; g < w->groups; ++g)
    for (i = 0; i < 3; ++i) centre[i] += beacon_of(w, g)[i] / (real)w->groups;
  for (g = 0; g < w->groups; ++g)
    for (i = 0; i < 3; ++i)
      for (j = 0; j < 3; ++j)
        spread[i][j] += (beacon_of(w, g)[i] - centre[i]) * (beacon_of(w, g)[j] - centre[j]);
  eigen3(spread, V);
  for (i = 1; i < 3; ++i)
    if (spread[i][i] < spread[flat][flat]) flat = i;
  for (i = 0; i < 3; ++i) normal[i] = V[i][flat];
  add_places(w, 0xFFFFFFFFU, centre, normal, s);
  if (groups > 4 && groups <= 8) {
    for (set = 0; set < (1U << groups); ++set) {
      int bits = 0;
      for (i = 0; i < groups; ++i) bits += (int)((set >> i) & 1U);
      if (bits == 4) add_places(w, set, centre, normal, s);
    }
  } else if (groups > 8) {
    for (i = 0; i < 64; ++i) {
      int bits = 0;
      for (set = 0; bits < 4;) {
        uint32_t bit;
        draw = draw * 1664525U + 1013904223U;
        bit = (uint32_t)1 << ((draw >> 8) % (uint32_t)groups);
        bits += !(set & bit);
        set |= bit;
      }
      add_places(w, set, centre, normal, s);
    }
  }
  return first_of(s, T, ambiguous);
}

/* Three receivers that are not collinear received something: epoch_fix.cc, may_tell_attitude. */
static int may_determine_attitude(const octf_work* w) {
  const octf_real* corner[2] = {0, 0};
  int k, i;
  for (k = 0; k < w->first[w->groups]; ++k) {
    const octf_real* p = w->m.site->receiver[w->arrivals[w->order[k]].receiver].p_m;
    real a[3], b[3], c[3];
    for (i = 0; i < 3; ++i) {
      a[i] = corner[0] ? p[i] - corner[0][i] : 0;
      b[i] = corner[1] ? corner[1][i] - corner[0][i] : 0;
    }
    cross(b, a, c);
    if (corner[1] && norm(c) > K(1e-4)) return 1;
    if (!corner[0])
      corner[0] = p;
    else if (!corner[1] && norm(a) > K(1e-3))
      corner[1] = p;
  }
  return 0;
}
#endif

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Fix of one stop: models/localizers/least_squares/epoch_fix.cc and least_squares_localizer.cc. */

/* Orders the usable arrivals by beacon and marks the others. */
PHASE void begin(octf_work* w, const octf_site* site, octf_arrival* arrivals, int count, real speed_mps) {
  int b, i, n = 0;
  w->m.site = site;
  w->arrivals = arrivals;
  w->count = count < 0 ? 0 : count > OCTF_ARRIVALS ? OCTF_ARRIVALS : count;
  w->m.speed_mps = speed_mps;
  w->m.centre = 0;
  w->groups = 0;
  for (i = 0; i < count; ++i) {
    const octf_arrival* a = &arrivals[i];
    const int known =
        a->beacon < OCTF_BEACONS && a->receiver < OCTF_RECEIVERS && site->beacon[a->beacon].usable;
    /* A quarter of an hour is longer than any time of flight, and its square in sigmas is finite. */
    arrivals[i].status = i < w->count && known && a->tof_s > 0 && a->tof_s < 1000 ? OCTF_USED : OCTF_UNUSABLE;
  }
  for (b = 0; b < OCTF_BEACONS; ++b) {
    const int first = n;
    for (i = 0; i < w->count; ++i)
      if (arrivals[i].status == OCTF_USED && arrivals[i].beacon == b) w->order[n++] = (octf_index)i;
    if (n > first) w->first[w->groups++] = (octf_index)first;
  }
  w->first[w->groups] = (octf_index)n;
}

/* Computes the ranges of the search: search_problem.cc. Arrivals before their delay are early. */
PHASE void begin_search(octf_work* w) {
  int k;
  w->span_m = 1;
  w->lever_m = 0;
  for (k = 0; k < w->first[w->groups]; ++k) {
    const octf_arrival* a = &w->arrivals[w->order[k]];
    const octf_real* o = w->m.site->receiver[a->receiver].p_m;
    w->u.search.range_m[k] = range_of(&w->m, a);
    w->span_m = most(w->span_m, w->u.search.range_m[k]);
    w->lever_m = most(w->lever_m, SQRT(o[0] * o[0] + o[1] * o[1]));
  }
}

/* epoch_fix.cc: is_consensus */
static int is_consensus(counts c, int unknowns) {
  const int rejected = c.received - c.used, spare = c.used - unknowns;
  if (spare < 0) return 0;
  if (rejected == 0) return 1;
  return spare >= 2 && 3 * c.used >= c.received && (c.beacons_used >= 3 || c.beacons_used == c.beacons);
}

/* epoch_fix.cc: is_poor */
static int is_poor(const octf_work* w, octf_fix* fix) {
  const real range_sigma = single_sigma_s(w, 0) * w->m.speed_mps / w->m.site->legs;
  real variance = horizontal_variance(fix->covariance);
#if OCTF_SPATIAL
  if (w->m.centre) variance = most(variance, fix->covariance[2][2]);
#endif
  return !(SQRT(most(variance, 0)) <= most(1, 10 * range_sigma));
}

/* First pose and its adjustment. Returns 0 if there is none. */
PHASE int start(octf_work* w, octf_fix* fix, equations* eq, int* converged, int* ambiguous) {
#if OCTF_SPATIAL
  solutions s;
  s.n = 0;
  s.apart_m = 10 * single_sigma_s(w, 0) * w->m.speed_mps / w->m.site->legs;
  begin_search(w);
  if (!(w->m.centre ? start_place(w, &s, &fix->pose, ambiguous) : start_pose(w, &s, &fix->pose, ambiguous)))
    return 0;
#else
  octf_pose linear;
  int has_start;
  begin_search(w);
  reject_detours(w);
  has_start = linear_pose(w, &linear);
  if (has_start) {
    fix->pose = linear;
    *converged = adjust_and_reject(w, &fix->pose, eq);
    if (*converged && is_beyond_doubt(w, eq, count_arrivals(w))) return 1;
    linear = fix->pose;
  }
  reset_status(w);
  begin_search(w);
  if (!search_plane(w, has_start ? &linear : 0, &fix->pose, ambiguous)) return 0;
#endif
  *converged = adjust_and_reject(w, &fix->pose, eq);
  return 1;
}

/* epoch_fix.cc: fix_node */
PHASE void fix_node(octf_work* w, octf_fix* fix) {
  const int least_arrivals = !OCTF_SPATIAL ? 2 : w->m.centre ? 3 : 6;
  equations eq;
  counts c;
  int converged = 0, ambiguous = 0, determined, unknowns;
  reset_status(w);
  c = count_arrivals(w);
  fix->status = OCTF_TOO_FEW_ARRIVALS;
  if (c.received < least_arrivals || c.beacons < 2 || !start(w, fix, &eq, &converged, &ambiguous)) return;
  c = count_arrivals(w);
  fix->cost = eq.cost;
  determined = invert(eq.H, fix->covariance);
  unknowns = w->m.centre ? 3 : DOF - (!OCTF_SPATIAL && determined && fix->covariance[2][2] > 1);
  if (!is_consensus(c, unknowns))
    fix->status = c.received == c.used ? OCTF_TOO_FEW_ARRIVALS : OCTF_NO_CONSENSUS;
  else if (!determined || is_poor(w, fix))
    fix->status = OCTF_POOR_GEOMETRY;
  else if (ambiguous)
    fix->status = OCTF_AMBIGUOUS;
  else
    fix->status = converged ? OCTF_OK : OCTF_NOT_CONVERGED;
}

#if OCTF_SPATIAL
/* Rotation is unknown, and the origin lies anywhere about the centre: leave_attitude_open. */
static void leave_attitude_open(const octf_work* w, octf_fix* fix) {
  const real variance = dot(w->m.site->p_centre_m, w->m.site->p_centre_m) / 3;
  int i, j;
  for (i = 0; i < DOF; ++i) {
    for (j = 0; j < DOF; ++j)
      if (i > 2 || j > 2) fix->covariance[i][j] = 0;
    fix->covariance[i][i] += i < 3 ? variance : PI * PI / 3; /* kUnknownRotationVariance */
  }
  if (fix->protection_level_m > 0) fix->protection_level_m += norm(w->m.site->p_centre_m);
}
#endif

octf_status octf_locate(const octf_site* site, octf_arrival* arrivals, int count, octf_real speed_mps,
                        octf_work* w, octf_fix* fix) {
  int i;
  memset(fix, 0, sizeof *fix);
  fix->pose.q[3] = 1;
  begin(w, site, arrivals, count, speed_mps);
  if (speed_mps > 0 && is_finite(speed_mps)) {
#if OCTF_SPATIAL
    w->m.centre = !may_determine_attitude(w);
#endif
    fix_node(w, fix);
#if OCTF_SPATIAL
    if (fix->status != OCTF_OK && !w->m.centre) {
      w->m.centre = 1;
      fix_node(w, fix);
    }
#endif
  }
  if (fix->status == OCTF_OK) {
#if OCTF_PARAMETERS > 0
    add_calibration(w, &fix->pose, fix->covariance);
#endif
    protect(w, fix);
#if OCTF_SPATIAL
    if (w->m.centre) leave_attitude_open(w, fix);
#endif
  }
  for (i = 0; i < count; ++i) fix->used += arrivals[i].status == OCTF_USED;
  fix->rejected = (count < 0 ? 0 : count) - fix->used;
  return fix->status;
}

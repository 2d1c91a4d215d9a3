/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * First pose in the plane: linear ranges, then a search over poses that pairs of ranges allow. */
#if !OCTF_SPATIAL

/* Marks arrivals later than another receiver allows: linear_ranges.cc, reject_detours. */
PHASE void reject_detours(octf_work* w) {
  const real noise_m = w->m.site->sigma_s * w->m.speed_mps * SQRT(2);
  int g, i, j;
  for (g = 0; g < w->groups; ++g)
    for (i = w->first[g]; i < w->first[g + 1]; ++i)
      for (j = w->first[g]; j < w->first[g + 1]; ++j) {
        octf_arrival *a = &w->arrivals[w->order[i]], *b = &w->arrivals[w->order[j]];
        real apart[3];
        int c;
        for (c = 0; c < 3; ++c)
          apart[c] = w->m.site->receiver[a->receiver].p_m[c] - w->m.site->receiver[b->receiver].p_m[c];
        if (w->u.search.range_m[i] - w->u.search.range_m[j] > norm(apart) + 4 * noise_m)
          a->status = OCTF_DETOUR;
      }
}

/* Pose from squared and linear ranges: place_by_linear_ranges. */
PHASE int linear_pose(const octf_work* w, octf_pose* T) {
  real N[6] = {0}, n[3] = {0}, M[10] = {0}, m[4] = {0}, scale[4], z = 0;
  const octf_real* origin = 0;
  int g, k, i, j, c;
  for (g = 0; g < w->groups; ++g) {
    real range = 0, row[3], dz, weight, rhs, p[2];
    const octf_beacon* b = &w->m.site->beacon[w->arrivals[w->order[w->first[g]]].beacon];
    int count = 0;
    for (k = w->first[g]; k < w->first[g + 1]; ++k) {
      const octf_arrival* a = &w->arrivals[w->order[k]];
      if (a->status != OCTF_USED) continue;
      range += w->u.search.range_m[k];
      z = w->m.site->receiver[a->receiver].p_m[2];
      ++count;
    }
    if (count == 0) continue;
    if (!origin) origin = b->p_m;
    range /= (real)count;
    dz = b->p_m[2] - z;
    p[0] = b->p_m[0] - origin[0];
    p[1] = b->p_m[1] - origin[1];
    row[0] = -2 * p[0];
    row[1] = -2 * p[1];
    row[2] = 1;
    weight = (real)count / most(range * range, K(1e-6));
    rhs = range * range - dz * dz - p[0] * p[0] - p[1] * p[1];
    for (i = 0; i < 3; ++i) {
      n[i] += weight * rhs * row[i];
      for (j = 0; j <= i; ++j) N[at(i, j)] += weight * row[i] * row[j];
    }
  }
  if (!origin || !factor(N, scale, 3, K(1e-4))) return 0;
  solve(N, scale, 3, n);
  n[0] += origin[0];
  n[1] += origin[1];
  for (k = 0; k < w->first[w->groups]; ++k) {
    const octf_arrival* a = &w->arrivals[w->order[k]];
    const octf_real *o = w->m.site->receiver[a->receiver].p_m, *b = w->m.site->beacon[a->beacon].p_m;
    real v[3], row[4], d;
    if (a->status != OCTF_USED) continue;
    v[0] = n[0] - b[0];
    v[1] = n[1] - b[1];
    v[2] = o[2] - b[2];
    d = most(norm(v), K(1e-3));
    row[0] = v[0] / d;
    row[1] = v[1] / d;
    row[2] = row[0] * o[0] + row[1] * o[1];
    row[3] = row[1] * o[0] - row[0] * o[1];
    for (i = 0; i < 4; ++i) {
      m[i] += (w->u.search.range_m[k] - d) * row[i];
      for (j = 0; j <= i; ++j) M[at(i, j)] += row[i] * row[j];
    }
  }
  for (c = 0; c < 4; ++c) M[at(c, c)] += K(1e-6);
  if (!factor(M, scale, 4, 0)) return 0;
  solve(M, scale, 4, m);
  if (!is_finite(m[0] + m[1] + m[2] + m[3])) return 0;
  *T = planar_pose(n[0] + m[0], n[1] + m[1], ATAN2(m[3], m[2]));
  return 1;
}

/* Seven or more paths from three beacons, nearly all of which agree: is_beyond_doubt. */
PHASE int is_beyond_doubt(const octf_work* w, const equations* eq, counts c) {
  const real* H = eq->H;
  real det = H[0] * H[2] - H[1] * H[1], heading;
  int i, j, paths = 0;
  if (4 * (c.received - c.used) > c.received || c.beacons_used != c.beacons || c.early > 0 ||
      c.beacons_used < 3)
    return 0;
  for (i = 0; i < w->count; ++i) {
    int known = w->arrivals[i].status != OCTF_USED;
    for (j = 0; j < i && !known; ++j)
      known = w->arrivals[j].status == OCTF_USED && w->arrivals[j].beacon == w->arrivals[i].beacon &&
              w->arrivals[j].receiver == w->arrivals[i].receiver;
    paths += !known;
  }
  if (paths < 7 || !(det > 0)) return 0;
  heading = H[5] - (H[2] * H[3] * H[3] - 2 * H[1] * H[3] * H[4] + H[0] * H[4] * H[4]) / det;
  return heading > 1 / square(K(0.3));
}

/* Keeps the best of many candidates, one of each place: TopList::offer. */
static void offer(octf_work* w, octf_state s, int keep, real apart_m, real apart_rad) {
  octf_state* top = w->u.search.top;
  int i, *n = &w->u.search.tops;
  s.score = score_of(w, &s, *n < keep ? (real)INFINITY : top[*n - 1].score);
  if (*n == keep && !(s.score < top[*n - 1].score)) return;
  for (i = 0; i < *n; ++i) {
    if (ABS(top[i].x_m - s.x_m) > apart_m || ABS(top[i].y_m - s.y_m) > apart_m ||
        ABS(wrap(top[i].heading_rad - s.heading_rad)) > apart_rad)
      continue;
    if (top[i].score <= s.score) return;
    memmove(top + i, top + i + 1, (size_t)(*n - i - 1) * sizeof *top);
    --*n;
    break;
  }
  if (*n == keep) --*n;
  for (i = *n; i > 0 && top[i - 1].score > s.score; --i) top[i] = top[i - 1];
  top[i] = s;
  ++*n;
}

/* Offers the intersections of two circles for a heading: candidates.cc, intersect and pair_states. */
PHASE void offer_pair(octf_work* w, int k, int l, real heading, int keep, real apart_m, real apart_rad) {
  const real cosine = COS(heading), sine = SIN(heading);
  const octf_state zero = {0, 0, 0, 0};
  const ray a = ray_of(w, &zero, cosine, sine, k), b = ray_of(w, &zero, cosine, sine, l);
  const real za = square(a.distance_m) - a.dx * a.dx - a.dy * a.dy,
             zb = square(b.distance_m) - b.dx * b.dx - b.dy * b.dy;
  const real ra = SQRT(most(square(w->u.search.range_m[k]) - za, 0)),
             rb = SQRT(most(square(w->u.search.range_m[l]) - zb, 0));
  const real dx = a.dx - b.dx, dy = a.dy - b.dy, d = SQRT(dx * dx + dy * dy);
  real along, across2, h;
  int side;
  if (d < K(1e-6)) return;
  along = (d * d + ra * ra - rb * rb) / (2 * d);
  across2 = ra * ra - along * along;
  if (across2 < 0) along = d > ra + rb ? (ra + d - rb) / 2 : (along + (along < 0 ? -ra : ra)) / 2;
  h = SQRT(most(across2, 0));
  for (side = 0; side < (across2 > 0 ? 2 : 1); ++side, h = -h) {
    octf_state s = {0, 0, 0, 0};
    s.x_m = -a.dx + (along * dx - h * dy) / d;
    s.y_m = -a.dy + (along * dy + h * dx) / d;
    s.heading_rad = heading;
    offer(w, s, keep, apart_m, apart_rad);
  }
}

/* Position in `order` of the earliest or of the middle arrival of a group: representatives. */
static int representative(const octf_work* w, int g, int middle) {
  const int first = w->first[g], last = w->first[g + 1], rank = middle ? (last - first) / 2 : 0;
  const octf_real* r = w->u.search.range_m;
  int i, j;
  for (i = first; i < last; ++i) {
    int below = 0;
    for (j = first; j < last; ++j) below += r[j] < r[i] || (r[j] == r[i] && j < i);
    if (below == rank) return i;
  }
  return first;
}

static real distance2(const octf_state* a, const octf_state* b, const octf_real* H) {
  const real d[3] = {b->x_m - a->x_m, b->y_m - a->y_m, wrap(b->heading_rad - a->heading_rad)};
  real sum = 0;
  int i, j;
  for (i = 0; i < 3; ++i)
    for (j = 0; j < 3; ++j) sum += d[i] * d[j] * H[at(i, j)];
  return sum;
}

/* Adds a solved pose unless it is known: search_pose.cc, enter. */
static void enter(octf_work* w, octf_state s, const real* H) {
  octf_state* poses = w->u.search.poses;
  int i, worst = 0, *n = &w->u.search.solved;
  s.score = score_of(w, &s, (real)INFINITY);
  if (!is_finite(s.score)) return;
  for (i = 0; i < *n; ++i) {
    if (poses[i].score > poses[worst].score) worst = i;
    if (least(distance2(&poses[i], &s, w->u.search.information[i]), distance2(&s, &poses[i], H)) > 9)
      continue;
    if (!(s.score < poses[i].score)) return;
    break;
  }
  if (i == *n && *n == 6) {
    i = worst;
    if (!(s.score < poses[i].score)) return;
  }
  if (i == *n) ++*n;
  poses[i] = s;
  memcpy(w->u.search.information[i], H, sizeof w->u.search.information[i]);
}

/* Refines a candidate to the noise level and adds it: refine_into. */
static void refine_into(octf_work* w, octf_state s, real width_m, int without) {
  const real median = w->m.site->sigma_s * w->m.speed_mps / w->m.site->legs;
  real H[6], extra;
  for (extra = width_m; extra > median / 2; extra *= K(0.3)) {
    set_extra_sigma(w, extra);
    refine(w, &s, extra, 3, without, H);
  }
  set_extra_sigma(w, 0);
  if (without != NO_GROUP) refine(w, &s, 0, 6, without, H);
  refine(w, &s, 0, 10, NO_GROUP, H);
  enter(w, s, H);
}

static int best_pose(const octf_work* w, int but) {
  int i, best = -1;
  for (i = 0; i < w->u.search.solved; ++i)
    if (i != but && (best < 0 || w->u.search.poses[i].score < w->u.search.poses[best].score)) best = i;
  return best;
}

/* Proposes poses from pairs of arrivals for each heading: propose_from_pairs, choose_pairs. */
PHASE void propose(octf_work* w, int headings, int keep, real width_m) {
  const real median = w->m.site->sigma_s * w->m.speed_mps / w->m.site->legs;
  const real apart_m = 2 * width_m + 5 * median, apart_rad = K(2.4) * PI / (real)headings;
  const int turns = w->lever_m > K(1e-6) ? headings : 1, most_pairs = 640 / (2 * headings);
  int h, mix, step, a;
  for (h = 0; h < turns; ++h) {
    const real heading = wrap(2 * PI * (real)h / (real)headings);
    int pairs = 0;
    for (mix = 0; mix < 4; ++mix)
      for (step = 1; step < w->groups; ++step)
        for (a = 0; a + step < w->groups && pairs < most_pairs; ++a) {
          const int first = mix == 1 || mix == 3, second = mix == 1 || mix == 2;
          const int k = representative(w, a, first), l = representative(w, a + step, second);
          if ((first && k == representative(w, a, 0)) || (second && l == representative(w, a + step, 0)))
            continue;
          offer_pair(w, k, l, heading, keep, apart_m, apart_rad);
          ++pairs;
        }
  }
}

/* Best pose of the search; `ambiguous` if another one is equally good: search_pose, start_planar. */
PHASE int search_plane(octf_work* w, const octf_pose* start, octf_pose* T, int* ambiguous) {
  const real median = w->m.site->sigma_s * w->m.speed_mps / w->m.site->legs;
  const int wanted = (int)(K(31.4159265) * w->lever_m) + 1; /* half a step moves a receiver by 50 mm */
  const int headings = wanted > 24 ? 24 : wanted > 8 ? wanted : 8, keep = headings > 8 ? 20 : 10;
  const real width_m = w->lever_m * PI / (real)(2 * headings);
  int i, g, best, second;
  w->u.search.tops = w->u.search.solved = 0;
  set_extra_sigma(w, SQRT(width_m * width_m + median * median));
  propose(w, headings, keep, width_m);
  if (start) {
    octf_state s = {0, 0, 0, 0};
    s.x_m = start->p_m[0];
    s.y_m = start->p_m[1];
    s.heading_rad = octf_heading_rad(start);
    refine_into(w, s, most(width_m, 30 * median), NO_GROUP);
  }
  for (i = 0; i < w->u.search.tops; ++i) refine_into(w, w->u.search.top[i], most(width_m, median), NO_GROUP);
  best = best_pose(w, -1);
  if (best < 0) return 0;
  /* try_without_each_beacon */
  if (w->groups >= 3 && w->u.search.poses[best].score > K(0.5) * (real)w->first[w->groups] + 3) {
    const octf_state from = w->u.search.poses[best];
    for (g = 0; g < w->groups; ++g) refine_into(w, from, 30 * median, g);
    best = best_pose(w, -1);
  }
  second = best_pose(w, best);
  *ambiguous = second >= 0 && w->u.search.poses[second].score < w->u.search.poses[best].score + 2;
  *T = planar_pose(w->u.search.poses[best].x_m, w->u.search.poses[best].y_m,
                   w->u.search.poses[best].heading_rad);
  return 1;
}
#endif

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/arrival_rejections.h"

namespace octant {

bool set_rejections(Trajectory& t, const Segment& segment, BeaconId beacon, Rejection from, Rejection to) {
  bool any = false;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != from || (beacon.valid() && a.beacon != beacon)) continue;
    a.rejection = to;
    any = true;
  }
  return any;
}

void report_arrivals(const Trajectory& t, std::size_t first, std::size_t last, Fix& fix) {
  fix.rejections.clear();
  fix.arrivals_used = fix.arrivals_rejected = 0;
  for (std::size_t i = first; i < last; ++i) {
    const Rejection r = t.arrivals[i].rejection;
    fix.rejections.push_back(r);
    ++(r == Rejection::kUsed ? fix.arrivals_used : fix.arrivals_rejected);
  }
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/separation.h"

#include <algorithm>
#include <cmath>

#include "models/changes/chi_square.h"
#include "models/support/observed.h"

namespace octant {
BeaconSums::RowSum& BeaconSums::of_beacon(BeaconId beacon) {
  for (OfBeacon& b : beacons_)
    if (b.beacon == beacon) return b.sum;
  beacons_.push_back({beacon, RowSum(n_)});
  return beacons_.back().sum;
}

BeaconSeparation BeaconSums::separation(const OfBeacon& of) const {
  BeaconSeparation out;
  out.beacon = of.beacon;
  out.arrivals = of.sum.rows;
  const ObservedState<NodeBlock> without(all_.A - of.sum.A);
  out.determined = without.all();
  if (!out.determined) return out;
  const NodeBlock P = without.covariance();
  const NodeVector shift = P * (of.sum.g - all_.g);
  out.shift_m = shift.head<2>().norm();
  out.variance_m2 = horizontal_variance(P);
  // Errors that are common to its arrivals increase the misfit by at most this factor.
  out.misfit = (of.sum.squares + of.sum.g.dot(P * of.sum.g)) / (1.0 + of.sum.common);
  return out;
}

std::pmr::vector<BeaconSeparation> BeaconSums::separations() const {
  std::pmr::vector<BeaconSeparation> out(scratch());
  out.reserve(beacons_.size());
  for (const OfBeacon& of : beacons_) out.push_back(separation(of));
  return out;
}

Protection BeaconSums::protection(double variance_m2) const {
  Protection out;
  const ObservedState<NodeBlock> observed(all_.A);
  if (beacons_.empty() || !observed.all()) return out;
  const double widened = std::max(1.0, variance_m2 / horizontal_variance(observed.covariance()));
  double worst_m = 0.0, worst_misfit = 1.0;
  bool all_determined = true;
  for (const OfBeacon& of : beacons_) {
    const BeaconSeparation s = separation(of);
    ++out.beacons;
    all_determined = all_determined && s.determined;
    if (!s.determined) continue;
    worst_m = std::max(worst_m, s.shift_m + kFaultySigmas * std::sqrt(widened * s.variance_m2));
    const double misfit = s.misfit / chi2_gate(s.arrivals, kAtFaultSigmas);
    if (misfit > worst_misfit) {
      worst_misfit = misfit;
      out.at_fault = s.beacon;
    }
  }
  if (all_determined) out.level_m = protection_level_m(variance_m2, worst_m);
  return out;
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/deployed_site.h"

namespace octant::calib {

Site deployed_site(const Deployment& d) {
  Site site;
  site.name = d.site;
  site.motion = d.motion;
  site.medium = d.medium;
  site.timing = d.timing;
  site.noise = d.noise;
  site.noise.pair_sigma_s.reset();
  site.tolerance = d.tolerance;
  if (d.attenuation) {
    AttenuationPrior& prior = site.attenuation.emplace();
    prior.threshold_v = d.attenuation->threshold_v;
    prior.saturation_v = d.attenuation->saturation_v;
  }
  for (const DeploymentBeacon& b : d.beacons) site.beacons.emplace_back().name = b.name;
  site.vehicles = d.vehicles;
  for (const DeploymentReceiver& r : d.receivers)
    site.receivers.push_back(
        {.name = r.name, .vehicle = r.vehicle, .position_m = r.position_m, .axis = r.axis});
  return site;
}

}  // namespace octant::calib

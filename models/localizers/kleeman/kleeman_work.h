// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to Kleeman: what it keeps of a vehicle, and of the call under way.

#include <algorithm>
#include <cmath>
#include <vector>

#include "models/deployment.h"
#include "models/localizers/kleeman/kleeman_heading.h"
#include "models/localizers/kleeman/kleeman_longsolve.h"

namespace octant {

/// State of a vehicle: its array, the beacons relative to the plane of its receivers, and its last position.
struct KleemanVehicle {
  KleemanVehicle(const Deployment& deployment, const SiteVehicle& vehicle, const LongsolveOptions& options)
      : first_receiver(vehicle.first_receiver),
        drift(deployment.timing.clock == Clock::kCycleOffset ? vehicle.clock_drift : 0.0),
        receivers(receivers_of(deployment, vehicle)),
        plane_m(mean_height_m(receivers)),
        radius_m(largest_lever_m(receivers)),
        plan(plan_of(deployment, plane_m)),
        longsolve(plan, options),
        memory(longsolve.memory()) {}

  std::size_t first_receiver;
  double drift;
  std::vector<ArrayReceiver> receivers;
  double plane_m;   ///< mean height of the receivers: the plane of hyperbolic_fix.h
  double radius_m;  ///< radius of the array around the vehicle's centre
  std::vector<PlanBeacon> plan;
  Longsolve longsolve;
  LongsolveMemory memory;

 private:
  static std::vector<ArrayReceiver> receivers_of(const Deployment& d, const SiteVehicle& vehicle) {
    const double speed_mps = d.speed_mps(d.medium.temperature_degC);
    std::vector<ArrayReceiver> out;
    for (std::size_t i = 0; i < vehicle.receiver_count; ++i) {
      const DeploymentReceiver& r = d.receivers[vehicle.first_receiver + i];
      ArrayReceiver a;
      a.position_m = r.position_m;
      a.delay_s = r.delay_s;
      const double delay_m = speed_mps * r.delay_sigma_s;
      a.variance_m2 = delay_m * delay_m + r.sigma_m.squaredNorm() / 3;  // in any one direction
      if (r.axis) a.direction = *r.axis;
      if (r.axis && r.axis->head<2>().norm() > 1e-6) a.axis = r.axis->head<2>().normalized();
      out.push_back(a);
    }
    return out;
  }
  static double mean_height_m(const std::vector<ArrayReceiver>& receivers) {
    double sum_m = 0.0;
    for (const ArrayReceiver& r : receivers) sum_m += r.position_m.z();
    return receivers.empty() ? 0.0 : sum_m / static_cast<double>(receivers.size());
  }
  static double largest_lever_m(const std::vector<ArrayReceiver>& receivers) {
    double radius_m = 0.0;
    for (const ArrayReceiver& r : receivers) radius_m = std::max(radius_m, r.position_m.head<2>().norm());
    return radius_m;
  }
  static std::vector<PlanBeacon> plan_of(const Deployment& d, double plane_m) {
    std::vector<PlanBeacon> plan;
    for (const DeploymentBeacon& b : d.beacons)
      plan.push_back({b.position_m.head<2>(), b.position_m.z() - plane_m});
    return plan;
  }
};

/// State of the current call.
struct KleemanWork {
  KleemanVehicle* vehicle = nullptr;  ///< null: no arrivals of a vehicle with receivers
  std::vector<HeardDistance> heard;
  std::size_t arrivals = 0;
  double speed_mps = 343.0;   ///< at the mean temperature
  LongsolveMemory memory;     ///< copied to the vehicle if there is a fix
  OffsetDistances distances;  ///< distances of the beacons from the vehicle's centre
  BeaconSet impossible;       ///< violate the triangle inequality
  LongsolveFix solution;
  Heading heading;
  bool heading_tried = false;  ///< true after the first pass
};

}  // namespace octant

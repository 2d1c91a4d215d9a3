// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/enum_names.h"

namespace octant {
namespace {

template <class Beacons, class Vehicles, class Receivers>
NameTable collect_names(const Beacons& beacons, const Vehicles& vehicles, const Receivers& receivers) {
  NameTable names;
  for (const auto& beacon : beacons) names.beacons.push_back(beacon.name);
  for (const auto& vehicle : vehicles) names.vehicles.push_back(vehicle.name);
  for (const auto& receiver : receivers) names.receivers.push_back({receiver.name, receiver.vehicle});
  return names;
}

}  // namespace

Prior beacon_delay_prior(const Site& site, std::size_t beacon) {
  const SiteBeacon& b = site.beacons[beacon];
  return {b.delay_s.value_or(site.timing.delay_s), b.delay_sigma_s.value_or(site.timing.delay_sigma_s)};
}

double largest_delay_sigma_s(const Site& site) {
  const DelayPer& per = site.timing.delay_per;
  double largest_s = per.receiver || per.site ? site.timing.delay_sigma_s : 0.0;
  if (per.beacon)
    for (std::size_t b = 0; b < site.beacons.size(); ++b)
      largest_s = std::max(largest_s, beacon_delay_prior(site, b).sigma);
  return largest_s;
}

NameTable names_of(const Site& site) { return collect_names(site.beacons, site.vehicles, site.receivers); }

NameTable names_of(const Deployment& deployment) {
  return collect_names(deployment.beacons, deployment.vehicles, deployment.receivers);
}

Result<Arrival> arrival_of(const NameTable& names, std::string_view beacon, double tof_s, double time_s,
                           std::string_view receiver, std::string_view vehicle) {
  const auto unknown = [](const char* what, std::string_view name) {
    return fail({.code = Errc::kBadInput,
                 .found = name.empty()
                              ? std::string("no ") + what + " is named, and there is not just one"
                              : std::string(what) + " '" + std::string(name) + "' is not in the deployment"});
  };
  Arrival a;
  a.time_s = time_s;
  a.tof_s = tof_s;
  a.beacon = names.find_beacon(beacon);
  if (!a.beacon.valid()) return unknown("beacon", beacon);
  a.vehicle = names.find_vehicle(vehicle);
  if (!a.vehicle.valid()) return unknown("vehicle", vehicle);
  a.receiver = names.find_receiver(a.vehicle, receiver);
  if (!a.receiver.valid()) return unknown("receiver", receiver);
  return a;
}

BeaconId NameTable::find_beacon(std::string_view name) const {
  const auto at = std::ranges::find(beacons, name);
  return at == beacons.end() ? BeaconId() : BeaconId(static_cast<std::size_t>(at - beacons.begin()));
}

VehicleId NameTable::find_vehicle(std::string_view name) const {
  if (name.empty() && vehicles.size() == 1) return VehicleId(0);
  const auto at = std::ranges::find(vehicles, name.empty() ? "robot" : name);
  return at == vehicles.end() ? VehicleId() : VehicleId(static_cast<std::size_t>(at - vehicles.begin()));
}

ReceiverId NameTable::find_receiver(VehicleId vehicle, std::string_view name) const {
  ReceiverId found;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    if (receivers[i].vehicle != vehicle || (!name.empty() && receivers[i].name != name)) continue;
    if (found.valid()) return {};  // no name given, but there are several
    found = ReceiverId(i);
  }
  return found;
}

const char* to_string(BeaconStatus status) {
  static constexpr auto kNames = enum_names<BeaconStatus>("calibrated", "control_point", "undetermined");
  return kNames[status];
}

const char* to_string(FixStatus status) {
  static constexpr auto kNames = enum_names<FixStatus>("ok", "too_few_arrivals", "poor_geometry", "ambiguous",
                                                       "no_consensus", "not_converged");
  return kNames[status];
}

const char* to_string(Rejection rejection) {
  static constexpr auto kNames =
      enum_names<Rejection>("used", "late", "early", "beacon_unusable", "no_pose", "triangle", "out_of_range",
                            "reflection", "outvoted", "not_needed", "unknown_id", "beacon_fault");
  return kNames[rejection];
}

Eigen::Matrix<double, 6, 6> covariance_in_map(const PoseCovariance& covariance, const Pose& T) {
  Eigen::Matrix<double, 6, 6> C = Eigen::Matrix<double, 6, 6>::Zero();
  if (covariance.rows() == 3) {
    const int at[] = {0, 1, 5};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) C(at[i], at[j]) = covariance(i, j);
  } else if (covariance.rows() == 6) {
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Identity();
    turn.bottomRightCorner<3, 3>() = T.rotation.toRotationMatrix();
    C = turn * Eigen::Matrix<double, 6, 6>(covariance) * turn.transpose();
  }
  return C;
}

Integrity integrity(const Fix& fix) {
  if (!fix.ok()) return Integrity::kNoFix;
  const bool at_fault = std::ranges::find(fix.rejections, Rejection::kBeaconFault) != fix.rejections.end();
  return at_fault || !(fix.protection_level_m > 0.0) ? Integrity::kDegraded : Integrity::kOk;
}

const char* to_string(Integrity integrity) {
  static constexpr auto kNames = enum_names<Integrity>("ok", "degraded", "no_fix");
  return kNames[integrity];
}

const char* integrity_reason(const Fix& fix) {
  switch (integrity(fix)) {
    case Integrity::kOk: return "";
    case Integrity::kDegraded: return fix.protection_level_m > 0.0 ? "beacon_fault" : "not_protected";
    case Integrity::kNoFix: return to_string(fix.status);
  }
  return "";
}

}  // namespace octant

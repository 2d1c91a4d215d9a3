// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/change.h"
#include "models/deployment.h"
#include "models/simulator/synthetic.h"

namespace octant::study {

/// Events at a site between two visits.
enum class Event {
  kNothing,
  kOneMoved,      ///< an approximate beacon, 10 to 100 mm, log-uniform
  kTwoMoved,      ///< each by 10 to 100 mm
  kThreeMoved,    ///< each by 10 to 100 mm
  kControlPoint,  ///< one of four is knocked by 20 to 200 mm
  kWarmer,        ///< by 8 degC, as the thermometer shows
  kDelay,         ///< delay of a beacon, +40 us
  kReceiver,      ///< bent by 20 to 50 mm
  kExchanged      ///< two approximate beacons are at each other's positions
};
inline constexpr std::array<Event, 9> kEvents = {Event::kNothing,    Event::kOneMoved,     Event::kTwoMoved,
                                                 Event::kThreeMoved, Event::kControlPoint, Event::kWarmer,
                                                 Event::kDelay,      Event::kReceiver,     Event::kExchanged};
[[nodiscard]] const char* to_string(Event event);

/// True change of one subject.
struct TrueChange {
  ChangeKind kind = ChangeKind::kBeaconMoved;
  std::size_t owner = 0;  ///< beacon or receiver
  std::string subject;    ///< "B3"; "robot/r3"; each of two exchanged beacons separately
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  double delay_s = 0.0;
};

/// A hall of 16 to 24 by 10 to 15 m with 8 to 12 beacons, four of them control points, and a cart with 4 to 8
/// receivers; 60 to 80 stops at first, later 15 to 25 stops or (in two of five) a drive of 3 to 5 minutes,
/// and a drive of another night. Echoes at half of the sites, amplitudes at a quarter.
struct ChangedSite {
  World first;   ///< its validation run is not used
  World second;  ///< truth after the change; `run` is the second visit, `heldout` the night's drive
  std::vector<TrueChange> changes;
  bool drives = false;  ///< the second visit is a drive
};

/// @param drift  standard deviations of the true drift of everything between the visits; zero: no drift.
/// Gains and attenuation never drift.
[[nodiscard]] ChangedSite changed_site(Event event, std::uint64_t seed, const Drift& drift);

/// Site in which a changed beacon or receiver is a separate one at the second visit, with that visit's run
/// adapted: for a new calibration of both visits.
/// @param index  index of each of the first site's beacons among them
struct BothVisits {
  Site site;
  MeasurementLog second;
  std::vector<std::size_t> beacon;
};
[[nodiscard]] BothVisits both_visits(const ChangedSite& site);

}  // namespace octant::study

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calib/problem/finding.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// The file that a run's measured poses were read from: points.csv, or else poses.tum.
[[nodiscard]] std::string pose_file(const MeasurementLog& run);

/// Contribution of one beacon or one receiver to a recording.
struct LinkHealth {
  std::string name;
  std::size_t arrivals = 0;        ///< bearings included
  double rate_hz = 0.0;            ///< over the duration of the run; 0 where the run has no duration
  double longest_silence_s = 0.0;  ///< within the run, its ends included
};

struct Gap {
  double from_s = 0.0, to_s = 0.0;
};

/// Fraction of the arrivals that a second sensor accompanies.
struct Coverage {
  std::size_t rows = 0;
  double share = 0.0;          ///< fraction of arrivals, 0..1
  double longest_gap_s = 0.0;  ///< between neighbouring rows
};

/// Properties of a recording from counting, before an adjustment.
struct RunHealth {
  std::string path;
  double duration_s = 0.0;
  std::size_t rows = 0, arrivals = 0, bearings = 0, instants = 0;  ///< instants: epochs, or distinct times
  std::vector<LinkHealth> beacons;                                 ///< order of the site
  std::vector<LinkHealth> receivers;            ///< receivers of vehicles that occur in the run
  std::map<std::string, std::size_t> rejected;  ///< rows that are no measurement, by reason
  std::size_t duplicates = 0;                   ///< rows that repeat another one
  std::size_t backwards = 0;                    ///< rows earlier than the row before
  std::vector<Gap> gaps;                        ///< pauses beyond ten times the usual, longest first
  std::vector<ClockStep> clock_steps;
  double median_range_m = 0.0;        ///< by the medium's speed and the prior delay
  double resolution_s = 0.0;          ///< resolution of the counter, according to the values; 0: not visible
  std::vector<std::string> constant;  ///< beacons whose time of flight never changes
  double temperature_share = 0.0;     ///< fraction of arrivals with a temperature of their own
  bool temperature_of_run = false;    ///< run.yaml states one
  Coverage odometry, poses;
  std::vector<Finding> findings;
};

/// Examines one recording by counting and sorting; no adjustment. Linear in the rows but for sorting.
[[nodiscard]] RunHealth log_health(const Site& site, const MeasurementLog& run);

/// Beacons of the site without arrivals in any run, and receivers without arrivals in the runs of their
/// vehicle.
[[nodiscard]] std::vector<Finding> silent_links(const Site& site, const std::vector<RunHealth>& runs);

/// Resolution of a counter: the step of which all values are integer multiples (to a hundredth of it, one
/// phase). Needs repeated values; 0 without a step.
/// @param values_s  times of flight [s], any order
[[nodiscard]] double counter_resolution_s(std::vector<double> values_s);

}  // namespace octant::calib

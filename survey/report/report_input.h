// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "survey/changes.h"
#include "survey/drawing/chart_data.h"
#include "survey/drawing/plan_input.h"
#include "survey/evaluate.h"

namespace octant::survey {

/// A combination of parameters that the data hardly determine, in words.
struct WeakNote {
  std::string description;
  std::string remedy;
  double consequence_m = 0.0;  ///< at the robot
  bool blocking = false;       ///< no deployment was exported because of it
  bool lone_beacon = false;    ///< an undetermined beacon, which does not block the others
};

/// The action for arrivals that were left out depends only on this reason.
enum class LeftOutCause { kOther, kLate, kEarly, kNoPose };

/// Arrivals left out, by reason in words.
struct LeftOutNote {
  std::string reason;
  std::size_t count = 0;
  LeftOutCause cause = LeftOutCause::kOther;
};

/// Arrivals at one stop, or in a segment of a drive.
struct StopNote {
  std::string name;  ///< name of the stop: its epoch; of a segment of a drive: "120 to 130 s"
  bool moving = false;
  Eigen::Vector2d at_m{0, 0};
  std::size_t used = 0, late = 0, early = 0, other = 0;  ///< arrivals; late, early, other: left out
  std::size_t looked_at = 0;                             ///< residuals that mean and RMS are of
  double mean_s = 0.0, rms_s = 0.0;
  [[nodiscard]] std::size_t left_out() const { return late + early + other; }
};

/// Result of the adjustment for one beacon.
struct BeaconNote {
  std::string name;
  std::size_t used = 0, rejected = 0;
  double redundancy = 0.0;                ///< mean redundancy number of its arrivals
  std::optional<double> rms_s;            ///< RMS of its residuals
  std::optional<double> variance_factor;  ///< variance of its residuals over the stated variance
  std::optional<double> mdb_s;            ///< minimal detectable bias of one arrival, median
  std::optional<double> influence_m;      ///< largest shift of a coordinate by one that is not detected
  std::optional<double> lateness_mdb_s,
      lateness_influence_m;  ///< influence of a common lateness of all its arrivals
};

/// Quality of positioning when one beacon fails.
struct BeaconLoss {
  std::string beacon;
  double covered_fraction = 0.0;      ///< fraction of the calibrated area where a fix is still possible
  std::optional<double> median, p95;  ///< statistics of the mapped quantity, where it is covered
  std::optional<NamedMap> map;
};

/// A beacon whose estimated position differs from the site file: error of the measured position.
struct MovedNote {
  std::string beacon;
  std::array<std::optional<double>, 3> shift_m;  ///< found less stated, where something was stated
  double sigma_m = 0.0;                          ///< largest found value, of the stated axes
  std::optional<double> stated_sigma_m;          ///< largest that the site file states
  double distance_m = 0.0;                       ///< over the stated axes
};

enum class Outcome {
  kCalibrated,
  kRefused,  ///< the data do not determine the result; no deployment was exported
  kNotConverged
};

/// Content of a report, as plain values.
struct ReportInput {
  std::string kind = "Calibration";  ///< kind of report: "Calibration", "Survey", "Verification"
  Outcome outcome = Outcome::kCalibrated;
  std::string message;  ///< message of the solver; may be empty
  PlanInput plan;
  std::vector<BeaconNote> beacons;
  std::vector<MovedNote> moved;  ///< farthest first
  std::vector<WeakNote> weak;
  std::vector<LeftOutNote> left_out;
  std::vector<StopNote> stops;   ///< stops; of a long list, only the conspicuous ones
  std::vector<PlanMiss> misses;  ///< misses, grouped by position
  std::vector<ResidualChart> residuals;
  std::optional<Histogram> standardised;  ///< residuals over their sigmas
  std::size_t looked_at = 0;              ///< arrivals that residuals and redundancies are of
  std::optional<Evaluation> evaluation;
  std::optional<BeaconLoss> no_loss;  ///< all beacons at work
  std::vector<BeaconLoss> losses;     ///< worst first; their figure is loss_name
  std::string loss_name, loss_unit;
  std::optional<Changes> changes;  ///< since an earlier deployment
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> words;  ///< terms of the report, each with its meaning
  std::string command;                                     ///< command line that wrote this report
  std::vector<std::string> options;  ///< options in words, in addition to the command line: "threads 2"
};

}  // namespace octant::survey

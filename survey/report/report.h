// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "models/deployment.h"
#include "survey/changes.h"
#include "survey/drawing/site_plan.h"
#include "survey/evaluate.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report_document.h"

namespace octant::survey {

/// A combination of parameters of which the data say little, in words.
struct WeakNote {
  std::string description;
  std::string remedy;
  double consequence_m = 0.0;  ///< at the robot
  bool blocking = false;       ///< nothing was exported because of it
  bool lone_beacon = false;    ///< an undetermined beacon, which does not block the others
};

/// What is to be done about arrivals that were left out depends on this alone.
enum class LeftOutCause { kOther, kLate, kEarly, kNoPose };

/// Arrivals left out, by reason in words.
struct LeftOutNote {
  std::string reason;
  std::size_t count = 0;
  LeftOutCause cause = LeftOutCause::kOther;
};

/// What was heard at one stop, or on a stretch of a drive.
struct StopNote {
  std::string name;  ///< of the stop: its epoch; of a stretch: "120 to 130 s"
  bool moving = false;
  Eigen::Vector2d at_m{0, 0};
  std::size_t used = 0, late = 0, early = 0, other = 0;  ///< arrivals; late, early, other: left out
  std::size_t looked_at = 0;                             ///< residuals that mean and RMS are of
  double mean_s = 0.0, rms_s = 0.0;
  [[nodiscard]] std::size_t left_out() const { return late + early + other; }
};

/// What the adjustment says of one beacon.
struct BeaconNote {
  std::string name;
  std::size_t used = 0, rejected = 0;
  double redundancy = 0.0;                ///< mean redundancy number of its arrivals
  std::optional<double> rms_s;            ///< of its residuals
  std::optional<double> variance_factor;  ///< of its residuals, over the stated variance
  std::optional<double> mdb_s;            ///< minimal detectable bias of one arrival, median
  std::optional<double> influence_m;      ///< largest shift of a coordinate by one that is not detected
  std::optional<double> lateness_mdb_s,
      lateness_influence_m;  ///< the same for a lateness of all its arrivals
};

/// Residuals of one bin, or of one beacon.
struct ResidualBin {
  std::string name;  ///< empty for a bin
  double from = 0.0, to = 0.0;
  std::size_t count = 0;
  double mean_s = 0.0, rms_s = 0.0;
};

/// Residuals by some quantity, binned: a report never carries single arrivals.
struct ResidualChart {
  std::string by;    ///< "beacon", "distance", ...
  std::string unit;  ///< of the bins' ends as given: "m", "deg", "degC", "s"; empty for names
  std::vector<ResidualBin> bins;
  /// In which its residuals are read with ease.
  [[nodiscard]] Unit time() const;
};

/// Standardised residuals counted in bins of equal width; what lies beyond the ends is in the outermost bins.
struct Histogram {
  double from = 0.0, width = 0.0;
  std::vector<std::size_t> counts;
};

/// What the place is worth when one beacon falls silent.
struct BeaconLoss {
  std::string beacon;
  double covered_fraction = 0.0;      ///< of the calibrated area: where a fix is still possible
  std::optional<double> median, p95;  ///< of the figure that the map shows, where it is covered
  std::optional<NamedMap> map;
};

/// A beacon that was found elsewhere than where the site file has it: how wrong the tape was.
struct MovedNote {
  std::string beacon;
  std::array<std::optional<double>, 3> shift_m;  ///< found less stated, where something was stated
  double sigma_m = 0.0;                          ///< largest of what was found, of the stated axes
  std::optional<double> stated_sigma_m;          ///< largest that the site file states
  double distance_m = 0.0;                       ///< over the stated axes
};

enum class Outcome {
  kCalibrated,
  kRefused,  ///< the data cannot tell; nothing was exported
  kNotConverged
};

/// All that a report says, as plain values.
struct ReportInput {
  std::string kind = "Calibration";  ///< of report: "Calibration", "Survey", "Verification"
  Outcome outcome = Outcome::kCalibrated;
  std::string message;  ///< of the solver, where there is something to say
  PlanInput plan;
  std::vector<BeaconNote> beacons;
  std::vector<MovedNote> moved;  ///< farthest first
  std::vector<WeakNote> weak;
  std::vector<LeftOutNote> left_out;
  std::vector<StopNote> stops;   ///< of many those that stick out
  std::vector<PlanMiss> misses;  ///< those of one place together
  std::vector<ResidualChart> residuals;
  std::optional<Histogram> standardised;  ///< residuals over their sigmas
  std::size_t looked_at = 0;              ///< arrivals that residuals and redundancies are of
  std::optional<Evaluation> evaluation;
  std::optional<BeaconLoss> no_loss;  ///< all beacons at work
  std::vector<BeaconLoss> losses;     ///< worst first; their figure is loss_name
  std::string loss_name, loss_unit;
  std::optional<Changes> changes;  ///< since an earlier deployment
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> words;  ///< of the report, each with what it means
  std::string command;                                     ///< that wrote this report
  std::vector<std::string> options;                        ///< in words, beside the command: "threads 2"
};

enum class Grade {
  kGood,
  kUnjudged,      ///< nothing is wrong, but the site states no tolerance to hold it against
  kPoor,          ///< a gate is not kept
  kContradicted,  ///< the data speak against what the site file states
  kRefused        ///< nothing was exported
};
[[nodiscard]] const char* to_string(Grade grade);
/// The colour that says what the grade says.
[[nodiscard]] Tone tone_of(Grade grade);

/// One thing that must hold, with its figures in words.
struct ReportGate {
  std::string name, value, limit;
  bool pass = false;
};

/// What to think of it.
struct Verdict {
  Grade grade = Grade::kUnjudged;
  std::string sentence;
  std::vector<ReportGate> gates;
};
[[nodiscard]] Verdict verdict(const ReportInput& input);

/// What to do or to measure next, most urgent first; never empty.
[[nodiscard]] std::vector<std::string> next_steps(const ReportInput& input);

/// "343.21 m/s, sigma 0.04 m/s, at 21 degC (model cramer1993)".
[[nodiscard]] std::string speed_in_words(const Deployment& deployment);
/// "3 dB less at 22.5 degrees off the axis, sigma 0.1 degrees". @param deployment  with a directional
/// attenuation
[[nodiscard]] std::string directivity_in_words(const Deployment& deployment);

/// The report's content: verdict, plan, beacons, verification, residuals, weak directions, loss of a beacon,
/// changes, what next, provenance. Sections of which nothing is known are left out.
[[nodiscard]] ReportDocument report_document(const ReportInput& input);

struct ReportOptions {
  bool interactive = true;  ///< with plotly.js inside, where it was at hand when the program was built
};
/// The report as one self-contained HTML page: nothing is fetched (content security policy `default-src
/// 'none'`), whole without a script, light and dark, prints on paper.
[[nodiscard]] std::string report_html(const ReportInput& input, const ReportOptions& options = {});
/// The same content without the drawings.
[[nodiscard]] std::string report_markdown(const ReportInput& input);

}  // namespace octant::survey

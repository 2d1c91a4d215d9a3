// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/octant/session.h"
#include "calib/calibrate.h"
#include "io/run/run_folder.h"
#include "models/deployment.h"
#include "models/localizers/methods.h"
#include "models/localizers/speed/run_speed.h"
#include "models/run.h"
#include "models/simulator/synthetic.h"
#include "models/support/result.h"
#include "survey/evaluate.h"
#include "survey/report/report.h"

namespace octant::app {

class ProgressReporter;

/// Speed that converts a column distance_m of tof.csv; 0 for a medium without a constant speed, which does
/// not allow this column.
[[nodiscard]] inline double constant_speed_mps(const Medium& medium) {
  return medium.model == MediumModel::kConstant ? medium.speed_mps : 0.0;
}

/// Reads a deployment. With a trusted key, it must be signed by the owner of the key. Fails on read errors, a
/// missing signature, or another key.
[[nodiscard]] Result<Deployment> read_trusted_deployment(const std::string& path,
                                                         const std::string& trusted_key);

/// Warns about recordings given twice, which would make sigmas too small.
void warn_of_repeated_runs(const std::vector<std::string>& folders, Session& session);
/// Reads recordings in order; warnings go to the session.
[[nodiscard]] std::vector<MeasurementLog> read_runs(const std::vector<std::string>& folders,
                                                    const NameTable& names, const Timing& timing,
                                                    io::ReadRunOptions options, Session& session);
/// @param of  site or deployment that provides names, timing and medium
template <class SiteOrDeployment>
[[nodiscard]] std::vector<MeasurementLog> read_runs(const std::vector<std::string>& folders,
                                                    const SiteOrDeployment& of, io::ReadRunOptions options,
                                                    Session& session) {
  options.constant_speed_mps = constant_speed_mps(of.medium);
  return read_runs(folders, names_of(of), of.timing, options, session);
}

/// Ranges between beacons of several recordings; warnings go to the session.
struct BeaconFlights {
  std::vector<BeaconFlight> flights;
  std::vector<InputDigest> inputs;
};
[[nodiscard]] BeaconFlights read_beacon_flights(const std::vector<std::string>& folders,
                                                const NameTable& names, Session& session);

/// Simulates the world of a scenario; its true deployment records the program and command.
[[nodiscard]] World simulated(const Scenario& scenario, const Session& session);
/// Writes a simulated world as a complete folder, or not at all: site.yaml, run/, heldout/,
/// deployment.true.json and the text of the scenario. Replaces an older world in this folder, but refuses
/// folders with other content.
/// @param may_replace  names of further files that may be removed
void write_world(const std::string& folder, const World& world, std::string_view scenario_text,
                 const std::vector<std::string>& may_replace = {});

/// A calibration with all its results.
struct Calibration : calib::Calibration {
  bool accepted = false;  ///< exported with a mark in spite of contradictions
  /// Returns true if the deployment is to be written.
  [[nodiscard]] bool exported() const { return deployment && (accepted || solution.contradictions.empty()); }
};
struct CalibrateOptions {
  bool strict = false;           ///< refuses the calibration for a single undetermined beacon
  bool accept = false;           ///< exports deployments with contradictions, marked as such
  std::size_t memory_mb = 1500;  ///< larger recordings are streamed
};
/// Fails on read errors and interruption; numerical failures are part of the solution.
[[nodiscard]] Calibration calibrate_files(const std::string& site, const std::vector<std::string>& runs,
                                          const CalibrateOptions& options, Session& session);
/// Calibrates recordings in memory; otherwise as calibrate_files().
/// @param site_sha256  of the site's text
[[nodiscard]] Calibration calibrate_runs(Site site, std::vector<MeasurementLog> runs,
                                         const std::string& site_sha256, const CalibrateOptions& how,
                                         Session& session, BeaconFlights between_beacons = {});
/// Solver options with the session's threads, progress output and interruption.
/// @param reporter  must outlive the options  @param share  share of the whole progress that the adjustment
/// represents
[[nodiscard]] calib::SolveOptions solve_options(const Session& session, ProgressReporter& reporter,
                                                double share = 1.0);
/// JSON list of weak directions for `calibrate` and `check`.
[[nodiscard]] Json weak_json(const std::vector<calib::WeakDirection>& weak);
/// JSON object of `octant calibrate`.
[[nodiscard]] Json calibration_json(const Calibration& calibration, const Session& session);
/// Adds speed, beacons, receivers and attenuation of a deployment, for calibrate and recalibrate.
void add_deployment_json(const Deployment& deployment, Json& object);
/// Reason for which there is no deployment or it cannot be trusted; no value for success.
[[nodiscard]] std::optional<Failure> failure_of(const Calibration& calibration);
/// Warns if a deployment was exported although its data contradict its site file.
void warn_if_contradicted(const Deployment& deployment, const std::string& path, Session& session);
/// Rejected arrivals and rows, by reason and by beacon.
[[nodiscard]] Json left_out_json(const Calibration& calibration);
[[nodiscard]] std::vector<survey::LeftOutNote> left_out_by_reason(const Calibration& calibration);
/// Redundancy numbers, detectable biases, ellipses, variance components, residuals by group; null without a
/// covariance.
[[nodiscard]] Json reliability_json(const Calibration& calibration);
/// Tables for people.
[[nodiscard]] std::string calibration_text(const Calibration& calibration);
[[nodiscard]] std::string reliability_text(const Calibration& calibration);

/// Fixes of several recordings.
struct Localization {
  std::vector<Fix> fixes;             ///< fixes of all runs, one run after the other
  std::vector<std::size_t> run_ends;  ///< end of each run's fixes
  std::string method;                 ///< methods that were used, joined by '+' if they differ
  std::string why;                    ///< reason for the choice by Method::kAuto
  std::size_t ok = 0, no_fix = 0, arrivals = 0, rejected = 0;
  std::map<std::string, std::size_t> no_fix_reasons;
  std::map<std::string, std::size_t> degraded_reasons;  ///< reasons of fixes without a bounded error
  std::string no_levels;  ///< methods without protection levels, with the reason
  /// Estimated speed of each run at an unknown temperature. No value if the temperature is known or the
  /// method does not use single arrivals.
  std::vector<std::optional<RunSpeed>> speeds;
  void add_run(std::vector<Fix> fixes_of_run);
  [[nodiscard]] std::span<const Fix> of_run(std::size_t run) const;
  [[nodiscard]] std::size_t degraded() const;  ///< number of kOk fixes that are degraded
};
/// Number of fixes with a bounded error, and reasons of the others, as a line and as an object.
[[nodiscard]] std::string integrity_text(const Localization& localization);
[[nodiscard]] Json integrity_json(const Localization& localization);

/// Localizes all runs with a method. A run at an unknown temperature uses the speed estimated from its
/// arrivals if that differs from the deployment's (run_speed.h). Fails with the name of a run that the method
/// cannot process.
[[nodiscard]] Result<Localization> localize_runs(const Deployment& deployment,
                                                 const std::vector<MeasurementLog>& runs, Method method,
                                                 const MethodInput& input = {});

/// Arrivals of a beacon at stops with a fix.
struct LeftOutOfBeacon {
  std::string name;
  std::size_t heard = 0, left_out = 0;
};
/// In the order of the deployment. Drives, and methods that do not use single arrivals, are not counted.
[[nodiscard]] std::vector<LeftOutOfBeacon> left_out_by_beacon(const Deployment& deployment,
                                                              const std::vector<MeasurementLog>& runs,
                                                              const Localization& localization);
/// Names the beacons that lost most of their arrivals; empty if there are none. {arrivals: {by_beacon: {id:
/// count}}}.
[[nodiscard]] std::string left_out_text(const std::vector<LeftOutOfBeacon>& beacons);
[[nodiscard]] Json left_out_json(const std::vector<LeftOutOfBeacon>& beacons);

/// Fails if a run has no reference.
void check_truth(const std::vector<MeasurementLog>& runs);
/// Compares the fixes of the vehicle that truth.tum belongs to with it.
[[nodiscard]] survey::Evaluation verify_fixes(const Deployment& deployment,
                                              const std::vector<MeasurementLog>& runs,
                                              const Localization& localization);
[[nodiscard]] Json gates_json(const std::vector<survey::Gate>& gates);
[[nodiscard]] Json evaluation_json(const survey::Evaluation& evaluation);
[[nodiscard]] std::string evaluation_text(const survey::Evaluation& evaluation,
                                          const Localization& localization);
/// The runs whose arrivals, bearings or scans are among the inputs of the calibration, by their digests.
[[nodiscard]] std::vector<std::string> runs_of_calibration(const Deployment& deployment,
                                                           const std::vector<MeasurementLog>& runs);
/// The reason of most epochs without a fix, as the end of a sentence, with what to do.
[[nodiscard]] std::string why_no_fix(const Localization& localization);
/// Warning that the sigmas of the fixes are too small: the mean NEES exceeds its quantile of 99.9 % even if
/// all fixes shared one error (chi-square of a single fix). Empty otherwise.
[[nodiscard]] std::string doubt_of_sigmas(const survey::Evaluation& evaluation, Motion motion);
/// Number of epochs without a fix, by reason.
[[nodiscard]] Json no_fix_json(const Localization& localization);
/// Reason for which no fix could be compared with the reference: no fixes, with their reasons, or none within
/// the time span of the reference.
[[nodiscard]] std::string unmatched_text(const Localization& localization);

struct CheckArgs {
  std::string site;
  std::vector<std::string> runs;
  bool strict = false;  ///< a single undetermined beacon is exit 5
};
/// Implements `octant check`.
int check_recordings(const CheckArgs& args, Session& session);
/// Checks recordings in memory.
int check_recordings(Site site, std::vector<MeasurementLog> runs, bool strict, Session& session);

/// Possible reasons for a lack of fixes, one sentence each: tof_s in a unit other than seconds (judged as in
/// calibrate and monitor), rows without epochs in which no two beacons occur together, or the same epoch in
/// all rows.
/// @param rows          rows of a recording, or the first ones of a stream
/// @param pose_by_pose  true if each pose depends on its own arrivals, so that epochs matter
[[nodiscard]] std::vector<std::string> doubts_about(const Deployment& deployment, const MeasurementLog& rows,
                                                    bool pose_by_pose);

}  // namespace octant::app

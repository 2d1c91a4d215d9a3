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

/// At which a column distance_m of tof.csv is read; 0 where the medium's speed is not constant, and there may
/// be none.
[[nodiscard]] inline double constant_speed_mps(const Medium& medium) {
  return medium.model == MediumModel::kConstant ? medium.speed_mps : 0.0;
}

/// A deployment; with a trusted key only one that its owner signed. Failures: those of reading, of an
/// unsigned one, of another key.
[[nodiscard]] Result<Deployment> read_trusted_deployment(const std::string& path,
                                                         const std::string& trusted_key);

/// A recording that is named twice makes sigmas smaller than they are.
void warn_of_repeated_runs(const std::vector<std::string>& folders, Session& session);
/// Reads recordings in order; warnings go to the session.
[[nodiscard]] std::vector<MeasurementLog> read_runs(const std::vector<std::string>& folders,
                                                    const NameTable& names, const Timing& timing,
                                                    io::ReadRunOptions options, Session& session);
/// @param of  site or deployment that tells names, timing and medium
template <class SiteOrDeployment>
[[nodiscard]] std::vector<MeasurementLog> read_runs(const std::vector<std::string>& folders,
                                                    const SiteOrDeployment& of, io::ReadRunOptions options,
                                                    Session& session) {
  options.constant_speed_mps = constant_speed_mps(of.medium);
  return read_runs(folders, names_of(of), of.timing, options, session);
}

/// The world of a scenario, whose true deployment says what made it.
[[nodiscard]] World simulated(const Scenario& scenario, const Session& session);
/// Writes a simulated world as a folder that is complete or not there: site.yaml, run/, heldout/,
/// deployment.true.json and the scenario's text. An older world of the same place is replaced; a folder that
/// holds anything else is refused.
/// @param may_replace  names of further files that may lie there and are dropped
void write_world(const std::string& folder, const World& world, std::string_view scenario_text,
                 const std::vector<std::string>& may_replace = {});

/// A calibration with all that is said of it.
struct Calibration {
  calib::Problem problem;
  calib::Solution solution;
  std::optional<Deployment> deployment;  ///< where the solver converged
  calib::Provenance provenance;
  bool accepted = false;  ///< to be exported, marked, although the data contradict what was stated
  /// Whether the deployment is to be written.
  [[nodiscard]] bool exported() const { return deployment && (accepted || solution.contradictions.empty()); }
};
struct CalibrateOptions {
  bool strict = false;           ///< a single undetermined beacon refuses the whole
  bool accept = false;           ///< exports, marked, what the data contradict
  std::size_t memory_mb = 1500;  ///< recordings that would take more are streamed
};
/// Failures of reading, interruption; numerical trouble is in the solution.
[[nodiscard]] Calibration calibrate_files(const std::string& site, const std::vector<std::string>& runs,
                                          const CalibrateOptions& options, Session& session);
/// Options of an adjustment on the session's threads that shows how far it is and ends with an interruption.
/// @param reporter  must outlive them  @param share  of what it shows, that the adjustment is
[[nodiscard]] calib::SolveOptions solve_options(const Session& session, ProgressReporter& reporter,
                                                double share = 1.0);
/// The list of weak directions, as `calibrate` and `check` have it.
[[nodiscard]] Json weak_json(const std::vector<calib::WeakDirection>& weak);
/// The object of `octant calibrate`.
[[nodiscard]] Json calibration_json(const Calibration& calibration, const Session& session);
/// Speed, beacons, receivers and attenuation of a deployment, as calibrate and recalibrate have them.
void add_deployment_json(const Deployment& deployment, Json& object);
/// Why there is no deployment, or none that is to be trusted; none where all is well.
[[nodiscard]] std::optional<Failure> failure_of(const Calibration& calibration);
/// Says that a deployment was exported although its data contradict its site file.
void warn_if_contradicted(const Deployment& deployment, const std::string& path, Session& session);
/// Arrivals and rows left out, by reason and by beacon.
[[nodiscard]] Json left_out_json(const Calibration& calibration);
[[nodiscard]] std::vector<survey::LeftOutNote> left_out_by_reason(const Calibration& calibration);
/// Redundancy numbers, detectable biases, ellipses, variance components, residuals by group; null without a
/// covariance.
[[nodiscard]] Json reliability_json(const Calibration& calibration);
/// Tables for people.
[[nodiscard]] std::string calibration_text(const Calibration& calibration);
[[nodiscard]] std::string reliability_text(const Calibration& calibration);

/// Fixes of some recordings.
struct Localization {
  std::vector<Fix> fixes;             ///< of all runs, one run after the other
  std::vector<std::size_t> run_ends;  ///< up to where those of each run are
  std::string method;                 ///< as used; joined by '+' where recordings differ
  std::string why;                    ///< of Method::kAuto: why these
  std::size_t ok = 0, no_fix = 0, arrivals = 0, rejected = 0;
  std::map<std::string, std::size_t> no_fix_reasons;
  std::map<std::string, std::size_t> degraded_reasons;  ///< of fixes whose error nothing bounds
  std::string no_levels;  ///< of methods without protection levels: which, and why
  /// Of each run at an unknown temperature; none where the temperature is known or the method takes no
  /// arrivals one by one.
  std::vector<std::optional<RunSpeed>> speeds;
  void add_run(std::vector<Fix> fixes_of_run);
  [[nodiscard]] std::span<const Fix> of_run(std::size_t run) const;
  [[nodiscard]] std::size_t degraded() const;  ///< of the fixes that are ok
};
/// How many fixes have an error that is bounded, and why the others do not: a line, an object.
[[nodiscard]] std::string integrity_text(const Localization& localization);
[[nodiscard]] Json integrity_json(const Localization& localization);

/// Fixes of all runs by a method, at the speed that a run's arrivals tell where its temperature is not known
/// and that is another one than the deployment's (run_speed.h). Errors: a run for which the method is not
/// made, named.
[[nodiscard]] Result<Localization> localize_runs(const Deployment& deployment,
                                                 const std::vector<MeasurementLog>& runs, Method method,
                                                 const MethodInput& input = {});

/// Arrivals of a beacon at stops that have a fix.
struct LeftOutOfBeacon {
  std::string name;
  std::size_t heard = 0, left_out = 0;
};
/// In the deployment's order. Drives, and methods that take no arrivals one by one, count for nothing.
[[nodiscard]] std::vector<LeftOutOfBeacon> left_out_by_beacon(const Deployment& deployment,
                                                              const std::vector<MeasurementLog>& runs,
                                                              const Localization& localization);
/// A line that names those that lost most of theirs; empty: none did. {arrivals: {by_beacon: {id: count}}}.
[[nodiscard]] std::string left_out_text(const std::vector<LeftOutOfBeacon>& beacons);
[[nodiscard]] Json left_out_json(const std::vector<LeftOutOfBeacon>& beacons);

/// Fails where a run has no reference.
void check_truth(const std::vector<MeasurementLog>& runs);
/// Fixes of the vehicle that truth.tum follows against it.
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
/// That the fixes' stated sigmas do not hold: the mean NEES is beyond what it would be once in a thousand
/// times even if all fixes shared one error (chi-square of a single fix). Empty where they may hold.
[[nodiscard]] std::string doubt_of_sigmas(const survey::Evaluation& evaluation, Motion motion);
/// How often there was no fix, by reason.
[[nodiscard]] Json no_fix_json(const Localization& localization);
/// Why no fix could be held against the reference: there was none, and for what reasons, or none where the
/// reference is.
[[nodiscard]] std::string unmatched_text(const Localization& localization);

struct CheckArgs {
  std::string site;
  std::vector<std::string> runs;
  bool strict = false;  ///< a single undetermined beacon is exit 5
};
/// All of `octant check` behind its words.
int check_recordings(const CheckArgs& args, Session& session);

/// Why arrivals may give no fix at all, a sentence each: tof_s in another unit than seconds (as calibrate and
/// monitor judge it); rows without an epoch of which no two beacons' come together; one epoch for all.
/// @param rows          of a recording, or the first ones of a stream
/// @param pose_by_pose  each pose hangs on its own arrivals: epochs matter
[[nodiscard]] std::vector<std::string> doubts_about(const Deployment& deployment, const MeasurementLog& rows,
                                                    bool pose_by_pose);

}  // namespace octant::app

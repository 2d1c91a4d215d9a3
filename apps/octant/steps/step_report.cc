// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Converts the results of a calibration into the plain values of a report.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>

#include "apps/octant/steps/reporting.h"
#include "calib/calibrate.h"
#include "survey/drawing/plan_frame.h"

namespace octant::app {
namespace {

/// Range and bin width of the histogram of standardised residuals.
constexpr double kFarthest_sigmas = 6.0, kBin_sigmas = 0.25;

double finite(double value) { return std::isfinite(value) ? value : 0.0; }
std::optional<double> finite(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? value : std::nullopt;
}

survey::ResidualChart chart(const char* by, const char* unit, const std::vector<calib::ResidualGroup>& groups,
                            double per_si = 1.0) {
  survey::ResidualChart out{by, unit, {}};
  for (const auto& g : groups)
    if (g.count > 0)
      out.bins.push_back({g.name, per_si * finite(g.from), per_si * finite(g.to), g.count, finite(g.mean_s),
                          finite(g.rms_s)});
  return out;
}

void add_residuals(const calib::Reliability& r, survey::ReportInput& input) {
  if (!r.ok || r.arrivals.empty()) return;
  input.looked_at = r.arrivals.size();
  input.residuals.push_back(chart("beacon", "", r.by_beacon));
  input.residuals.push_back(chart("distance", "m", r.by_distance));
  input.residuals.push_back(chart("incidence", "deg", r.by_incidence, 180 / M_PI));
  if (!r.by_temperature.empty()) input.residuals.push_back(chart("temperature", "degC", r.by_temperature));
  input.residuals.push_back(chart("time", "s", r.by_time));
  survey::Histogram h{
      -kFarthest_sigmas, kBin_sigmas,
      std::vector<std::size_t>(static_cast<std::size_t>(2 * kFarthest_sigmas / kBin_sigmas), 0)};
  for (const auto& a : r.arrivals) {
    if (!a.controlled || !std::isfinite(a.w)) continue;
    const double bin = std::floor((a.w + kFarthest_sigmas) / kBin_sigmas);
    ++h.counts[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(h.counts.size() - 1)))];
  }
  input.standardised = std::move(h);
}

void add_beacon_notes(const calib::Reliability& r, survey::ReportInput& input) {
  for (const auto& b : r.beacons) {
    survey::BeaconNote note{b.name,
                            b.used,
                            b.late + b.early + b.other,
                            finite(b.mean_redundancy),
                            {},
                            finite(b.component.factor),
                            finite(b.mdb_median_s),
                            finite(b.influence_worst_m),
                            finite(b.lateness_mdb_s),
                            finite(b.lateness_influence_m)};
    if (b.used > 0) note.rms_s = finite(b.rms_s);
    input.beacons.push_back(std::move(note));
  }
}

/// Partial result for a site that was refused: beacons that the data determine, with the others undetermined.
Deployment partial_deployment(const Calibration& c) {
  const calib::Solution& s = c.solution;
  const Site& site = c.problem.site;
  const bool solved = s.beacon_status.size() == site.beacons.size() &&
                      s.state.beacon_p_map_m.size() == site.beacons.size() &&
                      s.state.beacon_delay_s.size() == site.beacons.size() &&
                      s.state.receiver_p_vehicle_m.size() == site.receivers.size() &&
                      s.state.receiver_delay_s.size() == site.receivers.size() &&
                      !s.state.speed_offset_mps.empty() && s.covariance.matrix.allFinite();
  Deployment d;
  if (solved) {
    d = calib::make_deployment(c.problem, s, c.provenance);
  } else {
    d = calib::deployment_head(site, s, c.provenance);
    for (const auto& b : site.beacons) {
      DeploymentBeacon beacon;
      beacon.name = b.name;
      beacon.status = b.is_control_point() ? BeaconStatus::kControlPoint : BeaconStatus::kUndetermined;
      if (b.is_control_point()) beacon.position_m = {*b.position_m[0], *b.position_m[1], *b.position_m[2]};
      d.beacons.push_back(std::move(beacon));
    }
  }
  for (auto& b : d.beacons) {
    // A beacon with an uncertainty as large as the site is unknown.
    const bool known = b.position_m.allFinite() && b.covariance_m2.allFinite() &&
                       b.covariance_m2.trace() < std::pow(c.problem.typical_range_m, 2) &&
                       std::isfinite(b.delay_s) && std::isfinite(b.delay_sigma_s);
    if (known) continue;
    b.status = BeaconStatus::kUndetermined;
    b.position_m.setZero();
    b.covariance_m2.setZero();
    b.delay_s = b.delay_sigma_s = 0.0;
  }
  auto& st = d.statistics;
  st.converged = false;
  for (double* value : {&st.redundancy, &st.variance_factor, &st.chi2_p, &st.rms_s, &d.speed_offset_mps,
                        &d.speed_sigma_mps, &d.noise.tof_sigma_s})
    *value = finite(*value);
  return d;
}

std::vector<std::string> options_in_words(const Session& session) {
  return {fmt::format("threads {}, seed {}", session.threads(), session.options.seed),
          fmt::format("Eigen {}.{}.{}, compiler {}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                      EIGEN_MINOR_VERSION, __VERSION__)};
}

}  // namespace

survey::ReportInput report_input(const Calibration& c, const Session& session) {
  survey::ReportInput input;
  const calib::Solution& s = c.solution;
  input.outcome = c.deployment                                    ? survey::Outcome::kCalibrated
                  : s.status == calib::SolveStatus::kUndetermined ? survey::Outcome::kRefused
                                                                  : survey::Outcome::kNotConverged;
  input.message = s.message;
  input.plan.deployment = c.deployment ? *c.deployment : partial_deployment(c);
  for (const auto& trajectory : s.trajectories) {
    survey::Track track;
    track.moving = trajectory.moving;
    for (const auto& node : trajectory.nodes)
      if (node.placed) track.points_m.push_back(node.T_map_vehicle.translation_m);
    track.thinned_from = track.points_m.size();
    track.points_m = survey::thinned(track.points_m);
    input.plan.tracks.push_back(std::move(track));
  }
  if (c.deployment) input.moved = moved_from_site(c);
  for (const auto& weak : s.weak)
    input.weak.push_back(
        {weak.description, weak.remedy, finite(weak.consequence_m), weak.blocking, weak.lone_beacon});
  input.left_out = left_out_by_reason(c);
  add_beacon_notes(s.reliability, input);
  add_residuals(s.reliability, input);
  input.warnings = session.warnings();
  input.command = session.command_line;
  input.options = options_in_words(session);
  return input;
}

survey::ReportInput report_input(const Deployment& deployment, const Session& session) {
  survey::ReportInput input;
  input.plan.deployment = deployment;
  input.warnings = deployment.warnings;
  input.command = session.command_line;
  input.options = options_in_words(session);
  return input;
}

}  // namespace octant::app

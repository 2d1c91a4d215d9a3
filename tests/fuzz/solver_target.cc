// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/solver_target.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "calib/calibrate.h"
#include "io/deployment/deployment_json.h"
#include "models/localizers/methods.h"
#include "tests/fuzz/must.h"
#include "tests/fuzz/small_world.h"

namespace octant::fuzz {
namespace {

using calib::Solution;
using calib::SolveStatus;

/// Rounding of the eigenvalues of a correlation matrix, of some tens of parameters.
constexpr double kRounding = 1e-6;

void must_be_covariance(const Eigen::MatrixXd& C, const char* of_what) {
  if (C.size() == 0) return;
  must(C.allFinite(), of_what);
  must((C.diagonal().array() >= 0).all(), of_what);
  const Eigen::VectorXd scale =
      (C.diagonal().array() > 0).select(C.diagonal().cwiseSqrt().cwiseInverse(), 0.0);
  const Eigen::MatrixXd correlation = scale.asDiagonal() * C * scale.asDiagonal();
  must((correlation - correlation.transpose()).cwiseAbs().maxCoeff() < kRounding, of_what);
  must(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation, Eigen::EigenvaluesOnly)
               .eigenvalues()
               .minCoeff() > -kRounding,
       of_what);
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}
bool all_finite(const std::vector<Eigen::Vector3d>& values) {
  return std::all_of(values.begin(), values.end(), [](const Eigen::Vector3d& v) { return v.allFinite(); });
}

/// Finite numbers, for any outcome.
void must_be_numbers(const Solution& s) {
  const SharedState& x = s.state;
  must(all_finite(x.beacon_p_map_m) && all_finite(x.receiver_p_vehicle_m), "positions are finite");
  must(all_finite(x.beacon_delay_s) && all_finite(x.receiver_delay_s) && std::isfinite(x.site_delay_s) &&
           all_finite(x.pair_bias_s) && all_finite(x.clock_drift),
       "delays are finite");
  must(all_finite(x.speed_offset_mps) && all_finite(x.beacon_log_gain), "speed and gains are finite");
  must(!s.covariance.matrix.hasNaN() && !s.white_covariance.matrix.hasNaN(), "no covariance is NaN");
  for (const Trajectory& t : s.trajectories)
    for (const Node& node : t.nodes)
      must(node.T_map_vehicle.translation_m.allFinite() && node.T_map_vehicle.rotation.coeffs().allFinite(),
           "poses are finite");
  const CalibrationStatistics& n = s.statistics;
  must(std::isfinite(n.redundancy) && std::isfinite(n.variance_factor) && n.variance_factor >= 0 &&
           n.chi2_p >= 0 && n.chi2_p <= 1 && std::isfinite(n.rms_s) && n.rms_s >= 0,
       "statistics are numbers");
  must(std::isfinite(s.final_cost) && s.final_cost >= 0, "the cost is a number");
}

/// The numbers agree with the status.
void must_agree(const calib::Problem& problem, const Solution& s) {
  must(!s.message.empty(), "the outcome has words");
  must(s.statistics.arrivals + s.statistics.rejected <= problem.runs[0].rows, "no arrival counts twice");
  const bool blocked =
      std::any_of(s.weak.begin(), s.weak.end(), [](const calib::WeakDirection& w) { return w.blocking; });
  if (s.status == SolveStatus::kUndetermined)
    must(blocked || !s.undetermined.empty(), "what is undetermined has a name");
  if (s.status != SolveStatus::kConverged) return;
  must(!blocked, "nothing that blocks is exported");
  must(s.statistics.converged, "it converged");
  must(s.beacon_status.size() == problem.site.beacons.size(), "every beacon has a status");
  must_be_covariance(s.covariance.matrix, "the joint covariance is one");
  must_be_covariance(s.white_covariance.matrix, "that of white noise is one");
  for (std::size_t b = 0; b < s.beacon_status.size(); ++b)
    must((s.beacon_status[b] == BeaconStatus::kControlPoint) == problem.site.beacons[b].is_control_point(),
         "control points are those of the site");
}

/// A robot can do something with it.
void must_serve(const calib::Problem& problem, const Solution& s) {
  const Deployment deployment = calib::make_deployment(
      problem, s, {.created = "2026-01-01T00:00:00Z", .version = "0", .command = "", .inputs = {}});
  for (const DeploymentBeacon& b : deployment.beacons)
    must_be_covariance(b.covariance_m2, "a beacon's is one");
  const auto text = io::checked_deployment_json("d.json", deployment);
  must(text.has_value(), "a deployment is written");
  const auto again = io::deployment_from_json(*text, "d.json");
  must(again.has_value(), "and reads back");
  const auto fixes = locate_run(Method::kAuto, *again, problem.runs[0]);
  must_explain(fixes);
  if (!fixes) return;
  for (const Fix& fix : *fixes) {
    if (!fix.ok()) continue;
    must(fix.T_map_vehicle.translation_m.allFinite() && fix.T_map_vehicle.rotation.coeffs().allFinite(),
         "a fix is a place");
    must_be_covariance(fix.covariance, "of a known accuracy");
    must(std::isfinite(fix.protection_level_m) && fix.protection_level_m >= 0, "and protected or not");
  }
}

}  // namespace

void take_solver(std::string_view input) {
  auto world = small_world(input);
  if (!world) return;
  auto problem = calib::make_problem(std::move(world->site), {std::move(world->run)});
  must_explain(problem);
  if (!problem) return;
  const Solution solution = calib::solve(*problem);
  must_be_numbers(solution);
  must_agree(*problem, solution);
  if (solution.status == SolveStatus::kConverged) must_serve(*problem, solution);
}

}  // namespace octant::fuzz

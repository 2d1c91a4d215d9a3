// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/visit_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/errors/statistics.h"
#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
#include "calib/revisit/revisited_site.h"
#include "calib/start/approach.h"
#include "calib/start/start.h"
#include "calib/verdict/conclude.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Least uncertainty of ranges while states are solved with the earlier parameters.
constexpr double kRangeUncertainty_m = 0.05;
constexpr double kRangeSigmas = 5.0;
constexpr std::size_t kFewestRanges = 10;  ///< least number of ranges that locate a beacon

}  // namespace

void VisitFit::set_start(const Problem& problem, const SharedState& state, std::vector<bool> usable,
                         std::vector<Trajectory> trajectories) {
  now = {};
  now.layout = make_layout(problem, state, usable);
  now.fit.problem = without_recordings(problem);
  now.fit.x = now.layout.vector_of(state);
  now.fit.layout = now.layout;
  now.fit.beacon_usable = std::move(usable);
  now.fit.trajectories = std::move(trajectories);
  now.sigma_s = stated_sigma_s_ = problem.site.noise.tof_sigma_s;
}

bool VisitFit::start_from_known(const Problem& problem) {
  std::vector<bool> usable;
  for (const DeploymentBeacon& b : before_.beacons) usable.push_back(b.status != BeaconStatus::kUndetermined);
  set_start(problem, shared_state(before_), std::move(usable), problem.trajectories);
  static_cast<void>(place_missing());
  return std::ranges::any_of(now.fit.trajectories,
                             [](const Trajectory& t) { return std::ranges::any_of(t.nodes, &Node::placed); });
}

Solution VisitFit::start_from_consensus(const Problem& problem, ProgressMonitor& monitor) {
  Approach found = approach(problem, options_, monitor, false);
  if (!found.ok) return std::move(found.why_not);
  const SharedState state = found.estimate.state();
  set_start(problem, state, std::move(found.estimate.beacon_usable), std::move(found.trajectories));
  const double factor = agreeing_sigma(now.fit.trajectories, state);
  if (is_far_off(factor)) scale_noise(factor);
  Solution ok;
  ok.status = SolveStatus::kConverged;
  return ok;
}

bool VisitFit::place_missing() {
  const EpochFixModel model = search_model(now.fit.problem, now.fit.state(), now.fit.beacon_usable);
  const double uncertainty_m = std::max(kRangeUncertainty_m, kRangeSigmas * now.sigma_s * known_.speed_mps);
  std::size_t placed = 0;
  for (Trajectory& t : now.fit.trajectories)
    placed += place_states(t, model, uncertainty_m, false, 0.0, options_.threads);
  return placed > 0;
}

void VisitFit::put(std::size_t b, const Eigen::Vector3d& p_map_m) {
  now.layout.set_place(b, p_map_m, now.fit.x);
  if (const int c = now.layout.column_of(parameters::beacon_delay(b)); c >= 0)
    now.fit.x[c] = before_.beacons[b].delay_s / now.layout.parameter(c).si_per_unit;
}

bool VisitFit::locate_lost() {
  bool any = false;
  const std::vector<RejectionCounts> counts =
      rejections_by_beacon(now.fit.trajectories, before_.beacons.size());
  const SharedState state = now.fit.state();
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const std::size_t used = counts[b].of(Rejection::kUsed);
    if (counts[b].outliers() <= std::max(used, kFewestRanges) || now.layout.beacon[b][0] < 0) continue;
    TrilaterationOptions options;
    options.guess = before_.beacons[b].position_m;
    options.scale_m = 0.01 * now.fit.problem.typical_range_m;
    options.above = before_.motion == Motion::kPlanar;
    const Trilateration found = trilaterate(ranges_to(now.fit.trajectories, state, BeaconId(b)), options);
    if (!found.ok) continue;
    any = true;
    put(b, found.p_map_m);
  }
  return any;
}

double VisitFit::shift_of(Eigen::Index i) const {
  const int c = now.layout.column_of(known_.parameters[static_cast<std::size_t>(i)]);
  return c < 0 ? 0.0 : now.fit.x[c] * now.layout.parameter(c).si_per_unit - known_.value[i];
}

Eigen::VectorXd VisitFit::room_around(Eigen::VectorXd room) const {
  for (Eigen::Index i = 0; i < known_.size(); ++i)
    if (room[i] > 0) room[i] = std::max(room[i], std::pow(shift_of(i), 2));
  return room;
}

void VisitFit::move_to(const Eigen::VectorXd& value) {
  for (Eigen::Index i = 0; i < known_.size(); ++i)
    if (const int c = now.layout.column_of(known_.parameters[static_cast<std::size_t>(i)]); c >= 0)
      now.fit.x[c] = value[i] / now.layout.parameter(c).si_per_unit;
}

void VisitFit::solve_all_states(double scale) {
  const SharedState state = now.fit.state();
  for (Trajectory& t : now.fit.trajectories)
    for_each_parallel(t.segments.size(), options_.threads, [&](std::size_t s) {
      if (t.nodes[t.segments[s].first_node].placed) solve_states(t, t.segments[s], state, {scale, scale});
    });
}

double VisitFit::data_cost() const {
  double cost = prior_cost(now.fit.problem, now.fit.layout, now.fit.x);
  const SharedState state = now.fit.state();
  for (const Trajectory& t : now.fit.trajectories)
    for (const Segment& segment : t.segments)
      if (t.nodes[segment.first_node].placed) cost += chain_cost(t, segment, state, {});
  return cost;
}

std::size_t VisitFit::arrival_count() const {
  std::size_t count = 0;
  for (const Trajectory& t : now.fit.trajectories) count += t.arrivals.size();
  return count;
}

void VisitFit::scale_noise(double factor) {
  const double sigma_s = std::max(stated_sigma_s_, factor * now.sigma_s);
  if (sigma_s == now.sigma_s) return;
  rescale_noise(now.fit.trajectories, now.sigma_s, sigma_s);
  now.sigma_s = sigma_s;
}

bool VisitFit::adjust_under(const Eigen::MatrixXd& P, Noise noise) {
  now.fit.layout = now.layout;
  set_joint_prior(now.fit.layout, known_, P);
  const auto adjust_once = [this]() -> std::optional<DataSquares> {
    adjust_anew(options_, now.fit);
    if (!now.fit.ok || !now.fit.x.allFinite()) return {};
    now.statistics = statistics_of(now.fit.problem, now.fit.layout, now.fit.trajectories, now.fit.state(),
                                   now.fit.last.cost, options_.threads);
    const double prior = prior_cost(now.fit.problem, now.fit.layout, now.fit.x);
    return DataSquares{now.fit.last.cost - prior, now.statistics.redundancy};
  };
  const auto adjusted = noise == Noise::kFixed
                            ? adjust_once()
                            : adjust_and_scale_noise(adjust_once, [this](const NoiseFactors& factors) {
                                scale_noise(factors.arrivals);
                              });
  if (!adjusted) message = "the adjustment of the second visit did not converge: " + now.fit.last.message;
  return adjusted.has_value();
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_search.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "models/localizers/start/drive_start.h"
#include "models/localizers/start/stretch_states.h"

namespace octant {
namespace {

constexpr std::size_t kDriveScratchBytes =
    9u << 20;  ///< for two solutions of a full window and their sensitivity to the calibration
constexpr std::size_t kSolutionScratchBytes = 3u << 20;  ///< solving for a window of all its nodes once
constexpr double kFilterWindowGrowth = 1.33;
/// Sigma of an unknown air temperature relative to the deployment's [K].
constexpr double kAirSigma_K = 8.0;
/// Limit of the uncertainty of the position at a start and after a gap, beyond which the filter is not linear
/// and the pose is searched again: a share of the extent of the beacons, and at least this length.
constexpr double kBlindShare = 0.1, kLeastBlind_m = 1.0;
/// Duration of a search after which a start without a confirming beacon is accepted.
constexpr double kLongSearch_s = 5.0;

/// Prior sigma of the speed's offset without a recorded temperature.
double air_sigma_mps(const Deployment& d) {
  if (d.medium.model == MediumModel::kConstant) return 0.0;
  const double degC = d.medium.temperature_degC;
  return kAirSigma_K * std::abs(speed_mps(d.medium, degC + 1.0) - speed_mps(d.medium, degC));
}

double beacons_extent_m(const Deployment& d) {
  Eigen::AlignedBox3d box;
  for (const DeploymentBeacon& b : d.beacons)
    if (b.status != BeaconStatus::kUndetermined) box.extend(b.position_m);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

}  // namespace

DriveSearchOptions drive_search_options(const Deployment& deployment, const TrackerOptions& tracker) {
  return {tracker, tracker.estimate_speed ? air_sigma_mps(deployment) : 0.0,
          std::max(kLeastBlind_m, kBlindShare * beacons_extent_m(deployment))};
}

StateSpace drive_states(const TrajectoryModel& model, Motion motion) {
  StateSpace states = state_space(VehicleId(0), model);
  states.motion = motion;
  states.has_cycle_offset = false;
  states.moving = true;
  return states;
}

template <int kDof>
DriveSearchOf<kDof>::DriveSearchOf(EpochFixModel& model, const CalibrationPart& calibration,
                                   const StateSpace& vehicle, const DriveSearchOptions& options)
    : model_(model),
      calibration_(calibration),
      options_(options),
      window_(vehicle),
      start_calibration_(
          Filter(model, options.tracker.rejection_sigmas, options.tracker.range_uncertainty_m, &calibration)
              .node_calibration_room()),
      scratch_(kDriveScratchBytes),
      solving_(kSolutionScratchBytes) {
  with_all_.reserve(window_.trajectory().nodes.capacity());
  begin(0.0);
}

template <int kDof>
void DriveSearchOf<kDof>::begin(double time_s) {
  window_.begin(time_s);
  next_search_s_ = options_.tracker.start_window_s;
  begun_s_ = time_s;
}

template <int kDof>
bool DriveSearchOf<kDof>::search(bool is_temperature_known, Filter& filter, BeaconBankOf<kDof>& bank,
                                 Filter& work) {
  const double span_s = window_.span_s();
  if (span_s > options_.tracker.max_start_window_s) {
    window_.keep_recent_half();
    next_search_s_ = std::min(next_search_s_, kFilterWindowGrowth * window_.span_s());
  }
  if (span_s < next_search_s_ || window_.last_node() == 0) return false;
  next_search_s_ = kFilterWindowGrowth * span_s;
  const ScratchScope scope(scratch_);
  if (!has_searched_long() && window_.beacons() < kVerifiable) return false;
  base_mps_ = model_.state.speed_offset_mps.front();
  speed_sigma_mps_ = is_temperature_known ? 0.0 : options_.air_sigma_mps;
  const bool found = place() && start_filters(filter, bank, work);
  model_.state.speed_offset_mps.front() = base_mps_;
  return found;
}

/// Returns true if a start without a confirming beacon is accepted: immediately if the site has too few
/// beacons, otherwise after a long search.
template <int kDof>
bool DriveSearchOf<kDof>::has_searched_long() {
  const auto usable = static_cast<std::size_t>(std::ranges::count(model_.beacon_usable, true));
  return usable < kVerifiable || window_.trajectory().nodes.back().time_s - begun_s_ >= kLongSearch_s;
}

/// Searches first with a known speed, then with an unknown offset.
template <int kDof>
bool DriveSearchOf<kDof>::place() {
  Trajectory& t = window_.trajectory();
  const Segment window = window_.all();
  start_speed_ = {{}, PoseTangent::Zero(kDof)};
  TrackerOptions options = options_.tracker;
  bool placed = place_stretch(t, window, model_, options);
  if (!placed && speed_sigma_mps_ > 0.0) {
    options.range_uncertainty_m = std::hypot(options_.tracker.range_uncertainty_m,
                                             range_sigma_of_speed_m(t, window, model_, speed_sigma_mps_));
    placed = place_stretch(t, window, model_, options);
  }
  if (placed && speed_sigma_mps_ > 0.0)
    start_speed_ = fit_start_speed(t, window, model_, speed_sigma_mps_, solving_);
  return placed;
}

template <int kDof>
bool DriveSearchOf<kDof>::start_filters(Filter& filter, BeaconBankOf<kDof>& bank, Filter& work) {
  Trajectory& t = window_.trajectory();
  start_at_end(filter);
  const double uncertainty_m =
      independent_uncertainty_m(t, window_.all(), model_, options_.tracker.range_uncertainty_m);
  filter.set_range_uncertainty(uncertainty_m);
  State farthest = State::Zero();
  const bool verified = is_verified(filter, work, farthest);
  // With few arrivals, an echo of one beacon may have moved the start by that much.
  if (verified) filter.widen(farthest);
  const bool is_linear = filter.is_within(options_.most_place_m, kLinearTurn_rad);
  if (!(verified && is_linear) && !has_searched_long()) return false;
  bank.start(filter, t,
             [this](const DriveMember& member, Filter& without) { start_without(member, without); });
  bank.set_range_uncertainty(uncertainty_m);
  return true;
}

/// Returns true if the start is determined without any one of its beacons.
/// @param farthest  largest deviation of these solutions
template <int kDof>
bool DriveSearchOf<kDof>::is_verified(const Filter& filter, Filter& work, State& farthest) {
  for (std::size_t b = 0; b < model_.beacon_usable.size(); ++b) {
    if (!window_.hears(BeaconId(b))) continue;
    start_without({BeaconId(b), {}}, work);
    if (!(work.covariance().diagonal().template head<2>().maxCoeff() <
          options_.most_place_m * options_.most_place_m))
      return false;
    const State off = filter.difference(work);
    if (off.template head<2>().norm() > farthest.template head<2>().norm()) farthest = off;
  }
  return true;
}

template <int kDof>
void DriveSearchOf<kDof>::start_at_end(Filter& filter) {
  Trajectory& t = window_.trajectory();
  const Segment all = window_.all();
  const std::size_t now = window_.last_node();
  const ChainFactor chain = factor_chain(t, all, model_.state);
  if (chain.ok) node_calibration(t, all, model_.state, chain, calibration_, now, start_calibration_);
  filter.start(t.nodes[now].T_map_vehicle,
               start_covariance(t, all, model_, options_.tracker.range_uncertainty_m, now),
               chain.ok ? &start_calibration_ : nullptr);
  filter.set_speed(start_speed_.speed, start_speed_.by_speed);
}

template <int kDof>
void DriveSearchOf<kDof>::start_without(const DriveMember& member, Filter& filter) {
  const ScratchScope scope(scratch_);
  Trajectory& t = window_.trajectory();
  with_all_ = t.nodes;
  const StartSpeed speed_with_all = start_speed_;
  const double with_all_mps = model_.state.speed_offset_mps.front();
  const Segment all = window_.all();
  const auto mark = [&](Rejection from, Rejection to) {
    for (ArrivalObservation& a : t.arrivals)
      if (member.has(a) && a.rejection == from) a.rejection = to;
  };
  mark(Rejection::kUsed, Rejection::kBeaconFault);
  refine_stretch(t, all, model_, options_.tracker.range_uncertainty_m);
  if (speed_sigma_mps_ > 0.0) {
    model_.state.speed_offset_mps.front() = base_mps_;
    start_speed_ = fit_start_speed(t, all, model_, speed_sigma_mps_, solving_, start_speed_.speed.offset_mps);
  }
  start_at_end(filter);
  start_speed_ = speed_with_all;
  model_.state.speed_offset_mps.front() = with_all_mps;
  mark(Rejection::kBeaconFault, Rejection::kUsed);
  t.nodes = with_all_;
}

template class DriveSearchOf<3>;
template class DriveSearchOf<6>;

}  // namespace octant

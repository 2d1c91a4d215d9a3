// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/speed/run_speed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/make_trajectory.h"
#include "models/validity.h"

namespace octant {
namespace {

constexpr std::size_t kMostStops = 60, kMostOfADrive = 3'000;
/// Allowances for a wrong speed, as a share of the range: from thirty degrees of air temperature to zero.
constexpr std::array<double, 5> kRooms = {0.05, 0.015, 0.004, 0.001, 0.0};
constexpr int kStepsEach = 4;
constexpr double kCauchySigmas = 3.0, kRejectionSigmas = 4.0;
constexpr double kFarthest = 0.1;  ///< largest relative offset of the speed from that of the reference state
constexpr double kLeastRedundancy =
    5.0;  ///< number of arrivals beyond the unknowns that cannot agree by chance
constexpr double kLeastAgreeing = 0.5;   ///< smallest share of the received arrivals that must agree
constexpr double kSpanOfParabola = 0.3;  ///< half width of the parabola, as a share of the allowance
constexpr double kLeastSpan = 2e-4;      ///< relative to the speed

/// Part of a run that suffices to estimate its speed.
MeasurementLog part_of_run(const MeasurementLog& run) {
  MeasurementLog part = run;
  if (run.has_epochs) {
    std::vector<std::int64_t> epochs;
    for (const Arrival& a : run.arrivals)
      if (epochs.empty() || epochs.back() != a.epoch) epochs.push_back(a.epoch);
    if (epochs.size() <= kMostStops) return part;
    std::vector<std::int64_t> some;
    for (std::size_t k = 0; k < kMostStops; ++k) some.push_back(epochs[k * epochs.size() / kMostStops]);
    std::ranges::sort(some);
    std::erase_if(part.arrivals,
                  [&](const Arrival& a) { return !std::ranges::binary_search(some, a.epoch); });
    part.odometry.clear();  // removed because it links neighbouring stops
    return part;
  }
  if (run.arrivals.size() <= kMostOfADrive) return part;
  const double end_s = run.arrivals[kMostOfADrive].time_s;
  part.arrivals.resize(kMostOfADrive);
  std::erase_if(part.odometry, [&](const OdometryStep& row) { return row.time_s > end_s; });
  return part;
}

class SpeedSearch {
 public:
  SpeedSearch(const Deployment& deployment, const MeasurementLog& run)
      : deployment_(deployment), model_(epoch_fix_model(deployment)), calibrated_(model_.state) {
    const TrajectoryModel how = trajectory_model(deployment);
    std::vector<double> ranges_m;
    for (std::size_t v = 0; v < deployment.vehicles.size(); ++v)
      trajectories_.push_back(make_trajectory(run, 0, VehicleId(v), how));
    for (const Arrival& a : run.arrivals) ranges_m.push_back(std::abs(a.tof_s) * model_.nominal_speed_mps);
    if (ranges_m.empty()) return;
    std::ranges::nth_element(ranges_m, ranges_m.begin() + static_cast<std::ptrdiff_t>(ranges_m.size() / 2));
    range_m_ = ranges_m[ranges_m.size() / 2];
    sigma_m_ = how.noise.tof_sigma_s * model_.nominal_speed_mps;
  }

  RunSpeed run() {
    RunSpeed out;
    if (!(range_m_ > 0.0)) return out;
    for (const double room : kRooms) {
      place(room * range_m_);
      if (room == 0.0) reject_outliers();
      if (!climb(room)) return counted(out);
    }
    counted(out);
    const double farthest_mps = kFarthest * model_.nominal_speed_mps;
    if (!(information_ > 0.0) || std::abs(offset_mps_) > farthest_mps || redundancy_ < kLeastRedundancy ||
        static_cast<double>(out.arrivals) < kLeastAgreeing * static_cast<double>(heard_))
      return out;
    out.offset_mps = offset_mps_;
    out.sigma_mps = std::hypot(std::sqrt(std::max(1.0, squares_ / redundancy_) / information_),
                               deployment_.speed_sigma_mps);
    out.determined = out.sigma_mps <= kSpeedKnownTo * model_.nominal_speed_mps;
    return out;
  }

 private:
  /// Shared state at an offset from the calibrated speed.
  [[nodiscard]] SharedState state_at(double offset_mps) const {
    SharedState state = calibrated_;
    for (double& speed : state.speed_offset_mps) speed += offset_mps;
    return state;
  }

  void place(double uncertainty_m) {
    model_.state = state_at(offset_mps_);
    for (Trajectory& t : trajectories_) {
      for (Node& node : t.nodes) node.placed = false;
      if (t.moving && (!t.odometry.empty() || t.motion_prior)) {
        TrackerOptions options;
        options.range_uncertainty_m = uncertainty_m;
        const bool found = place_drive(t, model_, options);
        for (Node& node : t.nodes) node.placed = found;
      } else {
        EpochFixOptions options;
        options.range_uncertainty_m = uncertainty_m;
        options.max_sigma_m = INFINITY;
        for (const Segment& segment : t.segments)
          for (std::size_t n = segment.first_node; n < segment.last_node; ++n)
            t.nodes[n].placed = fix_epoch(t, node_segment(t, segment, n), model_, options).ok();
      }
      for (const Segment& segment : t.segments) reset_rejections(t, segment, model_);
    }
  }

  [[nodiscard]] static bool is_placed(const Trajectory& t, const Segment& segment) {
    return std::all_of(t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node),
                       t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.last_node),
                       [](const Node& node) { return node.placed; });
  }

  /// Rejects arrivals that do not agree at the current offset.
  void reject_outliers() {
    const SharedState state = state_at(offset_mps_);
    const RobustLoss loss{kCauchySigmas, kCauchySigmas};
    for (Trajectory& t : trajectories_)
      for (const Segment& segment : t.segments) {
        if (!is_placed(t, segment)) continue;
        static_cast<void>(solve_states(t, segment, state, loss));
        for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
          ArrivalObservation& a = t.arrivals[i];
          if (a.rejection != Rejection::kUsed) continue;
          const double residual = arrival_residual(t, a, state);
          if (std::abs(residual) > kRejectionSigmas)
            a.rejection = residual > 0 ? Rejection::kLate : Rejection::kEarly;
        }
      }
  }

  /// Sum of squares of all arrivals at an offset, minimised over the states.
  [[nodiscard]] double squares_at(double offset_mps, const RobustLoss& loss) {
    const SharedState state = state_at(offset_mps);
    double cost = 0.0;
    for (Trajectory& t : trajectories_)
      for (const Segment& segment : t.segments)
        if (is_placed(t, segment)) cost += solve_states(t, segment, state, loss).cost;
    return cost;
  }

  /// Newton iteration on the profile. @return false without curvature or slope
  bool climb(double room) {
    const double scale = room > 0.0 ? std::max(kCauchySigmas, room * range_m_ / sigma_m_) : 0.0;
    const RobustLoss loss{scale, scale};
    const double speed_mps = model_.nominal_speed_mps;
    const double span_mps = speed_mps * std::max(kLeastSpan, kSpanOfParabola * room),
                 most_mps = speed_mps * std::max(0.001, room);
    for (int step = 0; step < kStepsEach; ++step) {
      const double here = squares_at(offset_mps_, loss), less = squares_at(offset_mps_ - span_mps, loss),
                   more = squares_at(offset_mps_ + span_mps, loss);
      information_ = (more - 2.0 * here + less) / (span_mps * span_mps);
      const double slope = (more - less) / (2.0 * span_mps);
      if (!std::isfinite(slope) || !std::isfinite(information_)) return false;
      // Where the profile is flat or has negative curvature, moves downhill by the span.
      const double by_mps = information_ > 1e-12 ? -slope / information_
                            : slope == 0.0       ? 0.0
                                                 : -std::copysign(span_mps, slope);
      offset_mps_ += std::clamp(by_mps, -most_mps, most_mps);
      if (std::abs(by_mps) < 0.1 * span_mps) break;
    }
    return true;
  }

  /// Fills in the counts and the sum of squares of the arrivals that agree.
  RunSpeed& counted(RunSpeed& out) {
    const SharedState state = state_at(offset_mps_);
    static_cast<void>(squares_at(offset_mps_, {}));
    double unknowns = 1.0;
    for (const Trajectory& t : trajectories_)
      for (const Segment& segment : t.segments) {
        heard_ += segment.last_arrival - segment.first_arrival;
        if (!is_placed(t, segment)) continue;
        const std::size_t nodes = segment.last_node - segment.first_node;
        out.poses += nodes;
        // Odometry links the states of a drive, so it counts as a single pose.
        unknowns += static_cast<double>(t.block_size()) * (t.moving ? 1.0 : static_cast<double>(nodes));
        for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
          if (t.arrivals[i].rejection != Rejection::kUsed) continue;
          ++out.arrivals;
          const double residual = arrival_residual(t, t.arrivals[i], state);
          squares_ += residual * residual;
        }
      }
    redundancy_ = static_cast<double>(out.arrivals) - unknowns;
    return out;
  }

  const Deployment& deployment_;
  EpochFixModel model_;
  SharedState calibrated_;
  std::vector<Trajectory> trajectories_;
  double range_m_ = 0.0, sigma_m_ = 1.0;
  double offset_mps_ = 0.0, information_ = 0.0, squares_ = 0.0, redundancy_ = 0.0;
  std::size_t heard_ = 0;
};

}  // namespace

bool speed_is_unknown(const Deployment& deployment, const MeasurementLog& run) {
  if (run.arrivals.empty()) return false;
  const OutsideValidity outside = outside_validity(deployment, run, {});
  return outside.reference_assumed || outside.temperature_degC.has_value();
}

RunSpeed estimate_run_speed(const Deployment& deployment, const MeasurementLog& all_rows) {
  MeasurementLog room;
  const MeasurementLog part = part_of_run(known_rows(all_rows, deployment, room));
  RunSpeed out = SpeedSearch(deployment, part).run();
  if (!out.determined) return out;
  const Medium& medium = deployment.medium;
  const std::optional<double> degC = temperature_at(medium, speed_mps(medium) + out.offset_mps);
  if (!degC) return out;
  constexpr double kDegree = 1.0;
  out.temperature_degC = *degC;
  out.temperature_sigma_degC =
      out.sigma_mps / (speed_mps(medium, *degC + kDegree) - speed_mps(medium, *degC));
  return out;
}

Deployment at_speed(Deployment deployment, const RunSpeed& speed) {
  deployment.speed_offset_mps += speed.offset_mps;
  deployment.speed_sigma_mps = speed.sigma_mps;
  JointCovariance& joint = deployment.covariance;
  if (joint.parameters.empty()) return deployment;
  int at = joint.index_of(parameters::speed());
  if (at < 0) {
    at = static_cast<int>(joint.parameters.size());
    joint.parameters.push_back(parameters::speed());
    joint.matrix.conservativeResize(at + 1, at + 1);
  }
  joint.matrix.row(at).setZero();
  joint.matrix.col(at).setZero();
  joint.matrix(at, at) = speed.sigma_mps * speed.sigma_mps;
  return deployment;
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/make_trajectory.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "models/trajectory/odometry_path.h"
#include "models/trajectory/state_kind.h"

namespace octant {
namespace {

PoseObservation pose_observation(std::size_t node, double alpha, const Pose& T,
                                 const PoseAccuracy& accuracy) {
  PoseObservation p;
  p.node = node;
  p.alpha = alpha;
  p.T_map_vehicle = T;
  p.position_sigma_m = std::max(accuracy.position_sigma_m, kExactPositionM);
  p.heading_sigma_rad =
      accuracy.heading_known ? std::max(accuracy.heading_sigma_rad, kExactAngleRad) : INFINITY;
  p.attitude_sigma_rad = std::max(accuracy.attitude_sigma_rad, kExactAngleRad);
  return p;
}

class Builder {
 public:
  Builder(const MeasurementLog& log, std::size_t run, VehicleId vehicle, const TrajectoryModel& model)
      : log_(log), model_(model), path_(odometry_path(log, vehicle)) {
    static_cast<StateSpace&>(t_) = state_space(vehicle, model);
    t_.run = run;
    t_.nominal_speed_mps = speed_mps(run_medium(), run_temperature_degC());
    arrivals_.reserve(log.arrivals.size());
    for (std::size_t i = 0; i < log.arrivals.size(); ++i)
      if (log.arrivals[i].vehicle == vehicle) arrivals_.push_back(i);
    t_.arrivals.reserve(arrivals_.size());
    for (std::size_t i = 0; i < log.bearings.size(); ++i)
      if (log.bearings[i].vehicle == vehicle) bearings_.push_back(i);
  }

  Trajectory build() {
    switch (state_kind(log_, t_.vehicle, model_)) {
      case StateKind::kStops:
      case StateKind::kChainedStops: build_epochs(); break;
      case StateKind::kDrive: build_drive(); break;
      case StateKind::kMotion: arrivals_.empty() ? build_moments() : build_motion(); break;
      case StateKind::kMoments: build_moments(); break;
    }
    return std::move(t_);
  }

 private:
  [[nodiscard]] Medium run_medium() const {
    Medium medium = model_.medium;
    if (log_.relative_humidity) medium.relative_humidity = *log_.relative_humidity;
    if (log_.pressure_pa) medium.pressure_pa = *log_.pressure_pa;
    return medium;
  }
  [[nodiscard]] double run_temperature_degC() const {
    return log_.temperature_degC.value_or(model_.medium.temperature_degC);
  }

  /// Speed of the medium. Cached, because neighbouring arrivals share a temperature and the models are slow.
  [[nodiscard]] double speed_at(double temperature_degC) {
    if (temperature_degC != speed_temperature_degC_) {
      speed_temperature_degC_ = temperature_degC;
      speed_mps_ = speed_mps(run_medium(), temperature_degC);
    }
    return speed_mps_;
  }

  /// Relative motion between request and reception, from odometry or measured poses; identity for a vehicle
  /// at rest.
  [[nodiscard]] Pose two_way_motion(const Arrival& a) const {
    if (const auto T_hear_send = hear_send_motion(path_, a)) return *T_hear_send;
    Pose hear, send;
    const double gap = log_.pose_accuracy.max_gap_s;
    if (t_.moving && interpolate_poses(log_.poses, a.time_s, gap, hear) &&
        interpolate_poses(log_.poses, a.time_s - a.tof_s, gap, send))
      return hear.inverse() * send;
    return {};
  }

  void add_arrival(std::size_t index, std::size_t node, double alpha) {
    const Arrival& a = log_.arrivals[index];
    ArrivalObservation o = observe(
        a, model_, speed_at(std::isfinite(a.temperature_degC) ? a.temperature_degC : run_temperature_degC()));
    o.node = node;
    o.alpha = alpha;
    o.arrival = index;
    if (o.two_way) {
      o.hear_send = static_cast<std::int32_t>(t_.T_hear_send.size());
      t_.T_hear_send.push_back(two_way_motion(a));
    }
    t_.arrivals.push_back(o);
  }

  void add_bearing(std::size_t index, std::size_t node, double alpha) {
    const Bearing& b = log_.bearings[index];
    t_.bearings.push_back(
        {node, alpha, index, b.reflector, b.bearing_rad, model_.noise.bearing_sigma_rad, Rejection::kUsed});
  }

  /// One node for each epoch in order of time, linked by odometry where the run has it.
  void build_epochs() {
    if (bearings_.empty() && epochs_rise()) return build_rising_epochs();
    std::map<std::int64_t, std::size_t> node_of;
    std::vector<std::vector<std::size_t>> arrivals, bearings;
    auto node_for = [&](std::int64_t epoch, double time_s) {
      const auto [it, added] = node_of.try_emplace(epoch, t_.nodes.size());
      if (added) {
        t_.nodes.push_back({.time_s = time_s, .epoch = epoch, .T_map_vehicle = {}});
        arrivals.emplace_back();
        bearings.emplace_back();
      }
      return it->second;
    };
    for (const std::size_t i : arrivals_)
      arrivals[node_for(log_.arrivals[i].epoch, log_.arrivals[i].time_s)].push_back(i);
    for (const std::size_t i : bearings_) {
      // Evaluated first, because node_for() may reallocate the vector.
      const std::size_t node = node_for(log_.bearings[i].epoch, log_.bearings[i].time_s);
      bearings[node].push_back(i);
    }
    for (std::size_t k = 0; k < t_.nodes.size(); ++k) {
      if (!chained(k)) open_segment(k);
      for (const std::size_t i : arrivals[k]) add_arrival(i, k, 0.0);
      for (const std::size_t i : bearings[k]) add_bearing(i, k, 0.0);
      add_epoch_pose(k, arrivals[k], bearings[k]);
      close_segment(k + 1);
    }
  }

  /// Returns true if epoch numbers increase with time, as in most logs. The look-up of epochs is then
  /// unnecessary.
  [[nodiscard]] bool epochs_rise() const {
    return std::ranges::is_sorted(arrivals_, [this](std::size_t a, std::size_t b) {
      return log_.arrivals[a].epoch < log_.arrivals[b].epoch;
    });
  }

  void build_rising_epochs() {
    std::vector<std::size_t> arrivals;
    for (std::size_t first = 0; first < arrivals_.size();) {
      const Arrival& begin = log_.arrivals[arrivals_[first]];
      const std::size_t k = t_.nodes.size();
      t_.nodes.push_back({.time_s = begin.time_s, .epoch = begin.epoch, .T_map_vehicle = {}});
      if (!chained(k)) open_segment(k);
      arrivals.clear();
      for (; first < arrivals_.size() && log_.arrivals[arrivals_[first]].epoch == begin.epoch; ++first)
        arrivals.push_back(arrivals_[first]);
      for (const std::size_t i : arrivals) add_arrival(i, k, 0.0);
      if (!log_.poses.empty()) add_epoch_pose(k, arrivals, {});
      close_segment(k + 1);
    }
  }

  /// Adds the odometry between epochs k - 1 and k; false if there is none.
  bool chained(std::size_t k) {
    if (k == 0 || path_.time_s.empty()) return false;
    OdometryObservation o;
    o.node = k - 1;
    if (!path_between(path_, t_.nodes[k - 1].time_s, t_.nodes[k].time_s, o)) return false;
    t_.odometry.push_back(o);
    return true;
  }

  void add_epoch_pose(std::size_t k, const std::vector<std::size_t>& arrivals,
                      const std::vector<std::size_t>& bearings) {
    std::vector<double> times;
    times.reserve(arrivals.size() + bearings.size());
    for (const std::size_t i : arrivals) times.push_back(log_.arrivals[i].time_s);
    for (const std::size_t i : bearings) times.push_back(log_.bearings[i].time_s);
    Pose T;
    for (const double time_s : times) {
      if (!interpolate_poses(log_.poses, time_s, log_.pose_accuracy.max_gap_s, T)) continue;
      t_.poses.push_back(pose_observation(k, 0.0, T, log_.pose_accuracy));
      t_.nodes[k].T_map_vehicle = T;
      t_.nodes[k].placed = true;
      return;
    }
  }

  /// Nodes at the odometry rows. Observations between two rows belong to the earlier one, with alpha.
  void build_drive() {
    t_.moving = true;
    for (const double time_s : path_.time_s) t_.nodes.push_back({.time_s = time_s, .T_map_vehicle = {}});
    open_segment(0);
    for (std::size_t k = 0; k + 1 < path_.time_s.size(); ++k) {
      const Pose step = path_.T_anchor_vehicle[k].inverse() * path_.T_anchor_vehicle[k + 1];
      t_.odometry.push_back({k, step, std::sqrt(path_.distance_variance_m2[k + 1]),
                             std::sqrt(path_.heading_variance_rad2[k + 1])});
    }
    for (const std::size_t i : arrivals_) {
      if (const auto at = place_at(path_, log_.arrivals[i].time_s)) {
        add_arrival(i, at->row, at->alpha);
      } else {
        t_.stateless_arrivals.push_back(i);
      }
    }
    for (const std::size_t i : bearings_)
      if (const auto at = place_at(path_, log_.bearings[i].time_s)) add_bearing(i, at->row, at->alpha);
    std::ranges::stable_sort(t_.arrivals, [](const auto& a, const auto& b) { return a.node < b.node; });
    for (const TimedPose& pose : log_.poses) {
      const auto at = place_at(path_, pose.time_s);
      if (log_.vehicle != t_.vehicle || !at) continue;
      t_.poses.push_back(pose_observation(at->row, at->alpha, pose.T_map_vehicle, log_.pose_accuracy));
    }
    close_segment(t_.nodes.size());
  }

  /// One state with a velocity for each instant of arrivals. After a long silence the prior carries no
  /// information.
  void build_motion() {
    constexpr double kSameInstant_s = 1e-3;
    t_.moving = true;
    t_.motion_prior = model_.motion_priors[t_.vehicle.index()];
    for (std::size_t first = 0; first < arrivals_.size();) {
      const double time_s = log_.arrivals[arrivals_[first]].time_s;
      const std::size_t k = t_.nodes.size();
      const double step_s = k > 0 ? time_s - t_.nodes[k - 1].time_s : INFINITY;
      if (step_s > kSilence_s) {
        if (k > 0) close_segment(k);
        open_segment(k);
        t_.motion_steps.push_back({k, 0.0});
      } else {
        t_.motion_steps.push_back({k - 1, step_s});
      }
      t_.nodes.push_back({.time_s = time_s, .T_map_vehicle = {}});
      for (; first < arrivals_.size() && log_.arrivals[arrivals_[first]].time_s <= time_s + kSameInstant_s;
           ++first)
        add_arrival(arrivals_[first], k, 0.0);
    }
    close_segment(t_.nodes.size());
    attach_bearings();
  }

  /// Attaches each bearing to the state that is nearest in time.
  void attach_bearings() {
    std::size_t k = 0;
    for (const std::size_t i : bearings_) {
      const double time_s = log_.bearings[i].time_s;
      while (k + 1 < t_.nodes.size() &&
             std::abs(t_.nodes[k + 1].time_s - time_s) <= std::abs(t_.nodes[k].time_s - time_s))
        ++k;
      if (k < t_.nodes.size() && std::abs(t_.nodes[k].time_s - time_s) <= kNearInstant_s)
        add_bearing(i, k, 0.0);
    }
    std::size_t next = 0;
    for (Segment& s : t_.segments) {
      s.first_bearing = next;
      while (next < t_.bearings.size() && t_.bearings[next].node < s.last_node) ++next;
      s.last_bearing = next;
    }
  }

  /// Each moment is a separate state with the measured pose of that time. Receivers that detect the same
  /// pulse in succession share a state, because the error of the pose is common to them.
  void build_moments() {
    t_.moving = true;
    std::size_t next_bearing = 0;
    for (std::size_t first = 0; first < arrivals_.size();) {
      const double time_s = log_.arrivals[arrivals_[first]].time_s;
      Pose T;
      const bool measured = log_.vehicle == t_.vehicle &&
                            interpolate_poses(log_.poses, time_s, log_.pose_accuracy.max_gap_s, T);
      const std::size_t last = end_of_moment(log_, arrivals_, first, measured ? &T : nullptr,
                                             model_.noise.tof_sigma_s * speed_at(run_temperature_degC()));
      const double last_s = log_.arrivals[arrivals_[last - 1]].time_s;
      if (!measured && !log_.poses.empty()) {
        for (std::size_t i = first; i < last; ++i) t_.stateless_arrivals.push_back(arrivals_[i]);
      } else {
        const std::size_t k = t_.nodes.size();
        t_.nodes.push_back({.time_s = time_s, .T_map_vehicle = T, .placed = measured});
        open_segment(k);
        for (std::size_t i = first; i < last; ++i) add_arrival(arrivals_[i], k, 0.0);
        while (next_bearing < bearings_.size() && log_.bearings[bearings_[next_bearing]].time_s < time_s)
          ++next_bearing;
        for (; next_bearing < bearings_.size() && log_.bearings[bearings_[next_bearing]].time_s <= last_s;
             ++next_bearing)
          add_bearing(bearings_[next_bearing], k, 0.0);
        if (measured) t_.poses.push_back(pose_observation(k, 0.0, T, log_.pose_accuracy));
        close_segment(k + 1);
      }
      first = last;
    }
  }

  /// Call before adding the odometry that leads to the node, which would otherwise belong to the previous
  /// segment.
  void open_segment(std::size_t node) {
    t_.segments.push_back({.first_node = node});
    for_each_list([this](auto list, auto first, auto) { t_.segments.back().*first = (t_.*list).size(); });
  }
  void close_segment(std::size_t last_node) {
    t_.segments.back().last_node = last_node;
    for_each_list([this](auto list, auto, auto last) { t_.segments.back().*last = (t_.*list).size(); });
  }

  const MeasurementLog& log_;
  const TrajectoryModel& model_;
  OdometryPath path_;
  Trajectory t_;
  std::vector<std::size_t> arrivals_, bearings_;
  double speed_temperature_degC_ = NAN, speed_mps_ = NAN;
};

}  // namespace

Trajectory make_trajectory(const MeasurementLog& log, std::size_t run, VehicleId vehicle,
                           const TrajectoryModel& model) {
  return Builder(log, run, vehicle, model).build();
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/stretch_states.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/start/rigid_path.h"
#include "models/trajectory/observed_range.h"

namespace octant {
namespace {

constexpr double kStartInflation = 4.0;  ///< factor on the covariance of robustly solved states

}  // namespace

void lay_stretch(Trajectory& t, const Segment& window, const EpochFixModel& model, double uncertainty_m,
                 const Pose& T_map_anchor, const RigidPath& path) {
  lay_rigidly(t, window, T_map_anchor, path);
  {
    const WidenedArrivals widened(t, window, model, uncertainty_m);
    solve_states(t, window, model.state, {.late_scale = 10.0, .early_scale = 15.0}, 10);
  }
  refine_stretch(t, window, model, uncertainty_m);
}

void refine_stretch(Trajectory& t, const Segment& stretch, const EpochFixModel& model, double uncertainty_m) {
  const WidenedArrivals widened(t, stretch, model, uncertainty_m);
  solve_states(t, stretch, model.state, {.late_scale = 2.5, .early_scale = 4.0}, 15);
}

double independent_uncertainty_m(const Trajectory& t, const Segment& segment, const EpochFixModel& model,
                                 double uncertainty_m) {
  if (uncertainty_m == 0.0 || segment.first_arrival == segment.last_arrival) return uncertainty_m;
  double path_m = 0.0, range_m = 0.0;
  for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i)
    path_m += t.odometry[i].T_before_after.translation_m.norm();
  std::pmr::vector<char> heard(model.beacon_usable.size(), 0, scratch());
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    heard[t.arrivals[i].beacon.index()] = 1;
    range_m += observed_range_m(t, t.arrivals[i], model.state);
  }
  const double arrivals = static_cast<double>(segment.last_arrival - segment.first_arrival);
  const double share = std::min(1.0, 0.5 * (range_m / arrivals) / std::max(path_m, 1e-9));
  return uncertainty_m *
         std::sqrt(std::max(1.0, share * arrivals / static_cast<double>(std::ranges::count(heard, 1))));
}

WidenedArrivals::WidenedArrivals(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                                 double uncertainty_m)
    : trajectory_(t), first_(segment.first_arrival) {
  if (uncertainty_m == 0.0) return;
  const double wide_m = independent_uncertainty_m(t, segment, model, uncertainty_m);
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    sigma_s_.push_back(a.sigma_s);
    a.sigma_s =
        std::hypot(a.sigma_s, wide_m * a.legs() / (a.model_speed_mps + model.state.speed_offset(t.run)));
  }
}

WidenedArrivals::~WidenedArrivals() {
  for (std::size_t i = 0; i < sigma_s_.size(); ++i) trajectory_.arrivals[first_ + i].sigma_s = sigma_s_[i];
}

PoseCovariance start_covariance(Trajectory& t, const Segment& stretch, const EpochFixModel& model,
                                double uncertainty_m, std::size_t node) {
  const WidenedArrivals widened(t, stretch, model, uncertainty_m);
  const StateCovariance P = node_covariance(t, stretch, node, model.state);
  const int dof = pose_dof(t.motion);
  if (P.rows() >= dof && P.allFinite()) return kStartInflation * P.topLeftCorner(dof, dof);
  PoseCovariance little = PoseCovariance::Identity(dof, dof);
  little.diagonal().tail(little.rows() - first_turn(t.motion)).setConstant(0.1);
  return little;
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to chain_reduction.cc: the rows of one segment of a chain.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "calib/chain/chain_paths.h"
#include "calib/chain/stretch_window.h"
#include "calib/problem/shared_entries.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"
#include "models/trajectory/spatial.h"

namespace octant::calib::chain {

/// Free parameters of a path in a segment.
struct LocalPath {
  int count = -1;  ///< -1: not met
  std::array<PathColumns::Column, PathColumns::kCapacity> entry;
};

/// Positions of the system's columns in a segment, for each thread. Between two segments they are all unset;
/// clearing all of them would cost more than a segment of one state.
struct StretchMemory {
  std::vector<int> of_system;
  std::vector<LocalPath> paths;
  std::vector<std::size_t> met;  ///< paths that have been used
  std::vector<PlanarNode> states;
  WindowMemory window;
};

template <int N>
class StretchReducer {
 public:
  static constexpr std::size_t n = N;

  StretchReducer(const ChainPaths& chain, const Segment& segment, const SharedState& state,
                 const RobustLoss& loss, const std::vector<int>& place, std::size_t columns)
      : chain_(chain),
        t_(chain.trajectory()),
        segment_(segment),
        state_(state),
        loss_(loss),
        place_(place),
        whitening_(state.speed_offset(t_.run)),
        is_planar_(N == 3 && has_planar_arrivals(t_, segment, state)),
        is_spatial_(N == 6 && has_spatial_arrivals(t_, segment, state)) {
    if (memory_.of_system.size() < columns) memory_.of_system.resize(columns, -1);
    if (memory_.paths.size() < chain.paths().size()) memory_.paths.resize(chain.paths().size());
  }

  void reduce(const Stretch& stretch, ReducedStretch& out) {
    stretch_ = &stretch;
    out_ = &out;
    out.cost = 0.0;
    begin_rows();
    find_columns();
    if (is_planar_) copy_states();
    StretchWindow<N> window(memory_.window, stretch, out);
    window_ = &window;
    if (stretch.has_left) {
      window.begin_left();
      add_rows_of(stretch.first - 1);
    }
    for (std::size_t k = stretch.first; k < stretch.last; ++k) {
      window.begin_state();
      add_rows_of(k);
    }
    // An unobservable direction (heading of a single antenna) is fixed: it is not coupled to others. Within a
    // chain, odometry observes all directions, and a floor would act as a measured pose at every state.
    window.finish(stretch.has_right, stretch.has_right ? 0.0 : kUnobservedFloor);
    window_ = nullptr;
    for (const int column : out.columns) memory_.of_system[static_cast<std::size_t>(column)] = -1;
    for (const std::size_t path : memory_.met) memory_.paths[path].count = -1;
    memory_.met.clear();
  }

 private:
  static StretchMemory& of_this_thread() {
    thread_local StretchMemory kept;
    return kept;
  }

  /// Starts the segment: no observation has been added.
  void begin_rows() {
    rest_ = segment_;
    for_each_list([&](auto list, auto first, auto last) {
      rest_.*first =
          first_of_node(t_.*list, segment_.first_node + stretch_->begin(), rest_.*first, rest_.*last);
    });
  }

  /// Parameters that occur in the segment.
  void find_columns() {
    std::vector<int>& columns = out_->columns;
    columns.clear();
    StretchMemory& l = memory_;
    const auto see = [&](int global) {
      const int column = global < 0 ? -1 : place_[static_cast<std::size_t>(global)];
      if (column < 0 || l.of_system[static_cast<std::size_t>(column)] >= 0) return;
      l.of_system[static_cast<std::size_t>(column)] = 0;
      columns.push_back(column);
    };
    const std::size_t end = segment_.first_node + stretch_->last;
    for (std::size_t i = rest_.first_arrival; i < rest_.last_arrival && t_.arrivals[i].node < end; ++i) {
      if (t_.arrivals[i].rejection != Rejection::kUsed) continue;
      const std::size_t at = chain_.path_of(t_.arrivals[i]);
      if (l.paths[at].count >= 0) continue;
      l.paths[at].count = 0;
      l.met.push_back(at);
      for (const PathColumns::Column& e : chain_.paths()[at]) see(e.column);
    }
    for (std::size_t i = rest_.first_bearing; i < rest_.last_bearing && t_.bearings[i].node < end; ++i)
      if (t_.bearings[i].rejection == Rejection::kUsed && t_.bearings[i].reflector.valid())
        for (const int c : chain_.layout().beacon[t_.bearings[i].reflector.index()]) see(c);
    std::ranges::sort(columns);
    for (std::size_t i = 0; i < columns.size(); ++i)
      l.of_system[static_cast<std::size_t>(columns[i])] = static_cast<int>(i);
    for (const std::size_t p : l.met) find_entries(chain_.paths()[p], l.paths[p]);
  }
  void find_entries(const PathColumns& path, LocalPath& out) const {
    for (const PathColumns::Column& of_system : path) {
      const int column = place_[static_cast<std::size_t>(of_system.column)];
      if (column < 0) continue;
      PathColumns::Column& entry = out.entry[static_cast<std::size_t>(out.count++)];
      entry = of_system;
      entry.column = memory_.of_system[static_cast<std::size_t>(column)];
    }
  }

  void copy_states() {
    std::vector<PlanarNode>& states = memory_.states;
    states.clear();
    const std::size_t end = stretch_->last + (stretch_->has_right ? 1 : 0);
    for (std::size_t k = stretch_->begin(); k < end; ++k)
      states.emplace_back(t_.nodes[segment_.first_node + k].T_map_vehicle);
  }

  void add_rows_of(std::size_t k) {
    const std::size_t node = segment_.first_node + k;
    if (is_planar_) {
      add_planar_rows_of(k);
    } else if (is_spatial_) {
      add_spatial_rows_of(k);
    } else {
      add_rows_between(node);
    }
    for (; rest_.first_bearing < rest_.last_bearing && t_.bearings[rest_.first_bearing].node == node;
         ++rest_.first_bearing)
      if (t_.bearings[rest_.first_bearing].rejection == Rejection::kUsed)
        add(bearing_rows(t_, rest_.first_bearing, state_, rows_));
    for (; rest_.first_pose < rest_.last_pose && t_.poses[rest_.first_pose].node == node; ++rest_.first_pose)
      add(pose_rows(t_, rest_.first_pose, rows_));
    for (; rest_.first_motion < rest_.last_motion && t_.motion_steps[rest_.first_motion].node == node;
         ++rest_.first_motion)
      add(motion_rows(t_, rest_.first_motion, rows_));
  }

  /// Arrivals and odometry.
  void add_rows_between(std::size_t node) {
    InstantPose at;
    for (; rest_.first_arrival < rest_.last_arrival && t_.arrivals[rest_.first_arrival].node == node;
         ++rest_.first_arrival)
      if (t_.arrivals[rest_.first_arrival].rejection == Rejection::kUsed)
        add(arrival_rows(t_, rest_.first_arrival, state_, at, rows_));
    for (; rest_.first_odometry < rest_.last_odometry && t_.odometry[rest_.first_odometry].node == node;
         ++rest_.first_odometry)
      add(odometry_rows(t_, rest_.first_odometry, rows_));
  }

  void add_planar_rows_of(std::size_t k) {
    const std::vector<PlanarNode>& states = memory_.states;
    const std::size_t node = segment_.first_node + k, i = k - stretch_->begin();
    const PlanarInterval interval(states[i], states[std::min(i + 1, states.size() - 1)]);
    for (; rest_.first_arrival < rest_.last_arrival && t_.arrivals[rest_.first_arrival].node == node;
         ++rest_.first_arrival)
      if (t_.arrivals[rest_.first_arrival].rejection == Rejection::kUsed)
        add_planar(t_.arrivals[rest_.first_arrival], interval);
    for (; rest_.first_odometry < rest_.last_odometry && t_.odometry[rest_.first_odometry].node == node;
         ++rest_.first_odometry)
      if constexpr (N == 3) add_step(PlanarStep(t_.odometry[rest_.first_odometry], interval));
  }

  void add_planar(const ArrivalObservation& a, const PlanarInterval& interval) {
    whitening_.set(a);
    const PlanarArrival row(a, interval.at(a.alpha), state_, whitening_);
    const double ux = row.direction[0], uy = row.direction[1], uz = row.direction[2];
    const Eigen::Vector3d direction_vehicle(row.cosine * ux + row.sine * uy, row.cosine * uy - row.sine * ux,
                                            uz);
    const double before = 1.0 - a.alpha;
    const double by[3] = {row.by_x(), row.by_y(), row.by_heading};
    const double by_node[7] = {before * by[0], before * by[1], before * by[2]},
                 by_next[7] = {a.alpha * by[0], a.alpha * by[1], a.alpha * by[2]};
    add_plain(a, row, {ux, uy, uz}, direction_vehicle, by_node, by_next);
  }

  void add_spatial_rows_of(std::size_t k) {
    const std::size_t node = segment_.first_node + k;
    const bool has_next = k < stretch_->last - (stretch_->has_right ? 0 : 1);
    const SpatialInterval interval(t_.nodes[node].T_map_vehicle,
                                   t_.nodes[has_next ? node + 1 : node].T_map_vehicle);
    for (; rest_.first_arrival < rest_.last_arrival && t_.arrivals[rest_.first_arrival].node == node;
         ++rest_.first_arrival) {
      const ArrivalObservation& a = t_.arrivals[rest_.first_arrival];
      if (a.rejection != Rejection::kUsed) continue;
      whitening_.set(a);
      const SpatialInstant at(interval, a.alpha);
      const SpatialArrival row(a, interval, at, state_, whitening_);
      add_plain(a, row, row.direction, at.turned_back(interval, row.direction_first), row.by_node.data(),
                row.by_next.data());
    }
    for (; rest_.first_odometry < rest_.last_odometry && t_.odometry[rest_.first_odometry].node == node;
         ++rest_.first_odometry)
      if constexpr (N == 6) add_step(SpatialStep(t_.odometry[rest_.first_odometry], interval));
  }

  /// A single straight path.
  /// @param direction, direction_vehicle  from beacon to receiver, in the map and in the vehicle's frame
  template <class Row>
  void add_plain(const ArrivalObservation& a, const Row& row, const Eigen::Vector3d& direction,
                 const Eigen::Vector3d& direction_vehicle, const double* by_node, const double* by_next) {
    const Eigen::Vector3d& o = state_.receiver_p_vehicle_m[a.receiver.index()];
    const Eigen::Vector3d by_receiver = row.by_distance * direction_vehicle;
    double base[kPathNumbers] = {};  // zero: what plain arrivals do not hang on
    for (Eigen::Index i = 0; i < 3; ++i) {
      base[i] = -row.by_distance * direction[i];
      base[kByReceiver + i] = by_receiver[i];
    }
    base[kByTurn] = by_receiver.y() * o.x() - by_receiver.x() * o.y();
    base[kByDelay] = whitening_.by_tof;
    base[kBySpeed] = -row.by_distance * row.distance_m * whitening_.slowness;
    const LocalPath& path = memory_.paths[chain_.path_of(a)];
    RowBorder border;
    border.count = path.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(path.count); ++i) {
      const PathColumns::Column& e = path.entry[i];
      if (e.what == kByRadius)
        base[kByRadius] = by_receiver.head<2>().dot(o.head<2>()) / std::max(o.head<2>().norm(), 1e-300);
      border.at[i] = e.column;
      border.value[i] = base[e.what] * e.scale;
    }
    const double w = loss_.weigh(row.residual, out_->cost);
    window_->add_row(row.residual, w, by_node, a.alpha == 0.0 ? nullptr : by_next, border);
  }

  void push(RowBorder& border, int global, double value) const {
    const int column = place_[static_cast<std::size_t>(global)];
    if (column < 0) return;
    const auto i = static_cast<std::size_t>(border.count++);
    border.at[i] = memory_.of_system[static_cast<std::size_t>(column)];
    border.value[i] = value;
  }

  template <class Step>
  void add_step(const Step& step) {
    out_->cost += step.cost();
    window_->add_step(step);
  }

  /// The rows of the array that were filled.
  void add(int count) {
    for (int i = 0; i < count; ++i) {
      const ObservationRow& row = rows_[i];
      const double w = weigh(row, loss_, out_->cost);
      const RowEntries e = row_entries(row, t_.run, chain_.layout(), state_);
      RowBorder border;
      for (std::size_t j = 0; j < static_cast<std::size_t>(e.count); ++j)
        push(border, e.column[j], e.value[j]);
      sort(border);
      window_->add_row(row.residual, w, row.by_node.data(), row.has_next ? row.by_next.data() : nullptr,
                       border);
    }
  }
  static void sort(RowBorder& border) {
    for (std::size_t i = 1; i < static_cast<std::size_t>(border.count); ++i)
      for (std::size_t j = i; j > 0 && border.at[j - 1] > border.at[j]; --j) {
        std::swap(border.at[j - 1], border.at[j]);
        std::swap(border.value[j - 1], border.value[j]);
      }
  }

  StretchMemory& memory_ = of_this_thread();
  const ChainPaths& chain_;
  const Trajectory& t_;
  const Segment& segment_;
  const SharedState& state_;
  const RobustLoss& loss_;
  const std::vector<int>& place_;
  ArrivalWhitening whitening_;
  bool is_planar_, is_spatial_;
  const Stretch* stretch_ = nullptr;
  ReducedStretch* out_ = nullptr;
  StretchWindow<N>* window_ = nullptr;
  Segment rest_;  ///< rest of the segment
  ObservationRow rows_[6];
};

}  // namespace octant::calib::chain

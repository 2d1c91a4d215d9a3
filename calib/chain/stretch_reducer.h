// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Inside of chain_reduction.cc: one stretch of a chain.

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "calib/adjust/stop_block.h"
#include "calib/chain/chain_kernel.h"
#include "calib/chain/chain_reduction.h"
#include "calib/problem/shared_entries.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"

namespace octant::calib::chain {

inline constexpr std::size_t kDoublesPerWindow = 16384;  ///< of the border: half of a second-level cache

/// Memory on whole vectors.
class AlignedDoubles {
 public:
  void assign_zero(std::size_t count) {
    if (count > size_) {
      data_.reset(new (std::align_val_t(kVectorBytes)) double[count]);
      size_ = count;
    }
    std::fill(data_.get(), data_.get() + count, 0.0);
  }
  [[nodiscard]] double* data() const { return data_.get(); }

 private:
  static constexpr std::size_t kVectorBytes = 64;
  struct Free {
    void operator()(double* data) const { ::operator delete[](data, std::align_val_t(kVectorBytes)); }
  };
  std::unique_ptr<double[], Free> data_;  // NOLINT(modernize-avoid-c-arrays)
  std::size_t size_ = 0;
};

/// States [first, last) of a segment, counted from its first, between two ends that stay.
struct Stretch {
  bool has_left = false, has_right = false;  ///< the state before `first`, that at `last`
  std::size_t first = 0, last = 0;
  [[nodiscard]] std::size_t begin() const { return first - (has_left ? 1 : 0); }
};

/// What is left of a stretch: its border is the parameters that it sees, the left end, and the gradient.
struct Remains {
  std::vector<int> columns;  ///< of the system, ascending
  std::size_t width = 0;
  AlignedDoubles H;          ///< width x width, lower triangle
  std::vector<double> D, G;  ///< of the right end
  [[nodiscard]] std::size_t left() const { return columns.size(); }
  [[nodiscard]] std::size_t gradient(std::size_t block) const { return columns.size() + block; }
};

/// Where each column of the system stands in a stretch, kept by each thread.
struct Local {
  std::vector<int> of_system;
  std::vector<char> path;  ///< met in this stretch
  std::vector<PlanarNode> states;
  AlignedDoubles D, U, G;
};

/// The derivatives of one row that are not by a state.
struct RowBorder {
  int count = 0;
  std::array<int, 20> at;  ///< in the stretch, ascending
  std::array<double, 20> value;
};

template <int N>
class StretchReducer {
 public:
  static constexpr std::size_t n = N;

  StretchReducer(const ChainReduction& chain, const Segment& segment, const SharedState& state,
                 const RobustLoss& loss, const std::vector<int>& place, std::size_t columns)
      : chain_(chain),
        t_(chain.trajectory()),
        segment_(segment),
        state_(state),
        loss_(loss),
        place_(place),
        whitening_(state.speed_offset(t_.run)),
        is_planar_(N == 3 && has_planar_arrivals(t_, segment, state)) {
    local().of_system.assign(columns, -1);
  }

  void reduce(const Stretch& stretch, Remains& out) {
    stretch_ = &stretch;
    out_ = &out;
    find_cursors();
    find_columns();
    const std::size_t has_left = stretch.has_left ? n : 0;
    gradient_ = out.columns.size() + has_left;
    width_ = (gradient_ + kBorderPad) / kBorderPad * kBorderPad;
    out.width = width_;
    out.H.assign_zero(width_ * width_);
    slots_ = std::clamp<std::size_t>(kDoublesPerWindow / (n * width_), 4, 64);
    Local& l = local();
    l.D.assign_zero((slots_ + 1) * n * n);
    l.U.assign_zero(slots_ * n * n);
    l.G.assign_zero((slots_ + 1) * n * width_);
    if (is_planar_) take_states();
    run();
    for (const int column : out.columns) l.of_system[static_cast<std::size_t>(column)] = -1;
  }

 private:
  static Local& local() {
    thread_local Local kept;
    return kept;
  }
  [[nodiscard]] double* D(std::size_t slot) const { return local().D.data() + slot * n * n; }
  [[nodiscard]] double* U(std::size_t slot) const { return local().U.data() + slot * n * n; }
  [[nodiscard]] double* G(std::size_t slot) const { return local().G.data() + slot * n * width_; }
  [[nodiscard]] double* H(std::size_t row) const { return out_->H.data() + row * width_; }

  template <class Observation>
  [[nodiscard]] std::size_t first_at(const std::vector<Observation>& list, std::size_t first,
                                     std::size_t last) const {
    const std::size_t node = segment_.first_node + stretch_->begin();
    const auto begin = list.begin() + static_cast<std::ptrdiff_t>(first),
               end = list.begin() + static_cast<std::ptrdiff_t>(last);
    return static_cast<std::size_t>(
        std::partition_point(begin, end, [node](const Observation& o) { return o.node < node; }) -
        list.begin());
  }
  void find_cursors() {
    arrival_ = first_at(t_.arrivals, segment_.first_arrival, segment_.last_arrival);
    bearing_ = first_at(t_.bearings, segment_.first_bearing, segment_.last_bearing);
    pose_ = first_at(t_.poses, segment_.first_pose, segment_.last_pose);
    odometry_ = first_at(t_.odometry, segment_.first_odometry, segment_.last_odometry);
    motion_ = first_at(t_.motion_steps, segment_.first_motion, segment_.last_motion);
  }

  /// The parameters that the stretch sees.
  void find_columns() {
    std::vector<int>& columns = out_->columns;
    columns.clear();
    Local& l = local();
    const auto see = [&](int global) {
      const int column = global < 0 ? -1 : place_[static_cast<std::size_t>(global)];
      if (column < 0 || l.of_system[static_cast<std::size_t>(column)] >= 0) return;
      l.of_system[static_cast<std::size_t>(column)] = 0;
      columns.push_back(column);
    };
    const std::size_t end = segment_.first_node + stretch_->last;
    const std::size_t receivers = chain_.layout().receiver.size();
    l.path.assign(chain_.layout().beacon.size() * receivers, 0);
    for (std::size_t i = arrival_; i < segment_.last_arrival && t_.arrivals[i].node < end; ++i) {
      const ArrivalObservation& a = t_.arrivals[i];
      char& met = l.path[a.beacon.index() * receivers + a.receiver.index()];
      if (a.rejection != Rejection::kUsed || met != 0) continue;
      met = 1;
      const PathColumns& path = chain_.columns_of(a.beacon, a.receiver);
      for (int e = 0; e < path.count; ++e) see(path.entry[static_cast<std::size_t>(e)].column);
    }
    for (std::size_t i = bearing_; i < segment_.last_bearing && t_.bearings[i].node < end; ++i)
      if (t_.bearings[i].rejection == Rejection::kUsed && t_.bearings[i].reflector.valid())
        for (const int c : chain_.layout().beacon[t_.bearings[i].reflector.index()]) see(c);
    std::sort(columns.begin(), columns.end());
    for (std::size_t i = 0; i < columns.size(); ++i)
      l.of_system[static_cast<std::size_t>(columns[i])] = static_cast<int>(i);
  }

  void take_states() {
    std::vector<PlanarNode>& states = local().states;
    states.clear();
    const std::size_t end = stretch_->last + (stretch_->has_right ? 1 : 0);
    for (std::size_t k = stretch_->begin(); k < end; ++k)
      states.emplace_back(t_.nodes[segment_.first_node + k].T_map_vehicle);
  }

  void run() {
    const Stretch& s = *stretch_;
    if (s.has_left) add_rows_of(s.first - 1, true, 0);
    std::size_t begin = s.first;  // state in the first slot
    for (std::size_t k = s.first; k < s.last; ++k) {
      if (k - begin == slots_) {
        eliminate_slots(slots_, 0.0);
        pass_on(slots_);
        begin = k;
      }
      add_rows_of(k, false, k - begin);
    }
    const std::size_t left = s.last - begin;
    // A direction that nothing observes (heading of a lone antenna) is held: it couples to nothing. Within a
    // chain odometry observes all, and a floor there would act as a measured pose at every state.
    eliminate_slots(left, s.has_right ? 0.0 : kUnobservedFloor);
    if (!s.has_right) return;
    out_->D.assign(D(left), D(left) + n * n);
    out_->G.assign(G(left), G(left) + n * width_);
  }

  void eliminate_slots(std::size_t count, double floor_of_last) {
    eliminate({N, count, width_, D(0), U(0), G(0), H(0)}, floor_of_last, kUnobservedFloor);
  }
  /// The state behind the window becomes its first.
  void pass_on(std::size_t slot) {
    std::memcpy(D(0), D(slot), n * n * sizeof(double));
    std::memcpy(G(0), G(slot), n * width_ * sizeof(double));
    std::fill(D(1), D(slots_ + 1), 0.0);
    std::fill(U(0), U(slots_), 0.0);
    std::fill(G(1), G(slots_ + 1), 0.0);
  }

  void add_rows_of(std::size_t k, bool is_left, std::size_t slot) {
    const std::size_t node = segment_.first_node + k;
    is_left_ = is_left;
    slot_ = slot;
    for (; arrival_ < segment_.last_arrival && t_.arrivals[arrival_].node == node; ++arrival_) {
      if (t_.arrivals[arrival_].rejection != Rejection::kUsed) continue;
      if (is_planar_) {
        add_planar(t_.arrivals[arrival_], k);
      } else {
        add(arrival_rows(t_, arrival_, state_, rows_));
      }
    }
    for (; bearing_ < segment_.last_bearing && t_.bearings[bearing_].node == node; ++bearing_)
      if (t_.bearings[bearing_].rejection == Rejection::kUsed) add(bearing_rows(t_, bearing_, state_, rows_));
    for (; pose_ < segment_.last_pose && t_.poses[pose_].node == node; ++pose_)
      add(pose_rows(t_, pose_, rows_));
    for (; odometry_ < segment_.last_odometry && t_.odometry[odometry_].node == node; ++odometry_) {
      if constexpr (N == 3) {
        if (is_planar_) {
          add_planar(t_.odometry[odometry_], k);
          continue;
        }
      }
      add(odometry_rows(t_, odometry_, rows_));
    }
    for (; motion_ < segment_.last_motion && t_.motion_steps[motion_].node == node; ++motion_)
      add(motion_rows(t_, motion_, rows_));
  }

  [[nodiscard]] PlanarInterval interval_at(std::size_t k) const {
    const std::vector<PlanarNode>& states = local().states;
    const std::size_t i = k - stretch_->begin();
    return {states[i], states[std::min(i + 1, states.size() - 1)]};
  }

  void add_planar(const ArrivalObservation& a, std::size_t k) {
    whitening_.take(a);
    const PlanarArrival row(a, interval_at(k).at(a.alpha), state_, whitening_);
    const Eigen::Vector3d& o = state_.receiver_p_vehicle_m[a.receiver.index()];
    double base[PathColumns::kWhats];
    const double ux = row.direction[0], uy = row.direction[1], uz = row.direction[2];
    base[0] = -row.by_distance * ux;
    base[1] = -row.by_distance * uy;
    base[2] = -row.by_distance * uz;
    const double rx = row.by_distance * (row.cosine * ux + row.sine * uy),
                 ry = row.by_distance * (row.cosine * uy - row.sine * ux);
    base[PathColumns::kReceiver] = rx;
    base[PathColumns::kReceiver + 1] = ry;
    base[PathColumns::kReceiver + 2] = row.by_distance * uz;
    base[PathColumns::kTurn] = ry * o.x() - rx * o.y();
    base[PathColumns::kDelay] = whitening_.by_tof;
    base[PathColumns::kSpeed] = -row.by_distance * row.distance_m * whitening_.slowness;
    base[PathColumns::kOther] = 0.0;
    const PathColumns& path = chain_.columns_of(a.beacon, a.receiver);
    RowBorder border;
    for (int i = 0; i < path.count; ++i) {
      const PathColumns::Entry& e = path.entry[static_cast<std::size_t>(i)];
      if (e.what == PathColumns::kRadius)
        base[PathColumns::kRadius] = (rx * o.x() + ry * o.y()) / std::max(o.head<2>().norm(), 1e-300);
      push(border, e.column, base[e.what] * e.scale);
    }
    double rho = 0.0, w = 1.0;
    loss_.evaluate(row.residual, rho, w);
    const double before = 1.0 - a.alpha;
    const double by[3] = {row.by_x(), row.by_y(), row.by_heading};
    const double by_node[7] = {before * by[0], before * by[1], before * by[2]},
                 by_next[7] = {a.alpha * by[0], a.alpha * by[1], a.alpha * by[2]};
    add_row(row.residual, w, by_node, a.alpha == 0.0 ? nullptr : by_next, border);
  }

  void push(RowBorder& border, int global, double value) const {
    const int column = place_[static_cast<std::size_t>(global)];
    if (column < 0) return;
    const auto i = static_cast<std::size_t>(border.count++);
    border.at[i] = local().of_system[static_cast<std::size_t>(column)];
    border.value[i] = value;
  }

  void add_planar(const OdometryObservation& o, std::size_t k) {
    const PlanarStep step(o, o.T_before_after.heading_rad(), interval_at(k));
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero(), C = A, B = A;
    Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
    step.add_to(A, a, C, B, b);
    double* const D_next = D(is_left_ ? 0 : slot_ + 1);
    double* const G_next = G(is_left_ ? 0 : slot_ + 1);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto r = static_cast<Eigen::Index>(i);
      for (std::size_t j = 0; j < 3; ++j) {
        const auto c = static_cast<Eigen::Index>(j);
        if (is_left_) {
          if (j <= i) H(out_->left() + i)[out_->left() + j] += A(r, c);
          G_next[i * width_ + out_->left() + j] += C(c, r);
        } else {
          D(slot_)[i * n + j] += A(r, c);
          U(slot_)[i * n + j] += C(r, c);
        }
        D_next[i * n + j] += B(r, c);
      }
      (is_left_ ? H(gradient_)[out_->left() + i] : G(slot_)[i * width_ + gradient_]) += a[r];
      G_next[i * width_ + gradient_] += b[r];
    }
  }

  /// The rows of the array that were filled.
  void add(int count) {
    for (int i = 0; i < count; ++i) {
      const ObservationRow& row = rows_[i];
      double rho = 0.0, w = 1.0;
      if (is_robust(row.kind)) loss_.evaluate(row.residual, rho, w);
      const RowEntries e = row_entries(row, t_.run, chain_.layout(), state_);
      RowBorder border;
      for (std::size_t j = 0; j < static_cast<std::size_t>(e.count); ++j)
        push(border, e.column[j], e.value[j]);
      sort(border);
      add_row(row.residual, w, row.by_node.data(), row.has_next ? row.by_next.data() : nullptr, border);
    }
  }
  static void sort(RowBorder& border) {
    for (std::size_t i = 1; i < static_cast<std::size_t>(border.count); ++i)
      for (std::size_t j = i; j > 0 && border.at[j - 1] > border.at[j]; --j) {
        std::swap(border.at[j - 1], border.at[j]);
        std::swap(border.value[j - 1], border.value[j]);
      }
  }

  /// @param a, b  derivatives by the state and, where there is one, by the next
  void add_row(double residual, double w, const double* a, const double* b, const RowBorder& border) {
    const auto count = static_cast<std::size_t>(border.count);
    double* const gradient = H(gradient_);
    for (std::size_t i = 0; i < count; ++i) {
      const double wi = w * border.value[i];
      double* const row = H(static_cast<std::size_t>(border.at[i]));
      for (std::size_t j = 0; j <= i; ++j) row[border.at[j]] += wi * border.value[j];
      gradient[border.at[i]] += wi * residual;
    }
    if (is_left_) {
      for (std::size_t i = 0; i < n; ++i) {
        double* const row = H(out_->left() + i);
        const double wa = w * a[i];
        for (std::size_t j = 0; j < count; ++j) row[border.at[j]] += wa * border.value[j];
        for (std::size_t j = 0; j <= i; ++j) row[out_->left() + j] += wa * a[j];
        gradient[out_->left() + i] += wa * residual;
      }
    } else {
      add_state(slot_, w, residual, a, border);
    }
    if (b == nullptr) return;
    const std::size_t next = is_left_ ? 0 : slot_ + 1;
    add_state(next, w, residual, b, border);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        if (is_left_) {
          G(0)[i * width_ + out_->left() + j] += w * b[i] * a[j];
        } else {
          U(slot_)[i * n + j] += w * a[i] * b[j];
        }
      }
  }
  void add_state(std::size_t slot, double w, double residual, const double* a, const RowBorder& border) {
    double* const block = D(slot);
    for (std::size_t i = 0; i < n; ++i) {
      const double wa = w * a[i];
      for (std::size_t j = 0; j < n; ++j) block[i * n + j] += wa * a[j];
      double* const row = G(slot) + i * width_;
      for (std::size_t j = 0; j < static_cast<std::size_t>(border.count); ++j)
        row[border.at[j]] += wa * border.value[j];
      row[gradient_] += wa * residual;
    }
  }

  const ChainReduction& chain_;
  const Trajectory& t_;
  const Segment& segment_;
  const SharedState& state_;
  const RobustLoss& loss_;
  const std::vector<int>& place_;
  PlanarWhitening whitening_;
  bool is_planar_;
  const Stretch* stretch_ = nullptr;
  Remains* out_ = nullptr;
  std::size_t width_ = 0, gradient_ = 0, slots_ = 0;
  std::size_t arrival_ = 0, bearing_ = 0, pose_ = 0, odometry_ = 0, motion_ = 0;
  bool is_left_ = false;  ///< the rows at hand belong to the left end, which is part of the border
  std::size_t slot_ = 0;
  ObservationRow rows_[6];
};

}  // namespace octant::calib::chain

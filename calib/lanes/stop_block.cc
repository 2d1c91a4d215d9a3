// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/lanes/stop_block.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/sums/reduced_system.h"

namespace octant::calib {
namespace {

/// A group is closed at new beacons once it has this many packs: adding it to the tile's system is then a
/// small part.
constexpr std::size_t kEnoughPacks = 4;
/// A group does not contain many more beacons than its epochs receive, because all pairs of columns are
/// computed.
constexpr double kMostBeacons = 1.5;
constexpr std::size_t kNoPose = std::numeric_limits<std::size_t>::max();

void prefetch(const void* from, std::size_t bytes) {
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < bytes; at += kLine) __builtin_prefetch(static_cast<const char*>(from) + at);
}

/// Arrivals over a path.
struct Tally {
  std::uint32_t here = 0, stamp = 0;  ///< in an epoch, and in which
  std::uint32_t most = 0;             ///< in an epoch of the pack
  std::size_t first = 0;              ///< slot
};

}  // namespace

StopArrivals::StopArrivals(const Trajectory& t)
    : tof_s_(
          std::make_unique_for_overwrite<double[]>(t.arrivals.size())),  // NOLINT(modernize-avoid-c-arrays)
      path_(std::make_unique_for_overwrite<std::uint32_t[]>(
          t.arrivals.size())),  // NOLINT(modernize-avoid-c-arrays)
      speed_mps_(t.arrivals.front().model_speed_mps) {}

void StopArrivals::add(std::size_t i, const ArrivalObservation& a) {
  if (a.model_speed_mps != speed_mps_) own_speeds_ = true;
  tof_s_[i] = a.tof_s;
  path_[i] = a.rejection == Rejection::kUsed
                 ? static_cast<std::uint32_t>(a.beacon.index() << kReceiverBits | a.receiver.index())
                 : kNotUsed;
}

void StopArrivals::prefetch(std::size_t first, std::size_t last) const {
  calib::prefetch(&tof_s_[first], (last - first) * sizeof(double));
  calib::prefetch(&path_[first], (last - first) * sizeof(std::uint32_t));
}

bool StopBlock::knows(const Trajectory& t, const ParameterLayout& layout) {
  const bool drifts = layout.column_of(parameters::clock_drift(t.vehicle.index())) >= 0 ||
                      layout.fixed.drift(t.vehicle) != 0.0;
  return t.motion == Motion::kPlanar && !t.motion_prior && layout.fixed.has_plain_paths() &&
         layout.fixed.pair_bias_s.empty() && !drifts &&
         layout.vehicle_of_receiver.size() <= StopArrivals::kMostReceivers &&
         layout.beacon.size() <= StopArrivals::kMostBeacons;
}

bool StopBlock::takes(const Trajectory& t, const Segment& s) {
  if (s.last_node - s.first_node != 1 || s.first_bearing != s.last_bearing ||
      s.last_pose - s.first_pose > 1 || s.first_arrival == s.last_arrival || !t.nodes[s.first_node].placed)
    return false;
  if (s.first_pose != s.last_pose && t.poses[s.first_pose].alpha != 0.0) return false;
  const double sigma_s = t.arrivals.front().sigma_s;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    if (t.arrivals[i].two_way || t.arrivals[i].alpha != 0.0 || t.arrivals[i].sigma_s != sigma_s) return false;
  return true;
}

StopBlock::StopBlock(Trajectory* trajectory, const std::vector<std::size_t>& segments,
                     const StopArrivals& arrivals, const ParameterLayout* layout)
    : trajectory_(trajectory),
      layout_(layout),
      sigma_s_(trajectory->arrivals.front().sigma_s),
      speed_mps_(arrivals.speed_mps()),
      own_speeds_(arrivals.own_speeds()) {
  const auto& vehicles = layout->vehicle_of_receiver;
  const auto mine = std::ranges::find(vehicles, trajectory->vehicle);
  first_receiver_ = static_cast<std::size_t>(mine - vehicles.begin());
  receivers_ = static_cast<std::size_t>(std::ranges::count(vehicles, trajectory->vehicle));
  // Epochs with the same beacons are far apart in a long log, so their memory is prefetched.
  constexpr std::size_t kAhead = 24;
  epochs_.reserve(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (i + kAhead < segments.size()) prefetch(&trajectory->segments[segments[i + kAhead]], sizeof(Segment));
    const Segment& s = trajectory->segments[segments[i]];
    epochs_.push_back({segments[i], s.first_node, s.first_arrival, s.last_arrival,
                       s.first_pose != s.last_pose ? s.first_pose : kNoPose});
  }
  group(arrivals);
  pack(arrivals);
  commit();
}

void StopBlock::fetch(std::size_t p, const StopArrivals& arrivals) const {
  for (std::size_t e = p * kLanes; e < p * kLanes + epochs_in(p); ++e) {
    const Epoch& epoch = epochs_[e];
    prefetch(&trajectory_->nodes[epoch.node], sizeof(Node));
    arrivals.prefetch(epoch.first_arrival, epoch.last_arrival);
  }
}

void StopBlock::group(const StopArrivals& arrivals) {
  const std::size_t packs = (epochs_.size() + kLanes - 1) / kLanes,
                    none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> group_of(layout_->beacon.size(), none),
      pack_of(layout_->beacon.size(), none);  // of each beacon, the last that heard it
  std::size_t heard_by_first = 0;
  for (std::size_t p = 0; p < packs; ++p) {
    std::vector<std::int32_t> heard;
    std::size_t unknown = 0;
    if (p + 1 < packs) fetch(p + 1, arrivals);
    for (std::size_t e = p * kLanes; e < p * kLanes + epochs_in(p); ++e)
      for (std::size_t i = epochs_[e].first_arrival; i < epochs_[e].last_arrival; ++i) {
        if (!arrivals.used(i)) continue;
        const std::size_t beacon = arrivals.beacon(i);
        if (pack_of[beacon] == p) continue;
        pack_of[beacon] = p;
        heard.push_back(static_cast<std::int32_t>(beacon));
        if (groups_.empty() || group_of[beacon] != groups_.size() - 1) ++unknown;
      }
    const bool close = !groups_.empty() && unknown > 0 &&
                       (p - groups_.back().first >= kEnoughPacks ||
                        static_cast<double>(groups_.back().beacons.size() + unknown) >
                            kMostBeacons * static_cast<double>(std::max(heard_by_first, heard.size())));
    if (groups_.empty() || close) {
      groups_.push_back({p, p, {}});
      heard_by_first = heard.size();
    }
    PackGroup& g = groups_.back();
    g.last = p + 1;
    for (const std::int32_t beacon : heard) {
      auto& of = group_of[static_cast<std::size_t>(beacon)];
      if (of != groups_.size() - 1) g.beacons.push_back(beacon);
      of = groups_.size() - 1;
    }
  }
  for (PackGroup& g : groups_) std::ranges::sort(g.beacons);
}

void StopBlock::pack(const StopArrivals& arrivals) {
  const Trajectory& t = *trajectory_;
  Lanes nothing, usual;
  std::ranges::fill(nothing.of, NAN);
  std::ranges::fill(usual.of, t.nominal_speed_mps);
  std::vector<std::size_t> local(layout_->beacon.size(), 0);
  std::vector<Tally> count;  // of the present group's paths
  std::uint32_t stamp = 0;
  // Calls visit(arrival, path) for those in use of an epoch, with how many came over that path before.
  const auto for_each_used = [&](std::size_t epoch, auto&& visit) {
    ++stamp;
    for (std::size_t i = epochs_[epoch].first_arrival; i < epochs_[epoch].last_arrival; ++i) {
      if (!arrivals.used(i)) continue;
      Tally& path = count[local[arrivals.beacon(i)] * receivers_ + arrivals.receiver(i) - first_receiver_];
      if (path.stamp != stamp) path.here = 0;
      path.stamp = stamp;
      visit(i, path);
      ++path.here;
    }
  };
  const auto begin_group = [&](const PackGroup& g) {
    for (std::size_t i = 0; i < g.beacons.size(); ++i) local[static_cast<std::size_t>(g.beacons[i])] = i;
    count.assign(g.beacons.size() * receivers_, {});
  };
  pack_first_.reserve(epochs_.size() / kLanes + 2);
  for (const PackGroup& g : groups_) {
    begin_group(g);
    for (std::size_t p = g.first; p < g.last; ++p) {
      for (Tally& path : count) path.most = 0;
      for (std::size_t e = p * kLanes; e < p * kLanes + epochs_in(p); ++e)
        for_each_used(
            e, [](std::size_t /*arrival*/, Tally& path) { path.most = std::max(path.most, path.here + 1); });
      pack_first_.push_back(slots_.size());
      for (std::size_t r = 0; r < receivers_; ++r)
        for (std::size_t b = 0; b < g.beacons.size(); ++b)
          for (std::uint32_t k = 0; k < count[b * receivers_ + r].most; ++k)
            slots_.push_back({static_cast<std::uint16_t>(b), static_cast<std::uint16_t>(r)});
    }
  }
  pack_first_.push_back(slots_.size());
  states_.resize(pack_first_.size() - 1);
  tof_s_.assign(slots_.size(), nothing);
  if (own_speeds_) model_speed_mps_.assign(slots_.size(), usual);
  for (const PackGroup& g : groups_) {
    begin_group(g);
    for (std::size_t p = g.first; p < g.last; ++p) {
      for (std::size_t slot = pack_first_[p + 1]; slot-- > pack_first_[p];)
        count[slots_[slot].beacon * receivers_ + slots_[slot].receiver].first = slot;
      for (std::size_t e = p * kLanes; e < p * kLanes + epochs_in(p); ++e) {
        const std::size_t lane = e % kLanes;
        for_each_used(e, [&](std::size_t i, const Tally& path) {
          tof_s_[path.first + path.here].of[lane] = arrivals.tof_s(i);
          if (own_speeds_) model_speed_mps_[path.first + path.here].of[lane] = t.arrivals[i].model_speed_mps;
        });
        put(e, t.nodes[epochs_[e].node]);
        if (epochs_[e].pose != kNoPose) put(e, t.poses[epochs_[e].pose]);
      }
    }
  }
}

void StopBlock::collect_heard(std::vector<char>& beacons, std::vector<char>& receivers) const {
  for (const PackGroup& g : groups_)
    for (const std::int32_t b : g.beacons) beacons[static_cast<std::size_t>(b)] = 1;
  for (const StopSlot& slot : slots_) receivers[first_receiver_ + slot.receiver] = 1;
}

void StopBlock::put(std::size_t epoch, const Node& node) {
  Lanes* value = states_[epoch / kLanes].value;
  const std::size_t lane = epoch % kLanes;
  value[0].of[lane] = node.T_map_vehicle.translation_m.x();
  value[1].of[lane] = node.T_map_vehicle.translation_m.y();
  value[2].of[lane] = node.T_map_vehicle.heading_rad();
  value[3].of[lane] = node.cycle_offset_s * trajectory_->nominal_speed_mps;
}

void StopBlock::put(std::size_t epoch, const PoseObservation& pose) {
  if (poses_.empty()) poses_.resize(states_.size());
  StopPoses& poses = poses_[epoch / kLanes];
  const std::size_t lane = epoch % kLanes;
  const Eigen::Vector3d value(pose.T_map_vehicle.translation_m.x(), pose.T_map_vehicle.translation_m.y(),
                              pose.T_map_vehicle.heading_rad());
  const Eigen::Vector3d sigma(pose.position_sigma_m, pose.position_sigma_m, pose.heading_sigma_rad);
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(sigma[i])) continue;
    poses.value[i].of[lane] = value[i];
    poses.weight[i].of[lane] = 1.0 / (sigma[i] * sigma[i]);
  }
}

void StopBlock::show(std::size_t epoch) {
  const Lanes* value = states_[epoch / kLanes].value;
  const std::size_t lane = epoch % kLanes;
  Node& node = trajectory_->nodes[epochs_[epoch].node];
  node.T_map_vehicle = Pose::planar(value[0].of[lane], value[1].of[lane], value[2].of[lane]);
  node.cycle_offset_s = value[3].of[lane] / trajectory_->nominal_speed_mps;
}

StopTables StopBlock::tables_at(const SharedState& state, const RobustLoss& loss) {
  beacon_table_.clear();
  for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b) {
    const Eigen::Vector3d& p = state.beacon_p_map_m[b];
    beacon_table_.insert(beacon_table_.end(),
                         {p.x(), p.y(), p.z(), state.beacon_delay_s[b] + state.site_delay_s});
  }
  receiver_table_.clear();
  for (std::size_t r = first_receiver_; r < first_receiver_ + receivers_; ++r) {
    const Eigen::Vector3d& o = state.receiver_p_vehicle_m[r];
    receiver_table_.insert(receiver_table_.end(), {o.x(), o.y(), o.z(), state.receiver_delay_s[r]});
  }
  StopTables tables;
  tables.beacon = beacon_table_.data();
  tables.receiver = receiver_table_.data();
  tables.speed_offset_mps = state.speed_offset(trajectory_->run);
  tables.speed_mps = speed_mps_ + tables.speed_offset_mps;
  tables.sigma_s = sigma_s_;
  tables.late_scale = loss.late_scale;
  tables.early_scale = loss.early_scale;
  tables.has_offset = trajectory_->has_cycle_offset;
  tables.nominal_speed_mps = trajectory_->nominal_speed_mps;
  return tables;
}

StopPack StopBlock::pack_of(std::size_t p, const PackGroup& group) const {
  const std::size_t first = pack_first_[p];
  return {pack_first_[p + 1] - first, slots_.data() + first,
          tof_s_.data() + first,      own_speeds_ ? model_speed_mps_.data() + first : nullptr,
          group.beacons.data(),       poses_.empty() ? nullptr : &poses_[p]};
}

double StopBlock::solve_states(const SharedState& state, const RobustLoss& loss) {
  const StopTables tables = tables_at(state, loss);
  double cost = 0.0;
  states_ = committed_;
  for (const PackGroup& g : groups_)
    for (std::size_t p = g.first; p < g.last; ++p) {
      StopOutcome outcome;
      solve_stops(tables, pack_of(p, g), states_[p], outcome);
      for (std::size_t lane = 0; lane < epochs_in(p); ++lane) {
        if (outcome.converged.of[lane] == 1.0) {
          cost += outcome.cost.of[lane];
          continue;
        }
        const std::size_t epoch = p * kLanes + lane;
        show(epoch);
        cost += octant::solve_states(*trajectory_, trajectory_->segments[epochs_[epoch].segment], state, loss)
                    .cost;
        put(epoch, trajectory_->nodes[epochs_[epoch].node]);
      }
    }
  return cost;
}

std::vector<StopBlock::ColumnTargets> StopBlock::targets_of(const PackGroup& group, const SharedState& state,
                                                            const std::vector<int>& place) const {
  const StopLayout local{group.beacons.size(), receivers_, false, {}};
  std::vector<ColumnTargets> targets(local.columns());
  const auto aim = [&](std::size_t column, int parameter, double factor) {
    const int at = parameter < 0 ? -1 : place[static_cast<std::size_t>(parameter)];
    if (at < 0) return;
    ColumnTargets& t = targets[column];
    t.column[t.count] = at;
    t.factor[t.count++] = factor * layout_->parameter(parameter).si_per_unit;
  };
  for (std::size_t i = 0; i < group.beacons.size(); ++i) {
    const auto b = static_cast<std::size_t>(group.beacons[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) aim(4 * i + axis, layout_->beacon[b][axis], 1.0);
    aim(4 * i + 3, layout_->column_of(parameters::beacon_delay(b)), 1.0);
    aim(4 * i + 3, layout_->column_of(parameters::site_delay()), 1.0);
  }
  const bool array = layout_->has_array(trajectory_->vehicle);
  for (std::size_t i = 0; i < receivers_; ++i) {
    const std::size_t r = first_receiver_ + i, at = local.of_receiver(i);
    if (array) {
      const Eigen::Vector2d o = state.receiver_p_vehicle_m[r].head<2>(), outward = o.normalized();
      const std::size_t vehicle = trajectory_->vehicle.index();
      const int radius = layout_->column_of(parameters::array_radius(vehicle)),
                turn = layout_->column_of(parameters::array_turn(vehicle));
      aim(at, radius, outward.x());
      aim(at + 1, radius, outward.y());
      aim(at, turn, -o.y());
      aim(at + 1, turn, o.x());
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) aim(at + axis, layout_->receiver[r][axis], 1.0);
    }
    aim(at + 3, layout_->column_of(parameters::receiver_delay(r)), 1.0);
  }
  aim(local.speed(), layout_->speed_column(trajectory_->run), 1.0);
  return targets;
}

void StopBlock::add_group(const PackGroup& group, const StopTables& tables, const SharedState& state,
                          const std::vector<int>& place, ReducedSystem& system) {
  const std::vector<ColumnTargets> targets = targets_of(group, state, place);
  StopLayout local{group.beacons.size(), receivers_, false, {}};
  for (std::size_t c = 0; c < targets.size(); ++c) {
    if (targets[c].count == 0) continue;
    local.active.push_back(c);
    local.receivers_free = local.receivers_free || (c >= local.of_receiver(0) && c < local.speed());
  }
  thread_local StopSums sums;
  thread_local std::vector<double> H, gradient;
  sums.clear(local, tables.has_offset);
  for (std::size_t p = group.first; p < group.last; ++p)
    reduce_stops(tables, pack_of(p, group), states_[p], local, kUnobservedFloor, sums);
  sums.finish(local, tables.sigma_s, H, gradient);
  const std::size_t stride = local.columns();
  for (const std::size_t i : local.active) {
    const ColumnTargets& ti = targets[i];
    for (int m = 0; m < ti.count; ++m) system.gradient[ti.column[m]] += ti.factor[m] * gradient[i];
    for (const std::size_t j : local.active) {
      const ColumnTargets& tj = targets[j];
      const double h = i <= j ? H[i * stride + j] : H[j * stride + i];
      for (int m = 0; m < ti.count; ++m)
        for (int n = 0; n < tj.count; ++n)
          if (ti.column[m] >= tj.column[n])
            system.H(ti.column[m], tj.column[n]) += ti.factor[m] * tj.factor[n] * h;
    }
  }
}

void StopBlock::reduce(const SharedState& state, const RobustLoss& loss, const std::vector<int>& place,
                       ReducedSystem& system) {
  const StopTables tables = tables_at(state, loss);
  for (const PackGroup& group : groups_) add_group(group, tables, state, place, system);
}

void StopBlock::rewind() {
  states_ = committed_;
  for (std::size_t e = 0; e < epochs_.size(); ++e) show(e);
}

}  // namespace octant::calib

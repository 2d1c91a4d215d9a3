// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stop_block.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/tile.h"

namespace octant::calib {
namespace {

constexpr std::size_t kMaxLocal = 255;  ///< indices within a group are bytes

/// Beacons of a segment's arrivals in use, ascending, each once.
std::vector<std::int32_t> beacons_of(const Trajectory& t, const Segment& s) {
  std::vector<std::int32_t> beacons;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    if (t.arrivals[i].rejection == Rejection::kUsed) beacons.push_back(t.arrivals[i].beacon.value);
  std::sort(beacons.begin(), beacons.end());
  beacons.erase(std::unique(beacons.begin(), beacons.end()), beacons.end());
  return beacons;
}

}  // namespace

bool StopBlock::knows(const Trajectory& t, const ParameterLayout& layout) {
  const std::size_t vehicle = t.vehicle.index();
  const bool drifts = vehicle < layout.clock_drift.size() && (layout.clock_drift[vehicle] >= 0 || layout.fixed.drift(t.vehicle) != 0.0);
  return t.motion == Motion::kPlanar && !t.motion_prior && !layout.fixed.attenuation && layout.fixed.pair_bias_s.empty() && !drifts &&
         layout.vehicle_of_receiver.size() <= kMaxLocal;
}

bool StopBlock::takes(const Trajectory& t, const Segment& s) {
  if (s.last_node - s.first_node != 1 || s.first_bearing != s.last_bearing || s.first_pose != s.last_pose || s.first_arrival == s.last_arrival ||
      !t.nodes[s.first_node].placed)
    return false;
  const double sigma_s = t.arrivals[s.first_arrival].sigma_s;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    if (t.arrivals[i].two_way || t.arrivals[i].alpha != 0.0 || t.arrivals[i].sigma_s != sigma_s) return false;
  return true;
}

StopBlock::StopBlock(Trajectory* trajectory, const std::vector<std::size_t>& segments, const ParameterLayout* layout)
    : trajectory_(trajectory), layout_(layout) {
  const auto& vehicles = layout->vehicle_of_receiver;
  const auto mine = std::find(vehicles.begin(), vehicles.end(), trajectory->vehicle);
  first_receiver_ = static_cast<std::size_t>(mine - vehicles.begin());
  receivers_ = static_cast<std::size_t>(std::count(vehicles.begin(), vehicles.end(), trajectory->vehicle));
  order(segments);
  pack();
  commit();
}

/// Epochs that hear the same beacons together, those with more arrivals first, so that lanes run out at about the same slot.
void StopBlock::order(const std::vector<std::size_t>& segments) {
  struct Key {
    std::vector<std::int32_t> beacons;
    std::size_t arrivals = 0;
  };
  std::vector<Key> keys;
  std::vector<std::size_t> by_key(segments.size());
  std::iota(by_key.begin(), by_key.end(), std::size_t{0});
  for (const std::size_t s : segments) {
    const Segment& segment = trajectory_->segments[s];
    keys.push_back({beacons_of(*trajectory_, segment), segment.last_arrival - segment.first_arrival});
  }
  std::sort(by_key.begin(), by_key.end(), [&keys](std::size_t a, std::size_t b) {
    if (keys[a].beacons != keys[b].beacons) return keys[a].beacons < keys[b].beacons;
    return keys[a].arrivals != keys[b].arrivals ? keys[a].arrivals > keys[b].arrivals : a < b;
  });
  for (const std::size_t k : by_key) {
    if (groups_.empty() || groups_.back().beacons != keys[k].beacons) groups_.push_back({epochs_.size(), epochs_.size(), keys[k].beacons});
    epochs_.push_back({segments[k], trajectory_->segments[segments[k]].first_node});
    groups_.back().last = epochs_.size();
  }
}

void StopBlock::pack() {
  const Trajectory& t = *trajectory_;
  const std::size_t packs = (epochs_.size() + kLanes - 1) / kLanes;
  states_.resize(packs);
  std::vector<std::vector<std::size_t>> used(kLanes);
  std::size_t group = 0;
  double speed_mps = NAN;
  for (std::size_t p = 0; p < packs; ++p) {
    std::size_t slots = 0;
    std::size_t group_of[kLanes] = {};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      used[lane].clear();
      const std::size_t e = p * kLanes + lane;
      if (e >= epochs_.size()) continue;
      while (e >= groups_[group].last) ++group;
      group_of[lane] = group;
      const Segment& s = t.segments[epochs_[e].segment];
      for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
        if (t.arrivals[i].rejection == Rejection::kUsed) used[lane].push_back(i);
      slots = std::max(slots, used[lane].size());
      const Node& node = t.nodes[epochs_[e].node];
      states_[p].value[0][lane] = node.T_map_vehicle.translation_m.x();
      states_[p].value[1][lane] = node.T_map_vehicle.translation_m.y();
      states_[p].value[2][lane] = node.T_map_vehicle.heading_rad();
      states_[p].value[3][lane] = node.cycle_offset_s * t.nominal_speed_mps;
    }
    const std::size_t first = tof_s_.size() / kLanes;
    pack_first_.push_back(first);
    tof_s_.resize((first + slots) * kLanes, 0.0);
    model_speed_mps_.resize((first + slots) * kLanes, t.nominal_speed_mps);
    beacon_.resize((first + slots) * kLanes, -1);
    receiver_.resize((first + slots) * kLanes, static_cast<std::int32_t>(first_receiver_));
    local_beacon_.resize((first + slots) * kLanes, 0);
    local_receiver_.resize((first + slots) * kLanes, 0);
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      for (std::size_t slot = 0; slot < used[lane].size(); ++slot) {
        const ArrivalObservation& a = t.arrivals[used[lane][slot]];
        const std::size_t at = (first + slot) * kLanes + lane;
        const auto& beacons = groups_[group_of[lane]].beacons;
        tof_s_[at] = a.tof_s;
        beacon_[at] = a.beacon.value;
        receiver_[at] = a.receiver.value;
        local_beacon_[at] = static_cast<std::uint8_t>(std::lower_bound(beacons.begin(), beacons.end(), a.beacon.value) - beacons.begin());
        local_receiver_[at] = static_cast<std::uint8_t>(a.receiver.index() - first_receiver_);
        model_speed_mps_[at] = a.model_speed_mps;
        sigma_s_ = a.sigma_s;
        if (std::isnan(speed_mps)) speed_mps = a.model_speed_mps;
        own_speeds_ = own_speeds_ || a.model_speed_mps != speed_mps;
      }
  }
  pack_first_.push_back(tof_s_.size() / kLanes);
  if (own_speeds_) return;
  model_speed_mps_.assign(1, speed_mps);  // one for all
  model_speed_mps_.shrink_to_fit();
}

StopTables StopBlock::tables_at(const SharedState& state, const RobustLoss& loss) {
  beacon_table_.clear();
  for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b) {
    const Eigen::Vector3d& p = state.beacon_p_map_m[b];
    beacon_table_.insert(beacon_table_.end(), {p.x(), p.y(), p.z(), state.beacon_delay_s[b] + state.site_delay_s});
  }
  receiver_table_.clear();
  for (std::size_t r = 0; r < state.receiver_p_vehicle_m.size(); ++r) {
    const Eigen::Vector3d& o = state.receiver_p_vehicle_m[r];
    receiver_table_.insert(receiver_table_.end(), {o.x(), o.y(), o.z(), state.receiver_delay_s[r]});
  }
  StopTables tables;
  tables.beacon = beacon_table_.data();
  tables.receiver = receiver_table_.data();
  tables.speed_offset_mps = state.speed_offset(trajectory_->run);
  tables.speed_mps = (own_speeds_ ? 0.0 : model_speed_mps_.front()) + tables.speed_offset_mps;
  tables.sigma_s = sigma_s_;
  tables.late_scale = loss.late_scale;
  tables.early_scale = loss.early_scale;
  tables.has_offset = trajectory_->has_cycle_offset;
  tables.nominal_speed_mps = trajectory_->nominal_speed_mps;
  return tables;
}

StopLanes StopBlock::lanes_of(std::size_t p) const {
  const std::size_t first = pack_first_[p] * kLanes;
  return {pack_first_[p + 1] - pack_first_[p], tof_s_.data() + first, beacon_.data() + first, receiver_.data() + first,
          own_speeds_ ? model_speed_mps_.data() + first : nullptr};
}

void StopBlock::write_back(std::size_t p) {
  for (std::size_t lane = 0; lane < kLanes && p * kLanes + lane < epochs_.size(); ++lane) {
    Node& node = trajectory_->nodes[epochs_[p * kLanes + lane].node];
    const auto& v = states_[p].value;
    node.T_map_vehicle = Pose::planar(v[0][lane], v[1][lane], v[2][lane]);
    node.cycle_offset_s = v[3][lane] / trajectory_->nominal_speed_mps;
  }
}

double StopBlock::settle_all(const StopTables& tables, const SharedState& state, const RobustLoss& loss) {
  double cost = 0.0;
  states_ = committed_;
  for (std::size_t p = 0; p < states_.size(); ++p) {
    StopOutcome outcome;
    settle_stops(tables, lanes_of(p), states_[p], outcome);
    write_back(p);
    for (std::size_t lane = 0; lane < kLanes && p * kLanes + lane < epochs_.size(); ++lane) {
      if (outcome.converged[lane] == 1.0) {
        cost += outcome.cost[lane];
        continue;
      }
      const Epoch& epoch = epochs_[p * kLanes + lane];
      cost += octant::settle(*trajectory_, trajectory_->segments[epoch.segment], state, loss).cost;
      const Node& node = trajectory_->nodes[epoch.node];
      auto& v = states_[p].value;
      v[0][lane] = node.T_map_vehicle.translation_m.x();
      v[1][lane] = node.T_map_vehicle.translation_m.y();
      v[2][lane] = node.T_map_vehicle.heading_rad();
      v[3][lane] = node.cycle_offset_s * trajectory_->nominal_speed_mps;
    }
  }
  return cost;
}

void StopBlock::add_group(const Group& group, const StopTables& tables, const SharedState& state, const std::vector<int>& place,
                          ReducedSystem& system) {
  const StopLayout local{group.beacons.size(), receivers_};
  const std::size_t stride = local.stride();
  constexpr std::size_t kRowsAtOnce = 48;  ///< together with H's block they stay in the first cache
  thread_local std::vector<double> H, gradient, rows;
  H.assign(stride * stride, 0.0);
  gradient.assign(stride, 0.0);
  rows.resize((kRowsAtOnce + 4) * stride);
  std::size_t waiting = 0;
  for (std::size_t e = group.first; e < group.last; ++e) {
    const std::size_t p = e / kLanes, lane = e % kLanes, first = pack_first_[p] * kLanes;
    const StopLanes lanes = lanes_of(p);
    const auto& v = states_[p].value;
    const StopEpoch epoch{&lanes, lane, local_beacon_.data() + first, local_receiver_.data() + first, v[0][lane], v[1][lane], v[2][lane], v[3][lane]};
    waiting += static_cast<std::size_t>(reduce_stop(tables, epoch, local, kUnobservedFloor, H.data(), gradient.data(), rows.data() + waiting * stride));
    if (waiting < kRowsAtOnce) continue;
    take_away(rows.data(), waiting, stride, H.data());
    waiting = 0;
  }
  take_away(rows.data(), waiting, stride, H.data());
  // Where each local column goes: nowhere if it is held, to several places if they share it.
  std::vector<std::vector<Target>> targets(local.speed() + 1);
  const auto aim = [&](std::size_t column, int parameter, double factor) {
    const int at = parameter < 0 ? -1 : place[static_cast<std::size_t>(parameter)];
    if (at >= 0) targets[column].push_back({at, factor * layout_->parameters[static_cast<std::size_t>(parameter)].si_per_unit});
  };
  for (std::size_t i = 0; i < group.beacons.size(); ++i) {
    const auto b = static_cast<std::size_t>(group.beacons[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) aim(4 * i + axis, layout_->beacon[b][axis], 1.0);
    aim(4 * i + 3, layout_->beacon_delay[b], 1.0);
    aim(4 * i + 3, layout_->site_delay, 1.0);
  }
  const bool array = layout_->has_array(trajectory_->vehicle);
  for (std::size_t i = 0; i < receivers_; ++i) {
    const std::size_t r = first_receiver_ + i, at = 4 * (group.beacons.size() + i);
    if (array) {
      const Eigen::Vector2d o = state.receiver_p_vehicle_m[r].head<2>(), outward = o.normalized();
      const auto& columns = layout_->array[trajectory_->vehicle.index()];
      aim(at, columns[0], outward.x());
      aim(at + 1, columns[0], outward.y());
      aim(at, columns[1], -o.y());
      aim(at + 1, columns[1], o.x());
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) aim(at + axis, layout_->receiver[r][axis], 1.0);
    }
    aim(at + 3, layout_->receiver_delay[r], 1.0);
  }
  aim(local.speed(), layout_->speed_column(trajectory_->run), 1.0);
  for (std::size_t i = 0; i < targets.size(); ++i)
    for (const Target& ti : targets[i]) {
      system.gradient[ti.column] += ti.factor * gradient[i];
      for (std::size_t j = 0; j < targets.size(); ++j) {
        const double h = i <= j ? H[i * stride + j] : H[j * stride + i];
        for (const Target& tj : targets[j])
          if (ti.column >= tj.column) system.H(ti.column, tj.column) += ti.factor * tj.factor * h;
      }
    }
}

double StopBlock::settle(const SharedState& state, const RobustLoss& loss) { return settle_all(tables_at(state, loss), state, loss); }

void StopBlock::reduce(const SharedState& state, const RobustLoss& loss, const std::vector<int>& place, ReducedSystem& system) {
  const StopTables tables = tables_at(state, loss);
  for (const Group& group : groups_) add_group(group, tables, state, place, system);
}

void StopBlock::rewind() {
  states_ = committed_;
  for (std::size_t p = 0; p < states_.size(); ++p) write_back(p);
}

}  // namespace octant::calib

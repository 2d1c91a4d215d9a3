// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/drive_index.h"

#include <algorithm>
#include <cmath>

#include "calib/problem/problem.h"
#include "calib/problem/subsample.h"
#include "models/trajectory/state_kind.h"

namespace octant::calib {
namespace {

/// The states of a vehicle are at its odometry rows.
DriveChain chain_of(const MeasurementLog& log, std::size_t run, VehicleId vehicle, std::size_t beacons,
                    const TrajectoryModel& model) {
  DriveChain chain;
  chain.run = run;
  chain.vehicle = vehicle;
  if (state_kind(log, vehicle, model) != StateKind::kDrive) return chain;
  for (std::size_t row = 0; row < log.odometry.size(); ++row) {
    if (log.odometry[row].vehicle != vehicle) continue;
    if (chain.nodes % kUnitNodes == 0) {
      chain.units.emplace_back();
      chain.units.back().from_s = log.odometry[row].time_s;
      chain.units.back().first_row = row;
    }
    chain.until_s = log.odometry[row].time_s;
    chain.last_row = row;
    ++chain.nodes;
  }
  // A unit needs a second state.
  if (chain.units.size() > 1 && chain.nodes % kUnitNodes == 1) chain.units.pop_back();
  chain.stateless.assign(beacons, 0);
  return chain;
}

/// The unit of an instant, looked for from where the last one was.
std::size_t unit_at(const DriveChain& chain, double time_s, std::size_t from) {
  if (chain.units[from].from_s > time_s) from = 0;
  while (from + 1 < chain.units.size() && chain.units[from + 1].from_s <= time_s) ++from;
  return from;
}

bool is_within(const DriveChain& chain, double time_s) {
  return time_s >= chain.units.front().from_s && time_s <= chain.until_s;
}

}  // namespace

std::size_t DriveChain::nodes_of(std::size_t unit) const {
  return unit + 1 < units.size() ? kUnitNodes + 1 : nodes - unit * kUnitNodes;
}

std::int64_t DriveGroups::key_at(double time_s) const {
  return static_cast<std::int64_t>(std::floor((time_s - begin_s) / length_s));
}

DriveIndex::DriveIndex(const ArrivalSource& source, const Site& site)
    : vehicles_(site.vehicles.size()),
      beacons_(site.beacons.size()),
      groups_(source.runs()),
      blocks_(source.runs(), 0),
      unit_of_chain_(source.runs() * vehicles_, 0) {
  const TrajectoryModel model = trajectory_model(site);
  for (std::size_t run = 0; run < source.runs(); ++run)
    for (std::size_t v = 0; v < vehicles_; ++v)
      chains_.push_back(chain_of(source.log(run), run, VehicleId(v), beacons_, model));
  for (DriveGroups& of_run : groups_) {
    of_run.length_s = drive_stretches(site).length_s;
    of_run.latest.assign(vehicles_, SIZE_MAX);
  }
}

void DriveIndex::add(std::size_t run, const std::vector<Arrival>& rows) {
  const std::size_t block = blocks_[run]++;
  for (const Arrival& a : rows) {
    group(groups_[run], block, a);
    const std::size_t c = run * vehicles_ + a.vehicle.index();
    DriveChain& chain = chains_[c];
    if (chain.units.empty()) continue;  // its states are no drive
    if (!is_within(chain, a.time_s)) {
      if (chain.stateless_count++ == 0) chain.stateless_line = a.line;
      ++chain.stateless[a.beacon.index()];
      continue;
    }
    const std::size_t u = unit_of_chain_[c] = unit_at(chain, a.time_s, unit_of_chain_[c]);
    DriveUnit& unit = chain.units[u];
    if (unit.arrivals++ == 0) unit.first_block = block;
    unit.last_block = block + 1;
    ++chain.arrivals;
    ++arrivals_;
  }
}

void DriveIndex::group(DriveGroups& of_run, std::size_t block, const Arrival& a) const {
  if (of_run.arrivals++ == 0) of_run.begin_s = a.time_s;
  const std::int64_t key = of_run.key_at(a.time_s);
  std::size_t& latest = of_run.latest[a.vehicle.index()];
  if (latest == SIZE_MAX || of_run.groups[latest].key != key) {
    latest = of_run.groups.size();
    of_run.groups.push_back({a.vehicle, key, a.time_s, a.time_s, 0, block, block});
    of_run.heard.resize(of_run.heard.size() + beacons_, 0);
  }
  DriveGroup& group = of_run.groups[latest];
  group.last_s = a.time_s;
  group.last_block = block + 1;
  ++group.arrivals;
  ++of_run.heard[latest * beacons_ + a.beacon.index()];
}

DrivePiece DriveIndex::widened(const DrivePiece& piece) const {
  const DriveChain& chain = chains_[piece.chain];
  DrivePiece wide = piece;
  if (piece.open_left) --wide.first_unit;
  if (piece.open_right) ++wide.last_unit;
  wide.open_left = wide.first_unit > 0;
  wide.open_right = wide.last_unit < chain.units.size();
  wide.nodes = wide.arrivals = 0;
  for (std::size_t u = wide.first_unit; u < wide.last_unit; ++u) {
    wide.nodes += chain.nodes_of(u) - (u == wide.first_unit ? 0 : 1);
    wide.arrivals += chain.units[u].arrivals;
  }
  return wide;
}

void DriveIndex::end(std::size_t piece_bytes) {
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const DriveChain& chain = chains_[c];
    if (chain.arrivals == 0 && chain.stateless_count == 0) continue;  // took no part
    nodes_ += chain.nodes;
    DrivePiece piece;
    piece.chain = c;
    std::size_t before = 0;
    for (std::size_t u = 0; u < chain.units.size(); ++u) {
      piece.nodes += u == piece.first_unit ? chain.nodes_of(u) : chain.nodes_of(u) - 1;
      piece.arrivals += chain.units[u].arrivals;
      piece.last_unit = u + 1;
      const std::size_t bytes =
          piece.nodes * kBytesOfStateInWork + piece.arrivals * kBytesOfDriveArrivalInWork;
      // The last piece does not consist of a few states only.
      const bool is_last = u + 1 == chain.units.size(), may_end = u + 2 < chain.units.size();
      if (!is_last && !(may_end && bytes >= piece_bytes)) continue;
      piece.open_left = piece.first_unit > 0;
      piece.open_right = !is_last;
      piece.arrivals_before = before;
      before += piece.arrivals;
      pieces_.push_back(piece);
      piece = {};
      piece.chain = c;
      piece.first_unit = u + 1;
    }
  }
}

Result<void> DriveIndex::read(const ArrivalSource& source, std::size_t run, const DriveGroup& group,
                              std::vector<Arrival>& arrivals) const {
  arrivals.clear();
  if (auto ok = source.read(run, group.first_block, group.last_block, arrivals); !ok) return ok;
  std::erase_if(arrivals, [&](const Arrival& a) {
    return a.vehicle != group.vehicle || groups_[run].key_at(a.time_s) != group.key;
  });
  return {};
}

Result<void> DriveIndex::read_arrivals(const ArrivalSource& source, const DrivePiece& piece,
                                       std::vector<Arrival>& arrivals) const {
  const DriveChain& chain = chains_[piece.chain];
  arrivals.clear();
  std::size_t first_block = SIZE_MAX, last_block = 0;
  for (std::size_t u = piece.first_unit; u < piece.last_unit; ++u) {
    if (chain.units[u].arrivals == 0) continue;
    first_block = std::min(first_block, chain.units[u].first_block);
    last_block = std::max(last_block, chain.units[u].last_block);
  }
  if (first_block >= last_block) return {};
  if (auto ok = source.read(chain.run, first_block, last_block, arrivals); !ok) return ok;
  const double from_s = chain.units[piece.first_unit].from_s, until_s = chain.end_of(piece.last_unit - 1);
  std::erase_if(arrivals, [&](const Arrival& a) {
    return a.vehicle != chain.vehicle || a.time_s < from_s || a.time_s > until_s ||
           (a.time_s == until_s && piece.open_right);
  });
  return {};
}

Result<std::size_t> DriveIndex::read(const ArrivalSource& source, const DrivePiece& piece,
                                     MeasurementLog& log) const {
  const DriveChain& chain = chains_[piece.chain];
  if (auto ok = read_arrivals(source, piece, log.arrivals); !ok) return fail(ok.error());
  log.odometry.clear();
  const std::vector<OdometryStep>& rows = source.log(chain.run).odometry;
  for (std::size_t row = chain.units[piece.first_unit].first_row;
       row < rows.size() && log.odometry.size() < piece.nodes; ++row)
    if (rows[row].vehicle == chain.vehicle) log.odometry.push_back(rows[row]);
  const double from_s = chain.units[piece.first_unit].from_s,
               until_s = piece.open_right ? chain.end_of(piece.last_unit - 1) : INFINITY;
  const auto first_from = [](const auto& list, double time_s) {
    return std::lower_bound(list.begin(), list.end(), time_s,
                            [](const auto& row, double then_s) { return row.time_s < then_s; });
  };
  const std::vector<TimedPose>& poses = source.log(chain.run).poses;
  log.poses.assign(first_from(poses, from_s), first_from(poses, until_s));
  const std::vector<Bearing>& bearings = source.log(chain.run).bearings;
  const auto first = first_from(bearings, from_s);
  log.bearings.assign(first, first_from(bearings, until_s));
  return static_cast<std::size_t>(first - bearings.begin());
}

std::vector<OdometryStep> DriveIndex::odometry_within(const ArrivalSource& source, std::size_t chain,
                                                      double from_s, double until_s) const {
  const DriveChain& c = chains_[chain];
  const std::vector<OdometryStep>& rows = source.log(c.run).odometry;
  const auto begins_later = [](double time_s, const DriveUnit& unit) { return time_s < unit.from_s; };
  auto unit = std::upper_bound(c.units.begin(), c.units.end(), from_s, begins_later);
  if (unit != c.units.begin()) --unit;
  std::vector<OdometryStep> within;
  for (std::size_t row = unit->first_row; row < rows.size(); ++row) {
    if (rows[row].vehicle != c.vehicle) continue;
    if (rows[row].time_s <= from_s) within.clear();
    within.push_back(rows[row]);
    if (rows[row].time_s >= until_s) break;
  }
  return within;
}

}  // namespace octant::calib

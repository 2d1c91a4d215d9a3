// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "models/ids.h"
#include "models/run.h"

namespace octant {

/// Rows without epochs belong to one pose if they were received no later than this after the first of them,
/// or were sent within this of it: one ping, at all receivers and from all beacons. A stream whose arrivals
/// follow each other faster than that is cut into such pieces.
inline constexpr double kSamePing_s = 5e-3;

[[nodiscard]] inline bool is_same_ping(const Bearing& first, const Bearing& row) {
  return row.time_s - first.time_s <= kSamePing_s;
}
[[nodiscard]] inline bool is_same_ping(const Arrival& first, const Arrival& row) {
  const double received_s = row.time_s - first.time_s, sent_s = received_s - (row.tof_s - first.tof_s);
  return received_s <= kSamePing_s || std::abs(sent_s) <= kSamePing_s;
}

/// Rows (arrivals, bearings) of one vehicle, pose by pose: an epoch, or a ping where there are no epochs.
template <class Row>
class RowsByPose {
 public:
  RowsByPose(const std::vector<Row>& all, VehicleId vehicle, bool has_epochs) {
    for (const Row& row : all) {
      if (row.vehicle != vehicle) continue;
      if (rows_.empty() || begins_pose(row, has_epochs)) first_.push_back(rows_.size());
      rows_.push_back(row);
    }
  }

  [[nodiscard]] std::size_t count() const { return first_.size(); }
  [[nodiscard]] std::span<const Row> pose(std::size_t i) const {
    const std::size_t end = i + 1 < first_.size() ? first_[i + 1] : rows_.size();
    return std::span<const Row>(rows_).subspan(first_[i], end - first_[i]);
  }

 private:
  [[nodiscard]] bool begins_pose(const Row& row, bool has_epochs) const {
    return has_epochs ? row.epoch != rows_.back().epoch : !is_same_ping(rows_[first_.back()], row);
  }

  std::vector<Row> rows_;
  std::vector<std::size_t> first_;
};

/// Instant of a pose that has the rows of an epoch: that of the middle one.
template <class Row>
[[nodiscard]] double middle_time_s(std::span<const Row> rows) {
  return rows[rows.size() / 2].time_s;
}

}  // namespace octant

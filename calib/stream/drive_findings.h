// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "calib/errors/statistics.h"
#include "calib/errors/whiteness.h"
#include "calib/problem/whole_log.h"
#include "calib/start/approach.h"
#include "calib/stream/drive_index.h"
#include "calib/stream/log_readings.h"

namespace octant::calib {

/// Gathers the findings of long drives piece by piece. Looked at one by one are evenly spread stretches, each
/// settled for itself (as error_sample does): what its neighbours told of its ends is no part of the sample.
class DriveFindings {
 public:
  /// All must outlive it.
  DriveFindings(const Problem& frame, const DriveIndex& index, const Estimate& estimate);

  /// A piece at the estimate; several threads may do so side by side.
  void take(std::size_t piece, const DriveWork& work);
  [[nodiscard]] LogFindings findings() &&;

 private:
  struct OfPiece {
    ObservationCounts counts;
    std::vector<PairSeries> series;
    std::vector<std::array<std::size_t, kRejections>> of_beacon;
    std::vector<Eigen::Vector2d> area_m;
    double coldest_degC = INFINITY, hottest_degC = -INFINITY;
    Trajectory some;                ///< the stretches looked at
    std::vector<Arrival> arrivals;  ///< of these
  };
  void take_stretches(const DriveWork& work, OfPiece& of) const;
  void add_stretches(OfPiece& of, Trajectory& to, std::vector<Arrival>& arrivals) const;

  const Problem& frame_;
  const DriveIndex& index_;
  const Estimate& estimate_;
  SharedState state_;
  std::size_t every_;
  std::vector<OfPiece> of_piece_;
};

}  // namespace octant::calib

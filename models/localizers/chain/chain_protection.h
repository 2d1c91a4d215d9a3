// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/fix.h"
#include "models/localizers/chain/chain_windows.h"

namespace octant {

/// Horizontal protection levels [m] along a drive that was smoothed, one for each instant: the drive is held
/// against what it would be without each of its beacons (solution separation, as separation.h has it for one
/// fix). With H_i and g_i the information and gradient of all states without the arrivals of beacon i,
///   shift = -H_i^-1 g_i
/// whatever those arrivals are off by, and for however long, the drive without them is not. Linear, from
/// where the drive was solved: shifts count up to some decimetres.
class DriveSeparation {
 public:
  /// @param instants  in order of nodes; they and what follows outlive this
  /// @param widened  by how much the calibration's part widens the variance at each instant: the drive
  /// without a beacon is widened too
  /// @param dof  of a pose
  DriveSeparation(std::span<const DriveInstant> instants, const std::vector<double>& widened, int dof)
      : instants_(instants),
        widened_(widened),
        dof_(dof),
        worst_m_(instants.size()),
        bounded_(instants.size(), 1) {}

  /// The drive without a beacon, to be solved before levels are asked for.
  [[nodiscard]] ChainVariant without(BeaconId beacon);

  /// 0 where the drive lies six sigmas off that without one of the beacons: that one, or those that were
  /// left, are at fault.
  /// @param variance_m2  horizontal, of the drive with all its beacons
  [[nodiscard]] double level_m(std::size_t instant, double variance_m2) const;

 private:
  std::span<const DriveInstant> instants_;
  const std::vector<double>& widened_;
  int dof_;
  std::vector<double> worst_m_;
  std::vector<char> bounded_;
};

}  // namespace octant

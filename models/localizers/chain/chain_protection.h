// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/fix.h"
#include "models/localizers/chain/chain_windows.h"

namespace octant {

/// Horizontal protection levels [m] along a smoothed drive, one for each instant. The drive is compared with
/// the drive without each of its beacons (solution separation, see separation.h for a single fix). With
/// information H_i and gradient g_i of all states without the arrivals of beacon i,
///   shift = -H_i^-1 g_i
/// The drive without these arrivals does not depend on their errors or on the duration of a fault. The shift
/// is linearised at the solution, which is valid up to some decimetres.
class DriveSeparation {
 public:
  /// All arguments must outlive this object.
  /// @param instants  in order of nodes
  /// @param widened  factor by which the calibration increases the variance at each instant; it also applies
  /// to the drive without a beacon
  /// @param dof  degrees of freedom of a pose
  DriveSeparation(std::span<const DriveInstant> instants, const std::vector<double>& widened, int dof)
      : instants_(instants),
        widened_(widened),
        dof_(dof),
        worst_m_(instants.size()),
        bounded_(instants.size(), 1) {}

  /// Problem of the drive without a beacon. Solve it before asking for levels.
  [[nodiscard]] ChainVariant without(BeaconId beacon);

  /// Returns 0 if the drive deviates by six sigmas from that without one of the beacons: either that beacon
  /// or the remaining ones are faulty.
  /// @param variance_m2  horizontal variance of the drive with all its beacons
  [[nodiscard]] double level_m(std::size_t instant, double variance_m2) const;

 private:
  std::span<const DriveInstant> instants_;
  const std::vector<double>& widened_;
  int dof_;
  std::vector<double> worst_m_;
  std::vector<char> bounded_;
};

}  // namespace octant

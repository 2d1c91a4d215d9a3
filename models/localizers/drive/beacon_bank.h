// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/drive/drive_filter.h"

namespace octant {

/// Filters of a drive without each of the received beacons: one additional filter for each beacon, which
/// never uses its arrivals (solution separation, see separation.h for a single fix). It does not depend on
/// the errors of that beacon's arrivals or on the duration of a fault. The protection level is therefore the
/// largest distance to one of these filters plus its own error. If a filter deviates by six sigmas, its
/// beacon is faulty: the filter takes over, and the beacon is excluded until kGoodInARow consecutive arrivals
/// agree again.
///
/// The kMostBeacons received last are followed, or fewer if the calibration that each filter carries is
/// large. If more are received at a time, there is no level. All memory is allocated at construction.
template <int kDof>
class BeaconBankOf {
 public:
  using Filter = DriveFilterOf<kDof>;
  static constexpr std::size_t kMostBeacons = 16, kMostColumns = 4096;
  static constexpr std::size_t kForgotten =
      1000;  ///< arrivals after which a beacon no longer counts as received
  static constexpr std::size_t kRecent =
      200;  ///< the last ones of this number of arrivals show which beacons are received now
  static constexpr int kGoodInARow = 10;

  /// @param wanted  false: no filters, no levels
  BeaconBankOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
               const CalibrationPart* calibration, bool wanted = true);

  /// Restarts with a pose that does not depend on the beacons.
  void start();
  /// Starts a filter with the information about the pose without a beacon.
  using StartWithout = std::function<void(BeaconId, Filter&)>;
  /// Restarts with a pose that was computed from these beacons.
  void start(const Filter& filter, const Trajectory& heard, const StartWithout& without);
  void set_range_uncertainty(double range_uncertainty_m);
  void set_echo_share(double share) {
    for (Slot& slot : slots_) slot.filter.set_echo_share(share);
  }
  /// Calls visit(filter) for each filter in use.
  template <class Visit>
  void for_each_filter(Visit&& visit) {
    for (Slot& slot : slots_)
      if (slot.beacon.valid()) visit(slot.filter);
  }
  /// Corrects the drive's filter by an arrival, and all other filters that may use it. Returns kUsed, or the
  /// reason for which the drive's filter rejected it.
  Rejection update(Filter& filter, const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Horizontal protection level. 0 if the drive is lost without one of the beacons, or if too few are
  /// received for a comparison (two in the plane, four in space). May replace the state of the drive's filter
  /// by that of another one, if a beacon is faulty and a further beacon is received.
  [[nodiscard]] double protection_level_m(Filter& filter);

 private:
  struct Slot {
    BeaconId beacon;
    Filter filter;
    std::size_t heard = 0;  ///< index of its last arrival
    int accused = 0;        ///< consecutive arrivals after which its filter deviated by six sigmas
  };
  Slot& slot_of(BeaconId beacon, const Filter& filter);
  void exclude(Slot& slot, Filter& filter);

  const EpochFixModel& model_;
  std::vector<Slot> slots_;
  std::vector<int> excluded_;  ///< for each beacon the number of arrivals that must still agree; 0: in use
  std::size_t heard_ = 0, too_many_until_ = 0;
};

using BeaconBank = BeaconBankOf<3>;
extern template class BeaconBankOf<3>;
extern template class BeaconBankOf<6>;

}  // namespace octant

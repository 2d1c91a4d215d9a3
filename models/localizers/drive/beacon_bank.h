// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/drive/drive_filter.h"

namespace octant {

/// What a drive's filter would hold without each of the beacons that it hears: a filter more a beacon, which
/// never took an arrival of it (solution separation, as separation.h has it for one fix). Whatever a beacon's
/// arrivals are off by, and for however long, the filter without them is not: so the protection level is the
/// largest distance to one of them with that one's own error. A filter that stands six sigmas off says that
/// its beacon is at fault: it takes over, and the beacon is left out until kGoodInARow of its arrivals in a
/// row fit again.
///
/// Followed are the kMostBeacons heard last, fewer where the calibration that each filter carries is large;
/// where more are heard at a time, there is no level. All memory is taken at construction.
template <int kDof>
class BeaconBankOf {
 public:
  using Filter = DriveFilterOf<kDof>;
  static constexpr std::size_t kMostBeacons = 16, kMostColumns = 4096;
  static constexpr std::size_t kForgotten =
      1000;                                    ///< arrivals after which a beacon no longer counts as heard
  static constexpr std::size_t kRecent = 200;  ///< of so many arrivals the last ones tell which are heard now
  static constexpr int kGoodInARow = 10;

  /// @param wanted  false: no filters, no levels
  BeaconBankOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
               const CalibrationPart* calibration, bool wanted = true);

  /// Begins anew, with a pose that owes nothing to the beacons.
  void start();
  /// Starts a filter with what is known of the pose without a beacon.
  using StartWithout = std::function<void(BeaconId, Filter&)>;
  /// Begins anew, with a pose that was found by these beacons.
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
  /// Corrects the drive's filter by an arrival, and all that may have it. Returns whether the drive's filter
  /// used it or why not.
  Rejection update(Filter& filter, const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Horizontal protection level; 0: without one of the beacons the drive is lost, or those heard now are too
  /// few to be held against each other (it takes two in the plane, four in space). May put another filter's
  /// state into the drive's, where a beacon is at fault and one more is heard.
  [[nodiscard]] double protection_level_m(Filter& filter);

 private:
  struct Slot {
    BeaconId beacon;
    Filter filter;
    std::size_t heard = 0;  ///< number of its last arrival
    int accused = 0;        ///< arrivals in a row after which its filter was six sigmas off
  };
  Slot& slot_of(BeaconId beacon, const Filter& filter);
  void exclude(Slot& slot, Filter& filter);

  const EpochFixModel& model_;
  std::vector<Slot> slots_;
  std::vector<int> excluded_;  ///< of each beacon: arrivals that are still to fit; 0: in use
  std::size_t heard_ = 0, too_many_until_ = 0;
};

using BeaconBank = BeaconBankOf<3>;
extern template class BeaconBankOf<3>;
extern template class BeaconBankOf<6>;

}  // namespace octant

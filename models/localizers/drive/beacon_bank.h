// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/drive/drive_filter.h"

namespace octant {

/// A beacon or a receiver.
struct DriveMember {
  BeaconId beacon;
  ReceiverId receiver;
  [[nodiscard]] bool valid() const { return beacon.valid() || receiver.valid(); }
  [[nodiscard]] bool has(const ArrivalObservation& a) const {
    return a.beacon == beacon || a.receiver == receiver;
  }
  bool operator==(const DriveMember&) const = default;
};

/// Filters of a drive without each of the received beacons, and without each receiver of at least three: one
/// additional filter for each member, which never uses its arrivals (solution separation, see separation.h
/// for a single fix). It does not depend on the errors of that member's arrivals or on the duration of a
/// fault. The protection level is therefore the largest distance to one of these filters plus its own error.
/// The filter that fits its arrivals best decides about its member: if its position or heading deviates by
/// six sigmas, the member is faulty. The filter takes over, and the member is excluded until kGoodInARow
/// consecutive arrivals agree again.
///
/// The kMostBeacons received last and kMostReceivers are followed, or fewer if the calibration that each
/// filter carries is large: first without the receivers, which then are not covered. If more beacons are
/// received at a time, there is no level. All memory is allocated at construction.
template <int kDof>
class BeaconBankOf {
 public:
  using Filter = DriveFilterOf<kDof>;
  static constexpr std::size_t kMostBeacons = 16, kMostReceivers = 8, kMostColumns = 8192;
  static constexpr std::size_t kForgotten =
      1000;  ///< arrivals after which a member no longer counts as received
  static constexpr std::size_t kRecent =
      200;  ///< the last ones of this number of arrivals show which members are received now
  static constexpr int kGoodInARow = 10;

  /// @param wanted  false: no filters, no levels
  BeaconBankOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
               const CalibrationPart* calibration, bool wanted = true);

  /// Restarts with a pose that does not depend on the members.
  void start();
  /// Starts a filter with the information about the pose without a member.
  using StartWithout = std::function<void(const DriveMember&, Filter&)>;
  /// Restarts with a pose that was computed from the members of these arrivals.
  void start(const Filter& filter, const Trajectory& heard, const StartWithout& without);
  void set_range_uncertainty(double range_uncertainty_m);
  void set_echo_share(double share) {
    for (Slot& slot : slots_) slot.filter.set_echo_share(share);
  }
  /// Calls visit(filter) for each filter in use.
  template <class Visit>
  void for_each_filter(Visit&& visit) {
    for (Slot& slot : slots_)
      if (slot.member.valid()) visit(slot.filter);
  }
  /// Corrects the drive's filter by an arrival, and all other filters that may use it. Returns kUsed, or the
  /// reason for which the drive's filter rejected it.
  Rejection update(Filter& filter, const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Horizontal protection level. 0 if the drive is lost without one of the members, or if too few beacons
  /// are received for a comparison (two in the plane, four in space). May replace the state of the drive's
  /// filter by that of another one, if a member is faulty and a further one of its kind is received.
  [[nodiscard]] double protection_level_m(Filter& filter);

 private:
  struct Slot {
    DriveMember member;
    Filter filter;
    std::size_t heard = 0;  ///< index of its last arrival
    int accused = 0;        ///< consecutive arrivals after which its filter deviated by six sigmas
  };
  void follow(const ArrivalObservation& arrival, const Filter& filter);
  void follow(const DriveMember& member, const Filter& filter);
  [[nodiscard]] int& left_out(const DriveMember& member);
  [[nodiscard]] bool is_excluded(const DriveMember& member, bool fits);
  [[nodiscard]] bool may_exclude(const DriveMember& member) const;
  [[nodiscard]] std::ptrdiff_t received(bool beacons) const;
  void exclude(Slot& slot, Filter& filter);

  const EpochFixModel& model_;
  std::vector<Slot> slots_;
  bool follows_receivers_ = false;
  std::vector<int> excluded_;  ///< for each beacon and receiver the arrivals that must still agree; 0: in use
  std::size_t heard_ = 0, too_many_until_ = 0;
};

using BeaconBank = BeaconBankOf<3>;
extern template class BeaconBankOf<3>;
extern template class BeaconBankOf<6>;

}  // namespace octant

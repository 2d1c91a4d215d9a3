// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/beacon_bank.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/common/protection.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

/// Difference between the shares of accepted arrivals that can be due to chance.
constexpr double kLessAccepted = 0.05;

/// A filter that followed an echo disagrees with the following arrivals; one without a faulty beacon does
/// not.
constexpr int kAccusedInARow = 10;

/// Without one of this number of beacons the pose is undetermined: in space it can rotate about the line
/// through the other two. With one more beacon a fault is detectable, but not identifiable.
template <int kDof>
constexpr std::ptrdiff_t kTooFewBeacons = kDof == 3 ? 1 : 3;
/// With three receivers a faulty one is identifiable.
constexpr std::size_t kLeastReceivers = 3;

template <class Filter>
double largest_turn_variance(const Filter& filter) {
  const int turns = pose_dof(Filter::kMotion) - first_turn(Filter::kMotion);
  return filter.covariance().diagonal().tail(turns).maxCoeff();
}

/// Difference of two filters in sigmas of the second one: of the position or of the rotation.
template <class Filter>
double separation_sigmas(const Filter& filter, const Filter& other) {
  const auto off = tangent_between(filter.pose(), other.pose(), Filter::kMotion);
  const int turns = pose_dof(Filter::kMotion) - first_turn(Filter::kMotion);
  const double off_m = (filter.pose().translation_m - other.pose().translation_m).template head<2>().norm();
  return std::max(off_m / std::sqrt(horizontal_variance(other.covariance())),
                  off.tail(turns).norm() / std::sqrt(largest_turn_variance(other)));
}

}  // namespace

template <int kDof>
BeaconBankOf<kDof>::BeaconBankOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                                 const CalibrationPart* calibration, bool wanted)
    : model_(model) {
  const std::size_t beacons = model.beacon_usable.size(), receivers = model.state.receiver_p_vehicle_m.size();
  excluded_.assign(beacons + receivers, 0);
  if (!wanted) return;
  const NodeCalibration room =
      Filter(model, gate_sigmas, range_uncertainty_m, calibration).node_calibration_room();
  const auto columns = static_cast<std::size_t>(room.by_parameter.cols() + room.by_pair.cols() + 1);
  const std::size_t most = kMostColumns / columns, followed = std::min(kMostBeacons, beacons);
  follows_receivers_ =
      receivers >= kLeastReceivers && receivers <= kMostReceivers && followed + receivers <= most;
  const std::size_t count = follows_receivers_ ? followed + receivers : std::min(followed, most);
  slots_.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    slots_.push_back({{}, Filter(model, gate_sigmas, range_uncertainty_m, calibration)});
}

template <int kDof>
void BeaconBankOf<kDof>::start() {
  for (Slot& slot : slots_) slot.member = {};
  std::ranges::fill(excluded_, 0);
  heard_ = too_many_until_ = 0;
}

template <int kDof>
void BeaconBankOf<kDof>::start(const Filter& filter, const Trajectory& heard, const StartWithout& without) {
  start();
  if (slots_.empty()) return;
  for (const ArrivalObservation& a : heard.arrivals)
    if (a.rejection == Rejection::kUsed) follow(a, filter);
  for (Slot& slot : slots_)
    if (slot.member.valid()) without(slot.member, slot.filter);
}

template <int kDof>
void BeaconBankOf<kDof>::set_range_uncertainty(double range_uncertainty_m) {
  for (Slot& slot : slots_) slot.filter.set_range_uncertainty(range_uncertainty_m);
}

/// Filters without the members of an arrival begin at the state before it, unless they exist.
template <int kDof>
void BeaconBankOf<kDof>::follow(const ArrivalObservation& a, const Filter& filter) {
  ++heard_;
  follow({a.beacon, {}}, filter);
  if (follows_receivers_) follow({{}, a.receiver}, filter);
}

template <int kDof>
void BeaconBankOf<kDof>::follow(const DriveMember& member, const Filter& filter) {
  Slot* longest_ago = &slots_.front();
  for (Slot& slot : slots_) {
    if (slot.member == member) {
      slot.heard = heard_;
      return;
    }
    if (!slot.member.valid()) slot.heard = 0;
    if (slot.heard < longest_ago->heard) longest_ago = &slot;
  }
  if (longest_ago->member.valid() && longest_ago->heard + kForgotten > heard_)
    too_many_until_ = heard_ + kForgotten;
  longest_ago->member = member;
  longest_ago->heard = heard_;
  longest_ago->accused = 0;
  longest_ago->filter.copy_state(filter);
}

template <int kDof>
int& BeaconBankOf<kDof>::left_out(const DriveMember& member) {
  return excluded_[member.beacon.valid() ? member.beacon.index()
                                         : model_.beacon_usable.size() + member.receiver.index()];
}

/// Counts an arrival of a member. @param fits  it agrees with the filter
template <int kDof>
bool BeaconBankOf<kDof>::is_excluded(const DriveMember& member, bool fits) {
  int& left = left_out(member);
  if (left == 0) return false;
  left = fits ? left - 1 : kGoodInARow;
  return true;
}

template <int kDof>
Rejection BeaconBankOf<kDof>::update(Filter& filter, const Trajectory& t, const ArrivalObservation& a) {
  if (slots_.empty() || !model_.beacon_usable[a.beacon.index()]) return filter.update(t, a);
  const DriveMember beacon{a.beacon, {}}, receiver{{}, a.receiver};
  if (left_out(beacon) > 0 || left_out(receiver) > 0) {
    const bool fits = filter.fits(t, a);
    static_cast<void>(is_excluded(beacon, fits));
    static_cast<void>(is_excluded(receiver, fits));
    return Rejection::kBeaconFault;
  }
  follow(a, filter);
  for (Slot& slot : slots_)
    if (slot.member.valid() && !slot.member.has(a)) static_cast<void>(slot.filter.update(t, a));
  return filter.update(t, a);
}

template <int kDof>
void BeaconBankOf<kDof>::exclude(Slot& slot, Filter& filter) {
  left_out(slot.member) = kGoodInARow;
  filter.copy_state(slot.filter);
  // All other filters used its arrivals. They restart at the state of the filter that never did, with an
  // error that depends on each of their members: at most their disagreement, and at most their own
  // uncertainty. Twice the sigma of both, because their errors are correlated.
  for (Slot& other : slots_) {
    if (!other.member.valid() || other.member == slot.member) continue;
    const typename Filter::Vector off = tangent_between(filter.pose(), other.filter.pose(), Filter::kMotion);
    other.filter.start_as(filter,
                          filter.covariance() + 4.0 * (other.filter.covariance() + off * off.transpose()));
  }
}

/// Number of beacons or receivers that are received now.
template <int kDof>
std::ptrdiff_t BeaconBankOf<kDof>::received(bool beacons) const {
  return std::ranges::count_if(slots_, [&](const Slot& slot) {
    return slot.member.valid() && slot.member.beacon.valid() == beacons && heard_ - slot.heard < kRecent;
  });
}

template <int kDof>
bool BeaconBankOf<kDof>::may_exclude(const DriveMember& member) const {
  return member.beacon.valid() ? received(true) > kTooFewBeacons<kDof> + 1
                               : received(false) >= static_cast<std::ptrdiff_t>(kLeastReceivers);
}

template <int kDof>
double BeaconBankOf<kDof>::protection_level_m(Filter& filter) {
  if (received(true) <= kTooFewBeacons<kDof>) return 0.0;
  double worst_m = 0.0;
  bool all_found = true;
  Slot* best = nullptr;
  for (Slot& slot : slots_) {
    if (!slot.member.valid()) continue;
    if (slot.filter.is_lost()) {
      all_found = false;
      continue;
    }
    if (!(largest_turn_variance(slot.filter) < square(kLinearTurn_rad))) {
      slot.member = {};
      too_many_until_ = heard_ + kForgotten;
      continue;
    }
    const double off_m =
        (filter.pose().translation_m - slot.filter.pose().translation_m).template head<2>().norm();
    worst_m =
        std::max(worst_m, off_m + kFaultySigmas * std::sqrt(horizontal_variance(slot.filter.covariance())));
    // A filter that rejects more arrivals than the drive's filter is lost itself and does not accuse a
    // member.
    const bool agrees = slot.filter.acceptance() > filter.acceptance() - kLessAccepted;
    slot.accused = agrees && separation_sigmas(filter, slot.filter) > kAtFaultSigmas ? slot.accused + 1 : 0;
    if (best == nullptr || slot.filter.misfit() < best->filter.misfit()) best = &slot;
  }
  // Filters without an innocent member deviate as well, but do not fit the arrivals better than all others.
  if (best != nullptr && best->accused >= kAccusedInARow && may_exclude(best->member)) exclude(*best, filter);
  // After an exclusion the level is that of the comparison, which includes the filter that takes over.
  return all_found && heard_ >= too_many_until_
             ? octant::protection_level_m(horizontal_variance(filter.covariance()), worst_m)
             : 0.0;
}

template class BeaconBankOf<3>;
template class BeaconBankOf<6>;

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/beacon_bank.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/common/protection.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

/// Attitude sigma above which a filter is not linear: its own error then appears as information, and further
/// arrivals increase its false confidence.
constexpr double kLeastKnownTurn_rad = 0.2;

/// Difference between the shares of accepted arrivals that can be due to chance.
constexpr double kLessAccepted = 0.05;

/// A filter that followed an echo disagrees with the following arrivals; one without a faulty beacon does
/// not.
constexpr int kAccusedInARow = 10;

/// Without one of this number of beacons the pose is undetermined: in space it can rotate about the line
/// through the other two. With one more beacon a fault is detectable, but not identifiable.
template <int kDof>
constexpr std::ptrdiff_t kTooFewBeacons = kDof == 3 ? 1 : 3;

template <class Filter>
bool is_linear(const Filter& filter) {
  const typename Filter::Covariance& P = filter.covariance();
  const int turns = pose_dof(Filter::kMotion) - first_turn(Filter::kMotion);
  return P.diagonal().tail(turns).maxCoeff() < square(kLeastKnownTurn_rad);
}

}  // namespace

template <int kDof>
BeaconBankOf<kDof>::BeaconBankOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                                 const CalibrationPart* calibration, bool wanted)
    : model_(model), excluded_(model.beacon_usable.size(), 0) {
  if (!wanted) return;
  const NodeCalibration room =
      Filter(model, gate_sigmas, range_uncertainty_m, calibration).node_calibration_room();
  const auto columns = static_cast<std::size_t>(room.by_parameter.cols() + room.by_pair.cols() + 1);
  const std::size_t count = std::min({kMostBeacons, model.beacon_usable.size(), kMostColumns / columns});
  slots_.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    slots_.push_back({BeaconId(), Filter(model, gate_sigmas, range_uncertainty_m, calibration)});
}

template <int kDof>
void BeaconBankOf<kDof>::start() {
  for (Slot& slot : slots_) slot.beacon = BeaconId();
  std::ranges::fill(excluded_, 0);
  heard_ = too_many_until_ = 0;
}

template <int kDof>
void BeaconBankOf<kDof>::start(const Filter& filter, const Trajectory& heard, const StartWithout& without) {
  start();
  if (slots_.empty()) return;
  for (const ArrivalObservation& a : heard.arrivals)
    if (a.rejection == Rejection::kUsed) static_cast<void>(slot_of(a.beacon, filter));
  for (Slot& slot : slots_)
    if (slot.beacon.valid()) without(slot.beacon, slot.filter);
}

template <int kDof>
void BeaconBankOf<kDof>::set_range_uncertainty(double range_uncertainty_m) {
  for (Slot& slot : slots_) slot.filter.set_range_uncertainty(range_uncertainty_m);
}

template <int kDof>
typename BeaconBankOf<kDof>::Slot& BeaconBankOf<kDof>::slot_of(BeaconId beacon, const Filter& filter) {
  ++heard_;
  Slot* longest_ago = &slots_.front();
  for (Slot& slot : slots_) {
    if (slot.beacon == beacon) {
      slot.heard = heard_;
      return slot;
    }
    if (!slot.beacon.valid()) slot.heard = 0;
    if (slot.heard < longest_ago->heard) longest_ago = &slot;
  }
  if (longest_ago->beacon.valid() && longest_ago->heard + kForgotten > heard_)
    too_many_until_ = heard_ + kForgotten;
  longest_ago->beacon = beacon;
  longest_ago->heard = heard_;
  longest_ago->accused = 0;
  longest_ago->filter.copy_state(filter);
  return *longest_ago;
}

template <int kDof>
Rejection BeaconBankOf<kDof>::update(Filter& filter, const Trajectory& t, const ArrivalObservation& a) {
  if (slots_.empty() || !model_.beacon_usable[a.beacon.index()]) return filter.update(t, a);
  int& left_out = excluded_[a.beacon.index()];
  if (left_out > 0) {
    const bool fits = filter.fits(t, a);
    left_out = fits ? left_out - 1 : kGoodInARow;
    return Rejection::kBeaconFault;
  }
  slot_of(a.beacon, filter);  // state before this arrival
  for (Slot& slot : slots_)
    if (slot.beacon.valid() && slot.beacon != a.beacon) static_cast<void>(slot.filter.update(t, a));
  return filter.update(t, a);
}

template <int kDof>
void BeaconBankOf<kDof>::exclude(Slot& slot, Filter& filter) {
  excluded_[slot.beacon.index()] = kGoodInARow;
  filter.copy_state(slot.filter);
  // All other filters used its arrivals. They restart at the state of the filter that never did, with an
  // error that depends on each of their beacons: at most their disagreement, and at most their own
  // uncertainty. Twice the sigma of both, because their errors are correlated.
  for (Slot& other : slots_) {
    if (!other.beacon.valid() || other.beacon == slot.beacon) continue;
    const typename Filter::Vector off = tangent_between(filter.pose(), other.filter.pose(), Filter::kMotion);
    other.filter.start_as(filter,
                          filter.covariance() + 4.0 * (other.filter.covariance() + off * off.transpose()));
  }
}

template <int kDof>
double BeaconBankOf<kDof>::protection_level_m(Filter& filter) {
  const auto heard = std::ranges::count_if(
      slots_, [this](const Slot& slot) { return slot.beacon.valid() && heard_ - slot.heard < kRecent; });
  if (heard <= kTooFewBeacons<kDof>) return 0.0;
  double worst_m = 0.0, worst_sigmas = kAtFaultSigmas;
  bool all_found = true;
  Slot* at_fault = nullptr;
  for (Slot& slot : slots_) {
    if (!slot.beacon.valid()) continue;
    if (slot.filter.is_lost()) {
      all_found = false;
      continue;
    }
    if (!is_linear(slot.filter)) {
      slot.beacon = BeaconId();
      too_many_until_ = heard_ + kForgotten;
      continue;
    }
    const double off_m =
        (filter.pose().translation_m - slot.filter.pose().translation_m).template head<2>().norm();
    const double sigma_m = std::sqrt(horizontal_variance(slot.filter.covariance()));
    worst_m = std::max(worst_m, off_m + kFaultySigmas * sigma_m);
    // A filter that rejects more arrivals than the drive's filter is lost itself and does not accuse a
    // beacon.
    const bool agrees = slot.filter.acceptance() > filter.acceptance() - kLessAccepted;
    slot.accused = agrees && off_m > kAtFaultSigmas * sigma_m ? slot.accused + 1 : 0;
    if (slot.accused >= kAccusedInARow && off_m > worst_sigmas * sigma_m) {
      worst_sigmas = off_m / sigma_m;
      at_fault = &slot;
    }
  }
  if (at_fault != nullptr && heard > kTooFewBeacons<kDof> + 1) exclude(*at_fault, filter);
  // After an exclusion the level is that of the comparison, which remains valid for the filter that takes
  // over, the one that deviates most.
  return all_found && heard_ >= too_many_until_
             ? octant::protection_level_m(horizontal_variance(filter.covariance()), worst_m)
             : 0.0;
}

template class BeaconBankOf<3>;
template class BeaconBankOf<6>;

}  // namespace octant

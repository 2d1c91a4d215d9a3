// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/range_gates.h"
#include "models/run.h"

namespace octant {

/// Distance between a beacon and a receiver in one epoch: mean of the agreeing arrivals between them.
struct PairRange {
  BeaconId beacon;
  ReceiverId receiver;
  double range_m = 0.0;     ///< slant range
  double sigma_m = 0.0;     ///< noise of the mean, including the bias of the pair
  double gain_mps = 0.0;    ///< derivative by the time of flight, see ArrivalRange
  double by_speed_s = 0.0;  ///< derivative by the speed
  int arrivals = 0;
};

struct PairRangesOptions {
  RangeGates gates{};  ///< rules 1 and 2 of Chang
  /// Largest spread of repeated times of a pair, in sigmas of one of them. The range of four normal variables
  /// is below 5.3 sigmas with a probability of 99.9 %.
  double spread_sigmas = 6.0;
};

/// Combines the arrivals of an epoch into one range for each pair of beacon and receiver: removes
/// undetermined beacons, applies gates, and averages repeated times without outliers. Ranges are ordered by
/// beacon, then by receiver.
class PairRanges {
 public:
  explicit PairRanges(const Deployment& deployment, PairRangesOptions options = {});

  /// Returns the ranges, valid until the next call. Overwrites `rejections`, one for each arrival: kUsed,
  /// kBeaconUnusable, kOutOfRange, kReflection, kOutvoted, or kNoPose (another vehicle than that of the first
  /// arrival). Does not allocate for up to kRoom arrivals of each pair, unless `rejections` has to grow.
  [[nodiscard]] std::span<PairRange> collect(std::span<const Arrival> arrivals, const Deployment& deployment,
                                             std::vector<Rejection>& rejections) noexcept;

  static constexpr std::size_t kRoom = 16;

 private:
  void reduce(std::span<const Arrival> arrivals, const Deployment& deployment,
              std::vector<Rejection>& rejections);
  void average(std::span<const Arrival> arrivals, std::vector<Rejection>& rejections, double pair_sigma_s,
               std::size_t slot);

  struct Slot {
    int first = -1, last = -1;  ///< linked list of the pair's arrivals, through next_
  };
  PairRangesOptions options_;
  std::size_t receivers_ = 0;
  std::vector<Slot> slots_;  ///< ordered by beacon, then by receiver
  std::vector<GatedArrival> gated_;
  std::vector<PairRange> single_;  ///< range of each arrival
  std::vector<int> next_;
  std::vector<double> values_;
  std::vector<PairRange> pairs_;
};

/// Rejects all arrivals of a pair that are still in use.
void reject_pair(std::span<const Arrival> arrivals, const PairRange& pair, Rejection reason,
                 std::span<Rejection> rejections);

/// Completes a fix: sets its status, counts used and rejected arrivals, and clears the rejections if there is
/// no fix.
void end_fix(FixStatus status, Fix& fix);

}  // namespace octant

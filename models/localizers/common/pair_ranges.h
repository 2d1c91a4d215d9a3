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

/// Distance between a beacon and a receiver in one epoch: the mean of what the arrivals between them say.
struct PairRange {
  BeaconId beacon;
  ReceiverId receiver;
  double range_m = 0.0;     ///< slant
  double sigma_m = 0.0;     ///< of the mean's noise, the pair's own bias included
  double gain_mps = 0.0;    ///< range per second, see ArrivalRange
  double by_speed_s = 0.0;  ///< range per m/s of speed
  int arrivals = 0;
};

struct PairRangesOptions {
  RangeGates gates{};  ///< Chang's two rules
  /// Widest spread of repeated times of a pair, in standard deviations of one. The range of four normal
  /// variables stays below 5.3 of them with 99.9 %.
  double spread_sigmas = 6.0;
};

/// Turns an epoch's arrivals into one range for each pair of beacon and receiver: undetermined beacons,
/// gates, mean of the repeated times without the odd ones out. Beacons in their order, and receivers in
/// theirs for each.
class PairRanges {
 public:
  explicit PairRanges(const Deployment& deployment, PairRangesOptions options = {});

  /// Overwrites `rejections`, one an arrival: kUsed, kBeaconUnusable, kOutOfRange, kReflection, kOutvoted,
  /// kNoPose (of another vehicle than the first arrival). What is returned lives until the next call.
  /// Allocates nothing while there are at most kRoom arrivals for each pair, unless `rejections` has to grow.
  [[nodiscard]] std::span<PairRange> collect(std::span<const Arrival> arrivals, const Deployment& deployment,
                                             std::vector<Rejection>& rejections) noexcept;

  static constexpr std::size_t kRoom = 16;

 private:
  void reduce(std::span<const Arrival> arrivals, const Deployment& deployment,
              std::vector<Rejection>& rejections);
  void average(std::span<const Arrival> arrivals, std::vector<Rejection>& rejections, double pair_sigma_s,
               std::size_t slot);

  struct Slot {
    int first = -1, last = -1;  ///< arrivals of the pair, a list through next_
  };
  PairRangesOptions options_;
  std::size_t receivers_ = 0;
  std::vector<Slot> slots_;  ///< beacon by beacon, receiver by receiver
  std::vector<GatedArrival> gated_;
  std::vector<PairRange> single_;  ///< of each arrival
  std::vector<int> next_;
  std::vector<double> values_;
  std::vector<PairRange> pairs_;
};

/// Marks the arrivals of a pair that are kUsed with a reason.
void reject_pair(std::span<const Arrival> arrivals, const PairRange& pair, Rejection reason,
                 std::span<Rejection> rejections);

/// Closes a fix: counts of used and rejected arrivals; no rejections where there is no fix.
void end_fix(FixStatus status, Fix& fix);

}  // namespace octant

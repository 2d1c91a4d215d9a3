// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/common/localizer.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/localizers/common/range_propagation.h"
#include "models/localizers/common/separation.h"
#include "models/localizers/rail/rail_path.h"

namespace octant {

struct RailOptions {
  PairRangesOptions ranges{};
  double gate_sigmas = 4.0;       ///< of a range against the others
  double ambiguity_margin = 9.0;  ///< of squared sigmas: a second place closer than this is as good
  double early_penalty =
      16.0;  ///< what an arrival that would be early costs more than a late one: echoes are late
  double rail_sigma_m = 1e-3;       ///< how far the vehicle sways off its rail, across
  double heading_sigma_rad = 1e-3;  ///< and in heading
  double end_slack_m = 0.5;         ///< a straight rail may be left by this much at its ends
  double max_speed_mps =
      1.0;  ///< how far the vehicle may be from where it was; SiteVehicle::motion goes before
  double max_sigma_m = 1.0;  ///< a larger sigma along the rail is poor geometry
};

/// Place of a vehicle on its rail, straight or arc (Chang, section 2; the range to a point of the arc as it
/// is, not the first-order step of eq. 7-14, which is off by 19 mm after stops 0.28 m apart). One unknown, so
/// one range is enough but for the sign: two places of a rail are equally far from a beacon. The other
/// receiver, the other beacons, the ends of the rail and the last position tell them apart; otherwise
/// kAmbiguous. All ranges that agree are adjusted together with their weights, so that one beacon hands over
/// to the next without a seam.
///
/// Where the vehicle was bounds where it is: a single beacon is not believed farther away than the vehicle
/// can have moved, which catches one that both receivers hear late alike; two beacons that agree are, so a
/// wrong place does not last.
///
/// Fix: kTooFewArrivals (no range, or a single one that no last position confirms), kNoConsensus (ranges that
/// no place explains, or none within reach; fewer than half agree), kPoorGeometry (abreast of the only
/// beacon), kAmbiguous. A fix of two beacons or more has a protection level (separation.h).
class RailLocalizer : public Localizer {
 public:
  explicit RailLocalizer(const Deployment& deployment, RailOptions options = {});
  /// Forgets where the vehicles were.
  void forget() noexcept;

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  struct Place {
    double s_m = 0.0;
    double sigma_m = 0.0;
    double cost = 0.0;  ///< sum of squares, those beyond the gate at the gate
    int agreeing = 0;
    int beacons = 0;  ///< that agree
  };
  struct Last {
    bool known = false;
    double time_s = 0.0;
    double s_m = 0.0;
  };
  struct Row {
    double off_m = 0.0;    ///< measured less predicted
    double by_s = 0.0;     ///< predicted by s
    double sigma_m = 0.0;  ///< for gates
  };
  [[nodiscard]] FixStatus fix_place(std::span<const Arrival> arrivals, Fix& fix);
  [[nodiscard]] Row row(const PairRange& pair, const RailPoint& at) const;
  [[nodiscard]] bool polish(std::span<const PairRange> pairs, Place& place) const;
  void rate(std::span<const PairRange> pairs, Place& place) const;
  void find_places(std::span<const PairRange> pairs);
  [[nodiscard]] FixStatus choose(std::span<const PairRange> pairs, const Fix& fix, Place& chosen);
  [[nodiscard]] bool in_reach(const Fix& fix, const Place& place) const;
  [[nodiscard]] FixStatus finish(std::span<const PairRange> pairs, std::span<const Arrival> arrivals,
                                 const Place& place, Fix& fix);
  [[nodiscard]] double protection_level(std::span<const PairRange> pairs, const RailPoint& at,
                                        const Eigen::Matrix3d& covariance);

  Deployment deployment_;
  RailOptions options_;
  PairRanges ranges_;
  RangePropagation propagation_;
  BeaconSums sums_;
  std::vector<Last> last_;  ///< of each vehicle
  std::vector<Place> places_;
  const Rail* rail_ = nullptr;  ///< of the vehicle of the call
};

/// Whether a deployment suits RailLocalizer: planar, synchronised clock, a usable beacon, a vehicle with a
/// rail and a receiver.
[[nodiscard]] Result<void> rail_fits(const Deployment& deployment);

}  // namespace octant

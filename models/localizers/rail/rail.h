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
  double gate_sigmas = 4.0;       ///< for a range against the others
  double ambiguity_margin = 9.0;  ///< in squared sigmas: a second position within this margin is as good
  double early_penalty =
      16.0;                    ///< additional cost of an arrival that would be early, because echoes are late
  double rail_sigma_m = 1e-3;  ///< lateral play of the vehicle on its rail
  double heading_sigma_rad = 1e-3;  ///< play of its heading
  double end_slack_m = 0.5;         ///< tolerance at the ends of a straight rail
  double max_speed_mps = 1.0;  ///< largest speed from the last position; SiteVehicle::motion overrides it
  double max_sigma_m = 1.0;    ///< sigmas along the rail above this are poor geometry
};

/// Position of a vehicle on a straight or circular rail (Chang, section 2). The range to a point of the arc
/// is used as it is, instead of the first-order step of eq. 7-14, which is wrong by 19 mm between stops 0.28
/// m apart. There is one unknown, so one range is enough except for the sign: two positions on a rail have
/// the same distance from a beacon. The other receiver, the other beacons, the ends of the rail and the last
/// position distinguish them; otherwise the fix is kAmbiguous. All ranges that agree are adjusted together
/// with their weights, so the position is continuous when one beacon replaces another.
///
/// The last position limits the new one. A single beacon is rejected if it implies a longer way than the
/// vehicle can have moved, which detects a beacon that both receivers observe equally late. Two beacons that
/// agree are accepted, so a wrong position does not persist.
///
/// Fix: kTooFewArrivals (no range, or a single one that no last position confirms), kNoConsensus (ranges that
/// no position explains, or none within reach; fewer than half agree), kPoorGeometry (abreast of the only
/// beacon), kAmbiguous. A fix of two or more beacons has a protection level (separation.h).
class RailLocalizer : public Localizer {
 public:
  explicit RailLocalizer(const Deployment& deployment, RailOptions options = {});
  /// Forgets the last positions of the vehicles.
  void forget() noexcept;

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  struct Place {
    double s_m = 0.0;
    double sigma_m = 0.0;
    double cost = 0.0;  ///< sum of squares, limited to the gate for each range
    int agreeing = 0;
    int beacons = 0;  ///< number that agree
  };
  struct Last {
    bool known = false;
    double time_s = 0.0;
    double s_m = 0.0;
  };
  struct Row {
    double off_m = 0.0;    ///< measured minus predicted
    double by_s = 0.0;     ///< derivative of the prediction by s
    double sigma_m = 0.0;  ///< sigma for gates
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
  std::vector<Last> last_;  ///< last position of each vehicle
  std::vector<Place> places_;
  const Rail* rail_ = nullptr;  ///< rail of the current vehicle
};

/// Checks that a deployment suits RailLocalizer: planar motion, synchronised clock, a usable beacon, and a
/// vehicle with a rail and a receiver.
[[nodiscard]] Result<void> rail_fits(const Deployment& deployment);

}  // namespace octant

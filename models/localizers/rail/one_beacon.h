// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/common/localizer.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/localizers/common/range_propagation.h"
#include "models/localizers/common/separation.h"

namespace octant {

/// Side of the beacons relative to the line from the first receiver to the second. Two ranges allow both
/// sides; Chang chooses "the solutions which include a positive y_br", the left, which the transducers face.
enum class Facing { kLeft, kRight, kEither };

/// Chang eq. 4: position of a beacon in the frame of a robot with receiver No. 1 at (-a, 0) and No. 2 at (a,
/// 0); left: y_br >= 0.
/// @param L1_m, L2_m  horizontal distances  @return no value if the circles do not meet or a is zero
[[nodiscard]] std::optional<Eigen::Vector2d> beacon_in_robot_frame(double a_m, double L1_m, double L2_m,
                                                                   bool left = true);

/// Chang eq. 5 and 6: position of the robot in the map, from the beacon's positions in both frames and the
/// robot's heading.
[[nodiscard]] Eigen::Vector2d robot_in_map(const Eigen::Vector2d& beacon_robot_m,
                                           const Eigen::Vector2d& beacon_map_m, double heading_rad);

struct OneBeaconOptions {
  /// Known heading, from a rail or odometry. Default: that of the vehicle's straight rail; otherwise it is
  /// estimated, which requires two beacons.
  std::optional<double> heading_rad{};
  double heading_sigma_rad = 2e-3;  ///< sigma of a known heading
  Facing facing = Facing::kLeft;
  PairRangesOptions ranges{};
  double gate_sigmas = 4.0;       ///< for circles that miss each other, and for beacons among each other
  double ambiguity_margin = 9.0;  ///< in squared sigmas: a second pose within this margin is as good
  double max_speed_mps = 1.0;     ///< largest speed from the last position; SiteVehicle::motion overrides it
  double max_sigma_m = 1.0;       ///< position sigmas above this are poor geometry
  double max_heading_sigma_rad = 0.5;
};

/// Position of a vehicle from one beacon and two receivers (C. Chang, Y. Li, J. M. Lee, "A TDOA-Based
/// Ultrasonic Absolute Localizing System of a Rail Robot in Greenhouse"). Eq. 1-3 are in arrival_range, the
/// two rules in range_gates, eq. 4-6 here, and the rail in rail.h.
///
/// Each beacon that both receivers observe gives a position (eq. 4-6). Receivers and beacons may have
/// different heights, which are known and corrected for. Several beacons are adjusted together, starting from
/// the first one's position; with two of them the heading need not be known. For a vehicle with more than two
/// receivers, the two that are farthest apart are used.
///
/// Fix: kTooFewArrivals (no beacon observed by both receivers, or one beacon without heading), kNoConsensus
/// (circles that do not meet, beacons that disagree), kPoorGeometry (a beacon in line with the receivers),
/// kAmbiguous (Facing::kEither, and no information about the side). A fix that would also exist with one
/// beacon less has a protection level (separation.h); an externally known heading is then assumed to be
/// correct.
class OneBeacon : public Localizer {
 public:
  explicit OneBeacon(const Deployment& deployment, OneBeaconOptions options = {});

  /// Sets the heading for the following calls, for a robot with odometry or a compass. @param sigma_rad
  /// positive
  void set_heading(double heading_rad, double sigma_rad) noexcept;
  /// Forgets the last positions of the vehicles.
  void forget() noexcept;

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  static constexpr std::size_t kMaxEither =
      4;  ///< number of beacons tried on both sides: sixteen combinations
  struct Receivers {
    std::array<ReceiverId, 2> id;
    std::optional<double> rail_heading_rad;
  };
  struct View {
    std::array<PairRange, 2> pair;
    std::array<Eigen::Vector2d, 2> place;  ///< in the vehicle frame: on the left, on the right
    double distance_m = 0.0;
  };
  struct Attempt {
    Eigen::Vector3d pose = Eigen::Vector3d::Zero();  ///< x, y, heading
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double cost = 0.0;  ///< sum of squares
    bool ok = false;
  };
  struct Last {
    bool known = false;
    double time_s = 0.0;
    Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  };
  [[nodiscard]] std::optional<double> known_heading_rad() const {
    return heading_rad_ ? heading_rad_ : now_.rail_heading_rad;
  }
  [[nodiscard]] FixStatus fix_pose(std::span<const Arrival> arrivals, Fix& fix);
  [[nodiscard]] FixStatus view_beacons(std::span<const Arrival> arrivals, std::span<const PairRange> pairs,
                                       Fix& fix);
  [[nodiscard]] std::optional<View> view(const PairRange& first, const PairRange& second, bool& flat) const;
  [[nodiscard]] Eigen::Vector3d start(unsigned sides, int left_out) const;
  [[nodiscard]] Attempt adjust(Eigen::Vector3d pose, int left_out) const;
  [[nodiscard]] FixStatus choose(const Fix& fix, int left_out, Attempt& best) const;
  [[nodiscard]] bool in_reach(const Fix& fix, int left_out, const Attempt& attempt) const;
  [[nodiscard]] FixStatus without_one(const Fix& fix, int& left_out, Attempt& best) const;
  [[nodiscard]] FixStatus finish(const Attempt& attempt, int left_out, std::span<const Arrival> arrivals,
                                 Fix& fix);
  [[nodiscard]] double gate(int left_out) const;
  void add_bend(const Eigen::Vector2d& p_map_m, Eigen::Matrix3d& covariance) const;
  [[nodiscard]] double protection_level(const Attempt& attempt, int left_out,
                                        const Eigen::Matrix3d& covariance);
  [[nodiscard]] double row(const View& view, std::size_t end, const Eigen::Vector3d& pose,
                           Eigen::Vector3d& by_pose) const;

  Deployment deployment_;
  OneBeaconOptions options_;
  std::vector<Receivers> receivers_;  ///< receivers of each vehicle
  std::vector<Last> last_;            ///< last fix of each vehicle
  PairRanges ranges_;
  RangePropagation propagation_;
  std::vector<View> views_;
  BeaconSums sums_;
  Receivers now_;  ///< receivers of the current vehicle
  std::optional<double> heading_rad_;
};

/// Checks that a deployment suits OneBeacon: planar motion, synchronised clock, a vehicle with two separate
/// receivers, and a usable beacon. Two beacons are required if neither the options nor a straight rail give
/// the heading.
[[nodiscard]] Result<void> one_beacon_fits(const Deployment& deployment,
                                           const OneBeaconOptions& options = {});

}  // namespace octant

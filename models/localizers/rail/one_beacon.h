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

/// Side of the line from the first receiver to the second on which the beacons are. Two ranges leave both;
/// Chang chooses "the solutions which include a positive y_br", the left, where the transducers look.
enum class Facing { kLeft, kRight, kEither };

/// Chang eq. 4: place of a beacon in the frame of a robot with receiver No. 1 at (-a, 0) and No. 2 at (a, 0);
/// left: y_br >= 0.
/// @param L1_m, L2_m  horizontal distances  @return nothing where the circles do not meet or a is zero
[[nodiscard]] std::optional<Eigen::Vector2d> beacon_in_robot_frame(double a_m, double L1_m, double L2_m,
                                                                   bool left = true);

/// Chang eq. 5 and 6: place of the robot in the map, from that of the beacon in both frames and the robot's
/// heading.
[[nodiscard]] Eigen::Vector2d robot_in_map(const Eigen::Vector2d& beacon_robot_m,
                                           const Eigen::Vector2d& beacon_map_m, double heading_rad);

struct OneBeaconOptions {
  /// Heading, where it is known: of a rail, from odometry. Not given: that of a straight rail of the vehicle;
  /// else it is solved for, which takes two beacons.
  std::optional<double> heading_rad{};
  double heading_sigma_rad = 2e-3;  ///< of a heading that is known
  Facing facing = Facing::kLeft;
  PairRangesOptions ranges{};
  double gate_sigmas = 4.0;       ///< of circles that miss each other, and of beacons against each other
  double ambiguity_margin = 9.0;  ///< of squared sigmas: a second pose closer than this is as good
  double max_speed_mps =
      1.0;  ///< how far the vehicle may be from where it was; SiteVehicle::motion goes before
  double max_sigma_m = 1.0;  ///< a larger position sigma is poor geometry
  double max_heading_sigma_rad = 0.5;
};

/// Position of a vehicle from one beacon and its two receivers (C. Chang, Y. Li, J. M. Lee, "A TDOA-Based
/// Ultrasonic Absolute Localizing System of a Rail Robot in Greenhouse"). Where the equations are: eq. 1-3
/// arrival_range, the two rules range_gates, eq. 4-6 here; of a rail: rail.h.
///
/// Each beacon that both receivers hear gives a place (eq. 4-6); receivers and beacons may be at different
/// heights, which the known heights take out. Several beacons are adjusted together, from the first one's
/// place, and with two of them the heading need not be known. A vehicle with more than two receivers uses the
/// two farthest apart.
///
/// Fix: kTooFewArrivals (no beacon is heard by both, or one without heading), kNoConsensus (circles that do
/// not meet, beacons that disagree), kPoorGeometry (a beacon in line with the receivers), kAmbiguous
/// (Facing::kEither, and nothing tells the side). A fix that one beacon less would leave one, too, has a
/// protection level (separation.h); a heading known from elsewhere is then taken for right.
class OneBeacon : public Localizer {
 public:
  explicit OneBeacon(const Deployment& deployment, OneBeaconOptions options = {});

  /// Heading from now on, for a robot that has it from odometry or a compass. @param sigma_rad positive
  void set_heading(double heading_rad, double sigma_rad) noexcept;
  /// Forgets where the vehicles were.
  void forget() noexcept;

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  static constexpr std::size_t kMaxEither =
      4;  ///< beacons that are tried on both sides: sixteen combinations
  struct Receivers {
    std::array<ReceiverId, 2> id;
    std::optional<double> rail_heading_rad;
  };
  struct View {
    std::array<PairRange, 2> pair;
    std::array<Eigen::Vector2d, 2> place;  ///< in the vehicle frame: left, right
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
  std::vector<Receivers> receivers_;  ///< of each vehicle
  std::vector<Last> last_;            ///< of each vehicle
  PairRanges ranges_;
  RangePropagation propagation_;
  std::vector<View> views_;
  BeaconSums sums_;
  Receivers now_;  ///< of the vehicle of the call
  std::optional<double> heading_rad_;
};

/// Whether a deployment suits OneBeacon: planar, synchronised clock, a vehicle with two receivers apart, a
/// usable beacon, and two of them where neither the options nor a straight rail tell the heading.
[[nodiscard]] Result<void> one_beacon_fits(const Deployment& deployment,
                                           const OneBeaconOptions& options = {});

}  // namespace octant

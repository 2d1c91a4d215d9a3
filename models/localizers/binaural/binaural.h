// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/common/range_propagation.h"
#include "models/support/result.h"

namespace octant {

/// How far off its axis a sonar serves (Shoval and Borenstein, sections 4 and 5, figure 13), horizontally. A
/// transmitter and a receiver pair that both look past each other lose the signal sooner than a pair of which
/// one looks straight.
struct BeamLimits {
  double limit_rad = 25.0 * std::numbers::pi / 180.0;  ///< either robot's sight of the other: figure 11
  double both_rad = 0.19739555984988078;  ///< both at once: atan(0.3 m / 1.5 m), 11.3 deg, figure 6
};

struct BinauralOptions {
  VehicleId vehicle{std::size_t{0}};                   ///< robot 1
  Eigen::Vector2d facing_map = Eigen::Vector2d(1, 0);  ///< where robot 2's sonars look, in the map
  /// Where robot 1's sonars look, in its frame. Not given: along its receivers' axes, or forward where they
  /// have none.
  std::optional<Eigen::Vector2d> facing_vehicle{};
  /// Robot 1 above where the deployment has it, and its tilt, as far as they are known (a bump, an
  /// inclinometer): R_level_vehicle = Ry(pitch) Rx(roll); positive pitch puts the nose down.
  double height_difference_m = 0.0;
  double pitch_rad = 0.0, roll_rad = 0.0;
  BeamLimits beam{};
  double consensus_sigmas =
      4.0;  ///< of the misclosure of the four ranges, beyond which one of them is no direct one
};

/// Intersection of the circles about two receivers in front of them: the point `p` with |p - p1| = r1, |p -
/// p2| = r2 on the side of `facing` (the one behind is invalid). Nothing where the circles do not meet or the
/// receivers coincide. (Shoval and Borenstein eq. 3-6, with the receivers as chord instead of an axis, so
/// that no direction of it is singular.)
[[nodiscard]] std::optional<Eigen::Vector2d> intersect_circles(const Eigen::Vector2d& p1_m, double r1_m,
                                                               const Eigen::Vector2d& p2_m, double r2_m,
                                                               const Eigen::Vector2d& facing) noexcept;

/// A range between points at heights that differ by height_m, in the plane: sqrt(range^2 - height^2); nothing
/// if shorter. Uncorrected, a range of 1.5 m is 21 mm too long at 0.25 m of height.
[[nodiscard]] std::optional<double> level_range_m(double range_m, double height_m) noexcept;

/// Which beacon and which receiver is what.
struct BinauralRoles {
  BeaconId transmitter2, left2, right2;    ///< robot 2
  ReceiverId transmitter1, left1, right1;  ///< robot 1
  Eigen::Vector2d facing1 = Eigen::Vector2d(1, 0);
};

/// Roles from the geometry: on each robot the two that stand farthest apart are the receivers, left and right
/// as seen along `facing`, and the third is the transmitter. Errors say what the deployment lacks.
[[nodiscard]] Result<BinauralRoles> binaural_roles(const Deployment& deployment,
                                                   const BinauralOptions& options = {});
[[nodiscard]] Result<void> binaural_fits(const Deployment& deployment);

/// Relative pose of two robots, each with a transmitter and two receivers (Shoval and Borenstein, "Measuring
/// the relative position and orientation between two mobile robots with binaural sonar"). The map is robot
/// 2's frame: its transmitter and both its receivers are the deployment's beacons; the vehicle is robot 1. An
/// arrival is between one of the beacons and one of the receivers, whichever end transmits; used are
/// (transmitter 2, left 1), (transmitter 2, right 1), (left 2, transmitter 1) and (right 2, transmitter 1).
/// Others are not needed; repeated ones are averaged.
///
/// Each pair of ranges fixes the other robot's transmitter (eq. 3-6), both together the orientation (eq.
/// 7-9). Four ranges for three unknowns: the adjusted pose is least squares, and the misclosure tells an
/// obstructed path (table I), though not which. No fix: kTooFewArrivals where one of the four is missing,
/// kPoorGeometry where circles do not meet or where the robots are beyond the beam (arrivals then rejected as
/// kOutOfRange), kNoConsensus where the ranges contradict each other.
class Binaural : public Localizer {
 public:
  /// Of a deployment that does not fit, every fix is kTooFewArrivals.
  explicit Binaural(const Deployment& deployment, const BinauralOptions& options = {});

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  /// One of the four ranges.
  struct Link {
    Eigen::Vector3d p_beacon_m, p_receiver_m;  ///< in the map; in robot 1's frame, levelled
    PairRange pair;                            ///< mean of the arrivals
  };
  struct PlanarPose {
    Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
    double heading_rad = 0.0;
  };

  void collect(const Observations& observations, Fix& fix) noexcept;
  [[nodiscard]] FixStatus closed_form(PlanarPose& pose) const noexcept;
  [[nodiscard]] bool within_beam(const PlanarPose& pose) const noexcept;
  [[nodiscard]] FixStatus adjust(PlanarPose& pose, Fix& fix) noexcept;

  Deployment deployment_;
  BinauralOptions options_;
  std::optional<BinauralRoles> roles_;
  std::array<Link, 4> links_;
  PropagationOf<4> range_errors_;
};

}  // namespace octant

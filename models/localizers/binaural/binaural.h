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

/// Limits of the horizontal angle off the axis within which a sonar works (Shoval and Borenstein, sections 4
/// and 5, figure 13). A transmitter and a receiver pair that are both turned away lose the signal sooner than
/// if one of them faces the other.
struct BeamLimits {
  double limit_rad = 25.0 * std::numbers::pi / 180.0;  ///< for each robot's view of the other: figure 11
  double both_rad = 0.19739555984988078;  ///< for both views at once: atan(0.3 m / 1.5 m), 11.3 deg, figure 6
};

struct BinauralOptions {
  VehicleId vehicle{std::size_t{0}};                   ///< robot 1
  Eigen::Vector2d facing_map = Eigen::Vector2d(1, 0);  ///< direction of robot 2's sonars in the map
  /// Direction of robot 1's sonars in its frame. Default: along its receivers' axes, or forward if they have
  /// none.
  std::optional<Eigen::Vector2d> facing_vehicle{};
  /// Height of robot 1 above that of the deployment, and its tilt, if known (a bump, an inclinometer):
  /// R_level_vehicle = Ry(pitch) Rx(roll). Positive pitch points the nose down.
  double height_difference_m = 0.0;
  double pitch_rad = 0.0, roll_rad = 0.0;
  BeamLimits beam{};
  double consensus_sigmas =
      4.0;  ///< misclosure of the four ranges, in sigmas, above which one of them is not direct
};

/// Intersection of the circles around two receivers: the point `p` with |p - p1| = r1, |p - p2| = r2 on the
/// side of `facing`; the one behind is invalid. No value if the circles do not meet or the receivers
/// coincide. (Shoval and Borenstein eq. 3-6, formulated with the chord between the receivers instead of an
/// axis, which has no singular direction.)
[[nodiscard]] std::optional<Eigen::Vector2d> intersect_circles(const Eigen::Vector2d& p1_m, double r1_m,
                                                               const Eigen::Vector2d& p2_m, double r2_m,
                                                               const Eigen::Vector2d& facing) noexcept;

/// Horizontal distance for a slant range and a height difference: sqrt(range^2 - height^2). No value if the
/// range is shorter than the height. Without this correction a range of 1.5 m is 21 mm too long at 0.25 m of
/// height.
[[nodiscard]] std::optional<double> level_range_m(double range_m, double height_m) noexcept;

/// Assignment of beacons and receivers to the sonars of both robots.
struct BinauralRoles {
  BeaconId transmitter2, left2, right2;    ///< robot 2
  ReceiverId transmitter1, left1, right1;  ///< robot 1
  Eigen::Vector2d facing1 = Eigen::Vector2d(1, 0);
};

/// Assigns the roles by geometry: on each robot the two transducers that are farthest apart are the
/// receivers, left and right as seen along `facing`, and the third is the transmitter. Errors state what the
/// deployment lacks.
[[nodiscard]] Result<BinauralRoles> binaural_roles(const Deployment& deployment,
                                                   const BinauralOptions& options = {});
[[nodiscard]] Result<void> binaural_fits(const Deployment& deployment);

/// Relative pose of two robots, each with a transmitter and two receivers (Shoval and Borenstein, "Measuring
/// the relative position and orientation between two mobile robots with binaural sonar"). The map is the
/// frame of robot 2, whose transmitter and receivers are the beacons of the deployment; the vehicle is
/// robot 1. An arrival connects a beacon and a receiver, whichever of them transmits. The method uses
/// (transmitter 2, left 1), (transmitter 2, right 1), (left 2, transmitter 1) and (right 2, transmitter 1).
/// Repeated arrivals are averaged, others ignored.
///
/// Each pair of ranges gives the position of the other robot's transmitter (eq. 3-6), both pairs the
/// orientation (eq. 7-9). With four ranges for three unknowns the pose is adjusted by least squares. The
/// misclosure reveals an obstructed path (table I), but not which one. There is no fix if one of the four
/// ranges is missing (kTooFewArrivals), if circles do not meet or the robots are outside the beams
/// (kPoorGeometry, arrivals rejected as kOutOfRange), or if the ranges contradict each other (kNoConsensus).
class Binaural : public Localizer {
 public:
  /// For an unsuitable deployment every fix is kTooFewArrivals.
  explicit Binaural(const Deployment& deployment, const BinauralOptions& options = {});

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  /// One of the four ranges.
  struct Link {
    Eigen::Vector3d p_beacon_m, p_receiver_m;  ///< in the map, and in robot 1's levelled frame
    PairRange pair;                            ///< mean of its arrivals
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

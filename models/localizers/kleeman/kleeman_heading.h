// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "models/physics/attenuation.h"

namespace octant {

// Orientation of the receiver array about the vertical, once the position is known (L. Kleeman, sections 5.1
// and 6).

/// What the heading is taken from.
enum class KleemanHeading {
  kMeanAxes,  ///< which receivers hear, to 45 degrees a beacon, averaged: as published
  kHearing,   ///< which receivers hear and which of them louder, as sectors that the beacons leave together
  kInterpolation,  ///< differences of arrival times and, where receivers are directional, of amplitudes
                   ///< across the array
};

/// A receiver of the array, in the vehicle frame.
struct ArrayReceiver {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector2d> axis;                  ///< horizontal direction of hearing, unit vector
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of hearing, unit vector; zero: all round alike
  double delay_s = 0.0;
  double variance_m2 = 0.0;  ///< of a distance through it, beside the noise: its place and its delay
};

/// One arrival as a distance.
struct HeardDistance {
  std::size_t arrival = 0;  ///< index into the arrivals given
  std::size_t beacon = 0;
  std::size_t receiver = 0;  ///< index into the vehicle's receivers
  double time_m =
      0.0;  ///< distance but for the time-walk, and longer than the true one by the cycle's unknown offset
  double slant_m = 0.0;  ///< time-walk taken out as well
  double sigma_m = 0.0;
  double centred_m = 0.0;      ///< slant_m as from the vehicle's centre
  bool walk_known = false;     ///< from a measured amplitude
  double log_amplitude = 0.0;  ///< ln(A / 1 V), where walk_known
  bool kept = true;            ///< agrees with the other arrivals of its beacon
};

/// What the heading is computed from: the arrivals kept, and where vehicle and beacons are.
struct HeadingInput {
  std::span<const HeardDistance> heard;
  std::span<const Eigen::Vector3d> beacon_p_map_m;
  std::span<const ArrayReceiver> receivers;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  const AttenuationModel* directional = nullptr;  ///< not owned; where it is, amplitudes tell of angles
  double log_amplitude_sigma = 0.0;
};

struct Heading {
  bool known = false;
  double rad = 0.0;
  double sigma_rad = 0.0;  ///< from the arrivals' noise, with the position held
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  ///< rad/m
};

/// Distance of a receiver from a beacon when the vehicle stands at p with a heading, and its derivatives.
struct ReceiverPath {
  double slant_m = 0.0;
  Eigen::RowVector2d by_position;  ///< no unit
  double by_heading = 0.0;         ///< m/rad
};
[[nodiscard]] ReceiverPath receiver_path(const Eigen::Vector3d& beacon_p_map_m, const ArrayReceiver& receiver,
                                         const Eigen::Vector2d& p_map_m, double heading_rad);

/// The same of what the receiver hears, ln(A / A_1m): spreading, absorption, and its directivity.
struct ReceiverGain {
  double log = 0.0;
  double log_directivity = 0.0;                                 ///< the last of the three
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  ///< 1/m
  double by_heading = 0.0;                                      ///< 1/rad
};
[[nodiscard]] ReceiverGain receiver_gain(const Eigen::Vector3d& beacon_p_map_m, const ArrayReceiver& receiver,
                                         const Eigen::Vector2d& p_map_m, double heading_rad,
                                         const AttenuationModel& model);

/// As published: each beacon is heard from the middle direction of the receivers that hear it, which the
/// array resolves to one receiver spacing (45 degrees); its bearing in the map less that is a heading, and
/// the mean over the beacons is the result. The rounding is uniform, so n beacons leave 45 / sqrt(12 n)
/// degrees: 5.3 with six. Unknown without axes.
[[nodiscard]] Heading heading_from_mean_axes(const HeadingInput& input);

/// All that hearing tells. A receiver that hears a beacon has its axis nearer to the beacon's bearing than
/// one that does not, however wide the angle is in which receivers alike hear at that distance. So the
/// bearing lies between two bisectors of axes, 22.5 degrees to either side of the mean axis, for two
/// receivers that hear as for three, and each beacon leaves a sector of headings. Where the sectors of most
/// beacons overlap is the heading: any there is as likely as another, so the result is the middle and sigma
/// the overlap's width / sqrt(12). A receiver whose arrival was left out may or may not hear and bounds
/// nothing. One that missed its pulse turns a sector by half a receiver spacing, as if one beacon in thirty
/// disagreed: headings with one beacon less count that much less, and keep sigma from what a sliver of
/// overlap would promise. Where the number that hears varies, sectors could be narrower if the angle were
/// known: sigma is on the safe side. Of two directional receivers that hear, the one that is louder by more
/// than noise is the nearer: half a sector, and no more need be known of the directivity than that it falls.
/// Unknown without axes, or where the beacons contradict each other.
[[nodiscard]] Heading heading_from_hearing(const HeadingInput& input);

/// Interpolated between receivers, as the paper proposes: least squares of the differences between the
/// arrivals of one beacon at several receivers, in time and, of directional receivers, in amplitude. The
/// means of a beacon's arrivals do not enter, so neither does the unknown offset, nor how loud the beacon is.
/// @param start  where it begins; not known: the best of 36 headings. Unknown where no beacon is heard by two
/// receivers.
[[nodiscard]] Heading heading_from_differences(const HeadingInput& input, const Heading& start);

}  // namespace octant

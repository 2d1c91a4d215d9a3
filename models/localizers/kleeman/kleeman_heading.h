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

// Orientation of the receiver array about the vertical, for a known position (L. Kleeman, sections 5.1 and
// 6).

/// Information that the heading is computed from.
enum class KleemanHeading {
  kMeanAxes,  ///< reception by each receiver, with a resolution of 45 degrees for each beacon, averaged as
              ///< published
  kHearing,   ///< reception and relative loudness, as the intersection of the sectors that the beacons allow
  kInterpolation,  ///< differences between arrival times, and between amplitudes of directional receivers,
                   ///< across the array
};

/// A receiver of the array, in the vehicle frame.
struct ArrayReceiver {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector2d> axis;                  ///< horizontal axis, unit vector
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< axis, unit vector; zero: omnidirectional
  double delay_s = 0.0;
  double variance_m2 = 0.0;  ///< variance of a distance due to the receiver's position and delay
};

/// An arrival as a distance.
struct HeardDistance {
  std::size_t arrival = 0;  ///< index into the arrivals
  std::size_t beacon = 0;
  std::size_t receiver = 0;  ///< index into the receivers of the vehicle
  double time_m = 0.0;       ///< distance including the time-walk and the unknown cycle offset
  double slant_m = 0.0;      ///< distance without the time-walk
  double sigma_m = 0.0;
  double centred_m = 0.0;      ///< slant_m reduced to the vehicle's centre
  bool walk_known = false;     ///< true if the walk follows from a measured amplitude
  double log_amplitude = 0.0;  ///< ln(A / 1 V), if walk_known
  bool kept = true;            ///< true if it agrees with the other arrivals of its beacon
};

/// Inputs of the heading: the arrivals that agree, and the positions of vehicle and beacons.
struct HeadingInput {
  std::span<const HeardDistance> heard;
  std::span<const Eigen::Vector3d> beacon_p_map_m;
  std::span<const ArrayReceiver> receivers;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  const AttenuationModel* directional =
      nullptr;  ///< not owned; if given, amplitudes contribute to the heading
  double log_amplitude_sigma = 0.0;
};

struct Heading {
  bool known = false;
  double rad = 0.0;
  double sigma_rad = 0.0;  ///< due to the noise of the arrivals, for a fixed position
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  ///< rad/m
};

/// Distance of a receiver from a beacon, for a vehicle at position p with a heading, and its derivatives.
struct ReceiverPath {
  double slant_m = 0.0;
  Eigen::RowVector2d by_position;  ///< no unit
  double by_heading = 0.0;         ///< m/rad
};
[[nodiscard]] ReceiverPath receiver_path(const Eigen::Vector3d& beacon_p_map_m, const ArrayReceiver& receiver,
                                         const Eigen::Vector2d& p_map_m, double heading_rad);

/// Received log amplitude, ln(A / A_1m), with its derivatives: spreading, absorption and directivity.
struct ReceiverGain {
  double log = 0.0;
  double log_directivity = 0.0;                                 ///< the directivity alone
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  ///< 1/m
  double by_heading = 0.0;                                      ///< 1/rad
};
[[nodiscard]] ReceiverGain receiver_gain(const Eigen::Vector3d& beacon_p_map_m, const ArrayReceiver& receiver,
                                         const Eigen::Vector2d& p_map_m, double heading_rad,
                                         const AttenuationModel& model);

/// Heading as published. The direction of a beacon is the mean axis of the receivers that observe it, with a
/// resolution of one receiver spacing (45 degrees). Its difference from the beacon's bearing in the map is a
/// heading, and the result is the mean over the beacons. The rounding error is uniform, so with n beacons
/// sigma is 45 / sqrt(12 n) degrees: 5.3 for six. Unknown without axes.
[[nodiscard]] Heading heading_from_mean_axes(const HeadingInput& input);

/// Heading from the set of receivers that observe each beacon. A receiver that observes a beacon has its axis
/// closer to the bearing of the beacon than one that does not, whatever the beam width at that distance. The
/// bearing therefore lies between two bisectors of axes, 22.5 degrees to either side of the mean axis, and
/// each beacon allows a sector of headings.
///
/// The heading is the middle of the interval in which the sectors of most beacons overlap. All headings there
/// are equally likely, so sigma is the width of the overlap over sqrt(12). A receiver whose arrival was
/// rejected gives no bound. A missed pulse turns a sector by half a receiver spacing, as if one beacon in
/// thirty disagreed. Headings with one beacon less are weighted accordingly, so that a small overlap does not
/// give an optimistic sigma. Sectors could be narrower if the beam width were known, so sigma is
/// conservative.
///
/// Among two directional receivers, the one that is louder by more than noise is closer to the bearing, which
/// halves the sector. This requires only that the directivity decreases with the angle. Unknown without axes,
/// or if the beacons contradict each other.
[[nodiscard]] Heading heading_from_hearing(const HeadingInput& input);

/// Heading by interpolation between receivers, as the paper proposes: least squares on the differences
/// between the arrivals of one beacon at several receivers, in time and, for directional receivers, in
/// amplitude. The mean of a beacon's arrivals is eliminated, and with it the unknown offset and the loudness
/// of the beacon.
/// @param start  initial heading; if unknown, the best of 36 headings. The result is unknown if no beacon is
/// observed by two receivers.
[[nodiscard]] Heading heading_from_differences(const HeadingInput& input, const Heading& start);

}  // namespace octant

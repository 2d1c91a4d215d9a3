// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/export/earth.h"
#include "models/fix.h"

namespace octant::io {

/// VISION_POSITION_ESTIMATE (102), ODOMETRY (331) or GPS_INPUT (232), which needs the origin's position.
enum class MavlinkMessage { kVision, kOdometry, kGps };

/// CRC-16/MCRF4XX of the bytes, continued from `crc`. "123456789" gives 0x6F91.
[[nodiscard]] std::uint16_t mavlink_crc(std::string_view bytes, std::uint16_t crc = 0xFFFF);

/// Writes fixes as MAVLink 2 frames. MAVLink's local frame has x north, y east and z down, and its body frame
/// x forward, y right and z down. Octant's map has z up, and its vehicle x forward, y left and z up. With the
/// direction n of north in the map (counter-clockwise from +x):
///   x_ned = x cos n + y sin n,  y_ned = x sin n - y cos n,  z_ned = -z,  yaw = n - heading.
/// By default n is 90 degrees: the map's y is north and its x is east. Covariances have the order x, y, z,
/// roll, pitch, yaw. An angle with a variance of at least kUnknownRotationVariance is NaN, as are its
/// covariances. In the plane, z, roll and pitch are zero with variance zero.
///
/// The reset counter of a vehicle increases at its first pose after an epoch without one, after its clock was
/// set back, and after lose_track(). The system id is 1 for the first vehicle, 2 for the second and so on;
/// the component is MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY.
class MavlinkWriter {
 public:
  /// @param north_known  ODOMETRY is in MAV_FRAME_LOCAL_NED if true, in MAV_FRAME_LOCAL_FRD if false
  MavlinkWriter(MavlinkMessage message, const EarthOrigin& origin, bool north_known)
      : message_(message), origin_(origin), north_known_(north_known) {}

  /// Frame of a fix, empty without a pose.
  [[nodiscard]] std::string frame(const Fix& fix);
  /// The next poses may jump, as after a change of the deployment.
  void lose_track();

 private:
  struct Track {
    bool seen = false, lost = false;
    double time_s = 0.0;
    std::uint8_t resets = 0;
  };
  std::uint8_t count_resets(const Fix& fix);

  MavlinkMessage message_;
  EarthOrigin origin_;
  bool north_known_;
  std::uint8_t sequence_ = 0;
  std::vector<Track> tracks_;  ///< by vehicle
};

}  // namespace octant::io

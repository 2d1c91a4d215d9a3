// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/export/earth.h"
#include "models/fix.h"
#include "models/site.h"
#include "models/watch/watch.h"

namespace octant::io {

// Lines for a listener, with their ends.

/// {"type": "fix", "time_s": ..., "vehicle": ..., "status": "ok", "x_m": ..., ...}: the columns of fixes.csv,
/// the quaternion and the covariance. Pose and velocity are left out if they are unknown.
[[nodiscard]] std::string fix_as_json(const Fix& fix, const NameTable& names);
/// nav_msgs/Odometry as JSON: frame `map`, child `base_link` (REP-105; with several vehicles NAME/base_link),
/// the pose's covariance row by row, and the twist of the child frame. If the velocity is unknown, the
/// covariance of the twist begins with -1. Empty without a pose.
[[nodiscard]] std::string fix_as_ros(const Fix& fix, const NameTable& names);
/// GGA, GST, HDT if the heading is known and VTG if the velocity is, as a GPS receiver sends them; a GGA of
/// quality 0 without a pose. The time of day is that of time_s as seconds since 1970 (or since midnight). The
/// map is the plane that touches WGS 84 at the origin.
[[nodiscard]] std::string fix_as_nmea(const Fix& fix, const EarthOrigin& origin);
/// {"type": "alarm", "kind": "beacon_moved", "beacon": ..., "size_m": ..., ...}
[[nodiscard]] std::string alarm_as_json(const WatchAlarm& alarm, const NameTable& names);
/// A proprietary sentence: $POCT,ALARM,kind,subject,size*hh
[[nodiscard]] std::string alarm_as_nmea(const WatchAlarm& alarm, const NameTable& names);

}  // namespace octant::io

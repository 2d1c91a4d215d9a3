// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the messages of ROS 2 that Octant reads and writes (common_interfaces, geometry2).

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/physics/pose.h"

namespace octant::io {

/// sensor_msgs/msg/Range.
struct RosRange {
  double stamp_s = 0.0;
  std::string frame;
  double range_m = 0.0;  ///< no measurement: not finite, or outside the range of the sensor
  bool measured = false;
};
[[nodiscard]] std::optional<RosRange> range_of(std::string_view message);

/// Pose of one frame in another.
struct RosPose {
  double stamp_s = 0.0;
  std::string frame, child;
  Pose T_frame_child;  ///< the quaternion normalised
};
/// geometry_msgs/msg/PoseStamped, PoseWithCovarianceStamped, nav_msgs/msg/Odometry (one pose) and
/// tf2_msgs/msg/TFMessage (several). Returns no value if the message does not end with its fields, has
/// numbers that are not finite, or a quaternion of zero length.
[[nodiscard]] std::optional<std::vector<RosPose>> poses_of(std::string_view type, std::string_view message);
/// Returns true if poses_of() supports the type.
[[nodiscard]] bool is_pose_type(std::string_view type);
inline constexpr std::string_view kRosRange = "sensor_msgs/msg/Range",
                                  kRosPose = "geometry_msgs/msg/PoseStamped",
                                  kRosPoseWithCovariance = "geometry_msgs/msg/PoseWithCovarianceStamped",
                                  kRosOdometry = "nav_msgs/msg/Odometry",
                                  kRosTransforms = "tf2_msgs/msg/TFMessage";

/// Messages that are written.
/// @param covariance  row by row: x, y, z, rotations about the frame's axes
[[nodiscard]] std::string ros_pose(std::int64_t stamp_ns, std::string_view frame, const Pose& T);
[[nodiscard]] std::string ros_pose_with_covariance(std::int64_t stamp_ns, std::string_view frame,
                                                   const Pose& T, const PoseCovariance& covariance);
[[nodiscard]] std::string ros_odometry(std::int64_t stamp_ns, std::string_view frame, std::string_view child,
                                       const Pose& T);
/// Definition of a type that is written, in the form of `ros2msg` schemas: with the definitions of all types
/// that it uses.
[[nodiscard]] std::string ros_definition(std::string_view type);

/// Conversion to the nearest whole nanosecond, and back; exact for times with at most nine decimals.
[[nodiscard]] std::int64_t nanoseconds_of(double time_s);
[[nodiscard]] double seconds_of(std::int64_t time_ns);

}  // namespace octant::io

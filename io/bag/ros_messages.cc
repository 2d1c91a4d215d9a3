// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/ros_messages.h"

#include <cmath>

#include "io/bag/cdr.h"
#include "models/physics/unit_rotation.h"

namespace octant::io {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

double stamp_of(CdrReader& in) {
  const auto s = in.value<std::int32_t>();
  const auto ns = in.value<std::uint32_t>();
  return seconds_of(s * kSecond_ns + ns);
}

/// Seven numbers: position, quaternion x y z w.
bool read_pose_of(CdrReader& in, Pose& T) {
  double v[7];
  bool finite = true;
  for (double& number : v) {
    number = in.value<double>();
    finite = finite && std::isfinite(number);
  }
  const auto q = unit_rotation(v[3], v[4], v[5], v[6]);
  if (!in.ok() || !finite || !q) return false;
  T = Pose{{v[0], v[1], v[2]}, *q};
  return true;
}

bool read_stamped(CdrReader& in, RosPose& out, bool has_child) {
  out.stamp_s = stamp_of(in);
  out.frame = in.text();
  if (has_child) out.child = in.text();
  return in.ok() && read_pose_of(in, out.T_frame_child);
}

void write_header(CdrWriter& out, std::int64_t stamp_ns, std::string_view frame) {
  const std::int64_t s = stamp_ns >= 0 ? stamp_ns / kSecond_ns : (stamp_ns - kSecond_ns + 1) / kSecond_ns;
  out.value(static_cast<std::int32_t>(s));
  out.value(static_cast<std::uint32_t>(stamp_ns - s * kSecond_ns));
  out.text(frame);
}

void write_pose(CdrWriter& out, const Pose& T) {
  for (int i = 0; i < 3; ++i) out.value(T.translation_m[i]);
  for (const double q : {T.rotation.x(), T.rotation.y(), T.rotation.z(), T.rotation.w()}) out.value(q);
}

constexpr const char* kRule =
    "================================================================================\nMSG: ";

std::string pose_parts() {
  const std::string rule = kRule;
  return rule + "geometry_msgs/Pose\nPoint position\nQuaternion orientation\n" + rule +
         "geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" + rule +
         "geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" + rule +
         "std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + rule +
         "builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
}

}  // namespace

std::optional<RosRange> range_of(std::string_view message) {
  CdrReader in(message);
  RosRange out;
  out.stamp_s = stamp_of(in);
  out.frame = in.text();
  (void)in.value<std::uint8_t>();  // ultrasound or infrared
  (void)in.value<float>();         // field of view
  const double least = in.value<float>(), most = in.value<float>();
  out.range_m = in.value<float>();
  if (!in.ok()) return std::nullopt;
  // Drivers without known limits write zero for both.
  out.measured = std::isfinite(out.range_m) && out.range_m > 0.0 &&
                 (!(most > least) || (out.range_m >= least && out.range_m <= most));
  return out;
}

bool is_pose_type(std::string_view type) {
  return type == kRosPose || type == kRosPoseWithCovariance || type == kRosOdometry || type == kRosTransforms;
}

std::optional<std::vector<RosPose>> poses_of(std::string_view type, std::string_view message) {
  CdrReader in(message);
  constexpr std::size_t kLeastTransform = 4 + 4 + 5 + 5 + 7 * 8;
  const std::uint32_t count = type == kRosTransforms ? in.count(kLeastTransform) : 1;
  std::vector<RosPose> out;
  for (std::uint32_t i = 0; i < count && in.ok(); ++i)
    if (!read_stamped(in, out.emplace_back(), type == kRosTransforms || type == kRosOdometry))
      return std::nullopt;
  if (!in.ok()) return std::nullopt;
  return out;
}

std::string ros_pose(std::int64_t stamp_ns, std::string_view frame, const Pose& T) {
  CdrWriter out;
  write_header(out, stamp_ns, frame);
  write_pose(out, T);
  return out.message();
}

std::string ros_pose_with_covariance(std::int64_t stamp_ns, std::string_view frame, const Pose& T,
                                     const PoseCovariance& covariance) {
  CdrWriter out;
  write_header(out, stamp_ns, frame);
  write_pose(out, T);
  const auto C = covariance_in_map(covariance, T);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) out.value(C(i, j));
  return out.message();
}

std::string ros_odometry(std::int64_t stamp_ns, std::string_view frame, std::string_view child,
                         const Pose& T) {
  CdrWriter out;
  write_header(out, stamp_ns, frame);
  out.text(child);
  write_pose(out, T);
  for (int i = 0; i < 36 + 6 + 36; ++i) out.value(0.0);  // covariance; twist and its covariance: not known
  return out.message();
}

std::string ros_definition(std::string_view type) {
  const std::string rule = kRule, parts = pose_parts();
  const std::string with_covariance =
      rule + "geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n";
  if (type == kRosPose) return "std_msgs/Header header\nPose pose\n" + parts;
  if (type == kRosPoseWithCovariance)
    return "std_msgs/Header header\nPoseWithCovariance pose\n" + with_covariance + parts;
  return "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
         "geometry_msgs/TwistWithCovariance twist\n" +
         with_covariance + parts + rule +
         "geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n" + rule +
         "geometry_msgs/Twist\nVector3 linear\nVector3 angular\n" + rule +
         "geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
}

std::int64_t nanoseconds_of(double time_s) {
  const double whole = std::floor(time_s);
  return static_cast<std::int64_t>(whole) * kSecond_ns + std::llround((time_s - whole) * 1e9);
}

double seconds_of(std::int64_t time_ns) {
  // Whole seconds are converted separately, because not every machine has a longer double.
  const std::int64_t whole = time_ns / kSecond_ns;
  return static_cast<double>(whole) + static_cast<double>(time_ns - whole * kSecond_ns) / 1e9;
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_readings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "calib/problem/log_health.h"
#include "calib/problem/site_units.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {
namespace {

bool is_posed(const MeasurementLog& run) { return !run.poses.empty(); }

std::string file_of_poses(const std::vector<MeasurementLog>& runs) {
  const auto posed = std::ranges::find_if(runs, is_posed);
  return posed == runs.end() ? "poses.tum" : posed->path + "/" + pose_file(*posed);
}

/// Reflects a pose at a plane of the map through the z axis with normal (nx, ny): M T M' with M also for the
/// vehicle's y axis.
Pose reflected(const Pose& pose, double nx, double ny) {
  const Eigen::Vector3d n(nx, ny, 0.0);
  const Eigen::Matrix3d map = Eigen::Matrix3d::Identity() - 2.0 * n * n.transpose();
  const Eigen::Matrix3d vehicle = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
  Pose out;
  out.translation_m = map * pose.translation_m;
  out.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(map * pose.rotation.toRotationMatrix() * vehicle)).normalized();
  return out;
}

/// A left-handed frame of poses: an axis of the map, and with it the sense of rotation, is reversed.
struct Reflection {
  const char* words;
  Pose (*read)(const Pose&);  ///< the pose in the right-handed frame
};
const Reflection kReflections[] = {
    {"y and the heading have the wrong sign", [](const Pose& p) { return reflected(p, 0.0, 1.0); }},
    {"x and the sense of the heading are the wrong way round",
     [](const Pose& p) { return reflected(p, 1.0, 0.0); }},
    {"x and y are exchanged, as north and east",
     [](const Pose& p) { return reflected(p, std::sqrt(0.5), -std::sqrt(0.5)); }},
    {"headings count clockwise",
     [](const Pose& p) {
       return Pose{p.translation_m, p.rotation.conjugate()};
     }},
    {"they are north, east, down: x and y are exchanged and z counts downwards",
     [](const Pose& p) {
       Pose out = reflected(p, std::sqrt(0.5), -std::sqrt(0.5));
       out.translation_m.z() = -out.translation_m.z();
       return out;
     }},
};

/// Calls visit(time_s) for some evenly spread arrivals.
/// @return share of them for which it is true
template <class Visit>
double share_of_arrivals(const MeasurementLog& run, Visit&& visit) {
  constexpr std::size_t kArrivals = 500;
  const std::size_t n = run.arrivals.size(), stride = n / kArrivals + 1;
  std::size_t seen = 0, count = 0;
  for (std::size_t i = 0; i < n; i += stride, ++seen) count += visit(run.arrivals[i].time_s) ? 1 : 0;
  return seen > 0 ? static_cast<double>(count) / static_cast<double>(seen) : 0.0;
}

std::optional<Pose> measured_pose_at(const MeasurementLog& run, double time_s) {
  Pose pose;
  return interpolate_poses(run.poses, time_s, run.pose_accuracy.max_gap_s, pose) ? std::optional(pose)
                                                                                 : std::nullopt;
}

/// Returns true if the vehicle moves at enough of the arrivals, by its measured poses, so that the clock of
/// the poses matters.
bool are_poses_of_motion(const MeasurementLog& run) {
  constexpr double kApart_s = 0.5, kSlowest_mps = 0.03, kMovingShare = 0.1;
  return share_of_arrivals(run, [&](double time_s) {
           const auto before = measured_pose_at(run, time_s - kApart_s / 2),
                      after = measured_pose_at(run, time_s + kApart_s / 2);
           return before && after &&
                  (after->translation_m - before->translation_m).norm() > kSlowest_mps * kApart_s;
         }) > kMovingShare;
}

/// Share of the arrivals with a measured pose at their time, if the poses' time stamps are late by lag_s.
double share_with_pose(const MeasurementLog& run, double lag_s) {
  return share_of_arrivals(run,
                           [&](double time_s) { return measured_pose_at(run, time_s + lag_s).has_value(); });
}

}  // namespace

bool do_poses_tumble(const std::vector<MeasurementLog>& runs) {
  constexpr double kUpright = 0.5, kShare = 0.1;  // cosine of a tilt of 60 degrees
  std::size_t all = 0, tilted = 0;
  for (const MeasurementLog& run : runs)
    for (const TimedPose& pose : run.poses) {
      ++all;
      tilted += (pose.T_map_vehicle.rotation * Eigen::Vector3d::UnitZ()).z() < kUpright;
    }
  return static_cast<double>(tilted) > kShare * static_cast<double>(all);
}

std::vector<Reading> other_pose_frames(const std::vector<MeasurementLog>& runs) {
  std::vector<Reading> readings;
  const auto posed = std::ranges::find_if(runs, is_posed);
  if (posed == runs.end()) return readings;
  if (do_poses_tumble(runs))
    readings.push_back({{ContradictionKind::kPoses, "in " + pose_file(*posed),
                         "quaternions in the order x y z w", "that the quaternions are in the order w x y z",
                         0.0, "write each line as time_s x y z qx qy qz qw"},
                        {},
                        [](std::size_t, MeasurementLog& run) {
                          for (TimedPose& pose : run.poses) {
                            const Eigen::Vector4d wxyz = pose.T_map_vehicle.rotation.coeffs();
                            pose.T_map_vehicle.rotation =
                                Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
                          }
                        }});
  for (const Reflection& reflection : kReflections)
    readings.push_back({{ContradictionKind::kPoses, "in " + pose_file(*posed), "in a right-handed frame",
                         fmt::format("that their frame is left-handed (mirrored): {}", reflection.words), 0.0,
                         "export the poses in a right-handed frame: z up, headings counter-clockwise from x"},
                        {},
                        [read = reflection.read](std::size_t, MeasurementLog& run) {
                          for (TimedPose& pose : run.poses) pose.T_map_vehicle = read(pose.T_map_vehicle);
                        }});
  return readings;
}

std::vector<Reading> other_pose_units(const std::vector<MeasurementLog>& runs) {
  std::vector<Reading> readings;
  const auto posed = std::ranges::find_if(runs, is_posed);
  if (posed == runs.end()) return readings;
  for (const LengthUnit& unit : length_units())
    readings.push_back({{ContradictionKind::kUnits, "in " + pose_file(*posed), "metres",
                         fmt::format("that their positions are in {}", unit.name), 0.0,
                         fmt::format("multiply the positions by {:g}", unit.metres)},
                        {},
                        [metres = unit.metres](std::size_t, MeasurementLog& run) {
                          for (TimedPose& pose : run.poses) pose.T_map_vehicle.translation_m *= metres;
                        }});
  return readings;
}

std::vector<ReadingFamily> poses_stamped_late(const std::vector<MeasurementLog>& runs) {
  constexpr double kPosesKept = 0.9;  // share of the arrivals with a pose that a lag must leave
  const auto moving = std::ranges::find_if(runs, are_poses_of_motion);
  if (moving == runs.end()) return {};
  const std::string file = file_of_poses(runs);
  ReadingFamily family = of_other_clock(ContradictionKind::kPoses, "in " + file, file, "they are stamped",
                                        [](double lag_s, MeasurementLog& run) {
                                          for (TimedPose& pose : run.poses) pose.time_s -= lag_s;
                                        });
  std::vector<double> fewest;
  fewest.reserve(runs.size());
  for (const MeasurementLog& run : runs) fewest.push_back(kPosesKept * share_with_pose(run, 0.0));
  family.may_be = [&runs, fewest](double lag_s) {
    for (std::size_t i = 0; i < runs.size(); ++i)
      if (share_with_pose(runs[i], lag_s) < fewest[i]) return false;
    return true;
  };
  return {family};
}

Reading poses_of_other_point(const std::vector<MeasurementLog>& runs, const Eigen::Vector3d& lever_m) {
  const std::string file = file_of_poses(runs);
  return {{ContradictionKind::kPoses, "in " + file, "of the origin of the vehicle's frame",
           fmt::format("that they are of a point at ({:.3f}, {:.3f}, {:.3f}) m on the vehicle", lever_m.x(),
                       lever_m.y(), lever_m.z()),
           0.0,
           "measure where the prism, the antenna or the markers are on the vehicle and give poses of its "
           "origin, or else count the receivers' places from that point"},
          {},
          [lever_m](std::size_t, MeasurementLog& run) {
            for (TimedPose& pose : run.poses)
              pose.T_map_vehicle.translation_m -= pose.T_map_vehicle.rotation * lever_m;
          },
          true};
}

std::optional<Pose> frame_between(const std::vector<Eigen::Vector3d>& from,
                                  const std::vector<Eigen::Vector3d>& to) {
  constexpr double kSpread_m2 = 0.01;
  if (from.empty() || from.size() != to.size()) return std::nullopt;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  const auto n = static_cast<double>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    a += from[i] / n;
    b += to[i] / n;
  }
  double along = 0.0, across = 0.0, spread_m2 = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = from[i] - a, q = to[i] - b;
    along += p.x() * q.x() + p.y() * q.y();
    across += p.x() * q.y() - p.y() * q.x();
    spread_m2 += p.head<2>().squaredNorm();
  }
  if (spread_m2 < kSpread_m2) return std::nullopt;
  Pose T = Pose::planar(0.0, 0.0, std::atan2(across, along));
  T.translation_m = b - T.rotation * a;
  return T;
}

Reading poses_of_other_frame(const std::vector<MeasurementLog>& runs, const Pose& T_map_frame) {
  const std::string file = file_of_poses(runs);
  constexpr double kDegrees = 180.0 / M_PI;
  const double turn = kDegrees * T_map_frame.heading_rad();
  const Eigen::Vector3d& shift = T_map_frame.translation_m;
  return {
      {ContradictionKind::kPoses, "in " + file, "in the frame of the control points",
       fmt::format("that the control points are in a frame turned by {:.2f} degrees against theirs", turn),
       0.0,
       fmt::format("measure both in one frame, or turn the poses (headings too) by {:.3f} degrees "
                   "counter-clockwise about the origin and then shift them by ({:.3f}, {:.3f}) m",
                   turn, shift.x(), shift.y())},
      {},
      [T_map_frame](std::size_t, MeasurementLog& run) {
        for (TimedPose& pose : run.poses) pose.T_map_vehicle = T_map_frame * pose.T_map_vehicle;
      },
      true};
}

std::vector<Reading> without_poses(const std::vector<MeasurementLog>& runs) {
  const auto posed =
      std::ranges::find_if(runs, [](const MeasurementLog& run) { return is_posed(run) && run.has_epochs; });
  if (posed == runs.end()) return {};
  return {Reading{{ContradictionKind::kPoses, "in " + posed->path + "/" + pose_file(*posed),
                   "poses of the vehicle in the map's frame",
                   "that they do not fit the arrivals, which fit without them", 0.0,
                   "compare them with the site file's frame (origin, axes, metres; the vehicle's origin; "
                   "headings in radians counter-clockwise from x), or leave them out"},
                  {},
                  [](std::size_t, MeasurementLog& run) {
                    if (run.has_epochs) run.poses.clear();
                  }}};
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>

// Octant in a robot's own program: given a deployment file and arrivals, it determines where the vehicle is.
// This header needs only the standard library, and liboctant.so exports nothing else, so the program may use
// any flags and libraries. Frames: map with z up, vehicle with x forward, y left, z up. SI units.
namespace octant {

/// One time of flight between a beacon and a receiver, by their names in the deployment.
struct Heard {
  std::string_view beacon;
  double tof_s = 0.0;
  std::string_view receiver = {};  ///< empty: the only receiver of the vehicle
  double time_s = 0.0;             ///< time of transmission or reception at the vehicle
  std::string_view vehicle = {};   ///< empty: the only vehicle of the deployment, or `robot`
  std::int64_t epoch = kNone;      ///< equal for the arrivals of one stop; kNone: the vehicle may be moving
  double amplitude_v = std::numeric_limits<double>::quiet_NaN();       ///< NaN: not measured
  double temperature_degC = std::numeric_limits<double>::quiet_NaN();  ///< NaN: use the deployment's
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();
};

/// Odometry since the last row: the vehicle's pose in its frame at that time. The first row is the anchor. In
/// space (inertial, visual), uses dz_m, and a quaternion instead of dheading_rad.
struct Moved {
  double time_s = 0.0, dx_m = 0.0, dy_m = 0.0, dheading_rad = 0.0;
  std::string_view vehicle = {};
  double dz_m = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
};

/// Pose of the vehicle in the frame of its odometry, which drifts over the map. Unlike Moved, a lost row
/// loses no motion. In space, uses z_m, and a quaternion instead of heading_rad.
struct MovedTo {
  double time_s = 0.0, x_m = 0.0, y_m = 0.0, heading_rad = 0.0;
  std::string_view vehicle = {};
  double z_m = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
};

/// Noise of the odometry over a step of length d and turn a:
///   sigma_xy^2 = distance^2 d + floor_m^2,  sigma_heading^2 = heading^2 d + (per_rad a)^2 + floor_rad^2
/// as in the block `odometry` of a recording's run.yaml, with the same defaults.
struct OdometryNoise {
  double distance_sigma_m_per_sqrt_m = 0.02;
  double heading_sigma_rad_per_sqrt_m = 0.02;
  double heading_sigma_per_rad = 0.0;
  double floor_m = 1.0e-4;
  double floor_rad = 1.0e-4;
};

/// Pose of the vehicle, or the reason why it is unknown.
struct Place {
  bool ok = false;
  const char* status = "";  ///< "ok", or the reason: "too_few_arrivals", "ambiguous", ...
  double time_s = 0.0;
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, heading_rad = 0.0;
  double qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
  /// Standard deviations, including the calibration; pi: the heading is unknown.
  double sigma_x_m = 0.0, sigma_y_m = 0.0, sigma_z_m = 0.0, sigma_heading_rad = 0.0;
  double covariance_xy_m2 = 0.0;
  /// Covariance of x, y, z [m] and of small rotations about x, y, z of the map [rad]; zero out of the plane
  /// for planar motion.
  double covariance[6][6] = {};
  /// In the vehicle's frame, along and about x, y, z, with standard deviations.
  bool has_velocity = false;
  double velocity_mps[3] = {}, turn_rate_radps[3] = {};
  double sigma_velocity_mps[3] = {}, sigma_turn_rate_radps[3] = {};
  double protection_level_m =
      0.0;  ///< bound of the horizontal error under one faulty beacon; 0: not computed
  int arrivals_used = 0, arrivals_rejected = 0;
  int vehicle = -1;  ///< index in the deployment
  /// "ok": the error is bounded by the protection level; "degraded": it is not; "no_fix"
  const char* integrity = "no_fix";
  const char* integrity_reason = "";  ///< empty for "ok"
};

/// A beacon or receiver that no longer agrees with the deployment. Its arrivals are ignored from then on.
struct Alarm {
  const char* kind =
      "";  ///< "beacon_late", "beacon_moved", "beacon_silent", "receiver_late", "receiver_moved"
  std::string_view name;     ///< of the beacon, or of the receiver
  std::string_view vehicle;  ///< of the receiver; empty for a beacon
  /// Displacement along x, y, z: of the map for a beacon, of the vehicle for a receiver.
  double shift_m[3] = {};
  double size_m = 0.0, sigma_m = 0.0;  ///< of the largest displacement, or of the delay as a length
  double since_s = 0.0, time_s = 0.0;  ///< first data that show it; time of the alarm
};

/// Locates vehicles with a deployment. An object may be used by one thread at a time.
class [[gnu::visibility("default")]] Positioner {
 public:
  /// Reads a deployment file. If this fails, or if a noise is negative or not a number, the object converts
  /// to false, and error() has place and reason.
  /// @param lateness_s  arrivals and odometry may arrive in any order within this time
  /// @param watch  also monitors beacons and receivers; see on_alarm
  explicit Positioner(const std::string& deployment_path, const OdometryNoise& odometry = {},
                      double lateness_s = 0.2, bool watch = false);
  /// Reads the text of a deployment file instead of a file.
  [[nodiscard]] static Positioner from_text(std::string_view deployment, const OdometryNoise& odometry = {},
                                            double lateness_s = 0.2, bool watch = false);
  ~Positioner();
  Positioner(Positioner &&) noexcept;
  Positioner& operator=(Positioner&&) noexcept;

  explicit operator bool() const noexcept;
  [[nodiscard]] const std::string& error() const noexcept;

  /// Locates a stationary vehicle from its arrivals alone, independently of other calls. Beacons and
  /// receivers that the deployment does not have count as rejected. No exceptions, no NaN.
  [[nodiscard]] Place locate(std::span<const Heard> heard) noexcept;

  /// Live data, in any order within the lateness. Arrivals of a pose are used as soon as all have come, and
  /// with odometry the vehicle is tracked. Fixes go to on_place.
  /// @return false if a name is unknown, a row is too late, an arrival is repeated, or the call comes from
  /// within on_place or on_alarm, where rows are refused
  void on_place(std::function<void(const Place&)> sink);
  void on_alarm(std::function<void(const Alarm&)> sink);
  bool hear(const Heard& heard);
  bool move(const Moved& moved);
  bool move_to(const MovedTo& pose);
  /// Fixes the waiting arrivals, because no more will come for this pose.
  void flush();
  /// Predicts the pose of a vehicle that is tracked, such as to the present time. The state does not change.
  /// @param vehicle  as in Heard
  [[nodiscard]] Place predict(double time_s, std::string_view vehicle = {}) noexcept;

 private:
  struct Inside;
  explicit Positioner(std::unique_ptr<Inside> inside);
  std::unique_ptr<Inside> inside_;
};

}  // namespace octant

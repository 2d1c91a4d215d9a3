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

// Octant in a robot's own program: a deployment file, what is heard, where the vehicle is. This header needs
// the standard library alone, and liboctant.so shows nothing else, so that the program may be built with
// whatever flags and libraries. Frames: map with z up, vehicle with x forward, y left, z up. SI units.
namespace octant {

/// One time of flight between a beacon and a receiver, by their names in the deployment.
struct Heard {
  std::string_view beacon;
  double tof_s = 0.0;
  std::string_view receiver = {};  ///< empty: the vehicle's only one
  double time_s = 0.0;             ///< the instant at which the vehicle's end of the path acts
  std::string_view vehicle = {};   ///< empty: the deployment's only one, or `robot`
  std::int64_t epoch = kNone;      ///< arrivals of one stop share one; kNone: the vehicle may be moving
  double amplitude_v = std::numeric_limits<double>::quiet_NaN();       ///< NaN: not measured
  double temperature_degC = std::numeric_limits<double>::quiet_NaN();  ///< NaN: the deployment's
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();
};

/// Odometry since the last row: the vehicle's pose in the frame that it had then. The first row is the
/// anchor. In space (inertial, visual) with dz_m, and a quaternion in place of dheading_rad.
struct Moved {
  double time_s = 0.0, dx_m = 0.0, dy_m = 0.0, dheading_rad = 0.0;
  std::string_view vehicle = {};
  double dz_m = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
};

/// Noise of the odometry over a step of length d and turn a:
///   sigma_xy^2 = distance^2 d + floor_m^2,  sigma_heading^2 = heading^2 d + (per_rad a)^2 + floor_rad^2
/// as in the block `odometry` of a recording's run.yaml, and the same where nothing is said.
struct OdometryNoise {
  double distance_sigma_m_per_sqrt_m = 0.02;
  double heading_sigma_rad_per_sqrt_m = 0.02;
  double heading_sigma_per_rad = 0.0;
  double floor_m = 1.0e-4;
  double floor_rad = 1.0e-4;
};

/// Where the vehicle is, or why that is not known.
struct Place {
  bool ok = false;
  const char* status = "";  ///< "ok", or the reason: "too_few_arrivals", "ambiguous", ...
  double time_s = 0.0;
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, heading_rad = 0.0;
  double qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
  /// Standard deviations, the calibration's part included; pi: the heading is not known.
  double sigma_x_m = 0.0, sigma_y_m = 0.0, sigma_z_m = 0.0, sigma_heading_rad = 0.0;
  double covariance_xy_m2 = 0.0;
  double protection_level_m =
      0.0;  ///< horizontal: how far off one beacon at fault could put it; 0: not computed
  int arrivals_used = 0, arrivals_rejected = 0;
  int vehicle = -1;  ///< its number in the deployment
};

/// Finds a vehicle by a deployment. One object is for one thread at a time.
class [[gnu::visibility("default")]] Positioner {
 public:
  /// Reads a deployment file. Where that fails, or a noise is no number from zero on, the object is false,
  /// and error() says where and why.
  /// @param lateness_s  arrivals and odometry may come in any order within it
  explicit Positioner(const std::string& deployment_path, const OdometryNoise& odometry = {},
                      double lateness_s = 0.2);
  ~Positioner();
  Positioner(Positioner &&) noexcept;
  Positioner& operator=(Positioner&&) noexcept;

  explicit operator bool() const noexcept;
  [[nodiscard]] const std::string& error() const noexcept;

  /// The fix of a standing vehicle by what it heard there, independent of all else. Beacons and receivers
  /// that the deployment does not have are left out (and count as rejected); no exceptions, no NaN.
  [[nodiscard]] Place locate(std::span<const Heard> heard) noexcept;

  /// As it goes, in any order within the lateness: arrivals are fixed as soon as all of a place have come,
  /// and while there is odometry the vehicle is tracked. Fixes go to on_place. @return false: a name is
  /// unknown, a row comes too late, an arrival repeats another one, or it is called within on_place, where
  /// nothing is taken
  void on_place(std::function<void(const Place&)> sink);
  bool hear(const Heard& heard);
  bool move(const Moved& moved);
  /// Nothing more is coming of this place.
  void flush();

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace octant

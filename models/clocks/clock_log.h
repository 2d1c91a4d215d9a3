// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/ids.h"
#include "models/run.h"
#include "models/site.h"

namespace octant {

/// Index of a transmitter or receiver: the beacons of a site, then the receivers of its vehicles.
using DeviceId = Id<struct DeviceTag>;

/// Difference of the arrival times of one signal at two beacons (or of the signals of two beacons at a
/// vehicle): arrival of b minus arrival of a.
struct TimeDifference {
  double time_s = 0.0;
  BeaconId a, b;
  double tdoa_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  VehicleId vehicle;
  ReceiverId receiver;
  int line = 0;
};

/// Time at which a device received a signal, on its own clock.
struct TimeStamp {
  DeviceId device;
  double after_s = 0.0;  ///< relative to Transmission::time_s, except for a constant of the log
};

/// One signal with the devices that received it. Its time of transmission is unknown, unless the transmitter
/// is among the receivers: then that reception is the time stamp of the transmission.
struct Transmission {
  double time_s = 0.0;  ///< time at which the pose of the vehicle is meant
  std::int64_t epoch = kNoEpoch;
  DeviceId source;
  std::vector<TimeStamp> receptions;
  bool is_difference = false;  ///< from time differences: time_s is the time of the clocks
};

/// Displacement of a vehicle between two epochs, in axes that do not turn.
struct Displacement {
  std::int64_t from = 0, to = 0;
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
};

/// Observations of one recording whose devices have clocks of their own.
struct ClockLog {
  std::vector<TimeDifference> differences;
  std::vector<Transmission> transmissions;
  std::vector<Displacement> displacements;
  std::vector<std::string> warnings;
  [[nodiscard]] bool empty() const { return differences.empty() && transmissions.empty(); }
};

/// Clocks of the devices of a site.
struct ClockModel {
  bool is_free = false;  ///< false: the beacons share one clock, except for their delays
  /// Allan deviation at 1 s. The phase is a random walk (white frequency noise); at kFlicker_s the random
  /// walk of the rate is as large.
  double allan_deviation = 1.0e-10;
  std::vector<int> of_device;      ///< number of the clock of each device
  std::vector<std::string> names;  ///< by number of the clock
};

/// Averaging time beyond which the rate of a crystal wanders [s].
inline constexpr double kFlicker_s = 100.0;
/// Allan deviations at 1 s of a crystal and of a temperature-compensated crystal oscillator.
inline constexpr double kCrystalDeviation = 1.0e-9, kTcxoDeviation = 1.0e-10;

/// Number of devices of a site or deployment, and index of a receiver among them.
[[nodiscard]] inline DeviceId device_of(BeaconId beacon) { return DeviceId(beacon.index()); }
[[nodiscard]] inline DeviceId device_of(ReceiverId receiver, std::size_t beacons) {
  return DeviceId(beacons + receiver.index());
}

/// Window within which time differences without epochs share a state of the vehicle [s].
inline constexpr double kDifferenceWindow_s = 0.1;

/// Combines time differences of the same signal into transmissions: rows of one epoch with the same time. The
/// arrival times of the beacons, relative to one of them, are robust least-squares estimates from all rows
/// that connect them.
[[nodiscard]] std::vector<Transmission> transmissions_of(const std::vector<TimeDifference>& rows,
                                                         std::size_t beacons);

/// Arrivals, one epoch for each epoch or window of time differences, for localizers with Clock::kCycleOffset.
/// Rows of a window that do not connect to the largest set of beacons are left out.
/// @param left_out  number of these rows
[[nodiscard]] std::vector<Arrival> arrivals_of(const std::vector<TimeDifference>& rows,
                                               std::size_t& left_out);

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/arrays.h"

#include <algorithm>
#include <limits>

#include "models/plain_fix.h"

namespace octant::python {

namespace py = pybind11;

void register_rows() {
  PYBIND11_NUMPY_DTYPE(Arrival, time_s, tof_s, beacon, receiver, vehicle, epoch, amplitude_v,
                       temperature_degC, line, received_after_s);
  PYBIND11_NUMPY_DTYPE(OdometryStep, time_s, dx_m, dy_m, dheading_rad, vehicle, dz_m, turn_x_rad, turn_y_rad);
  PYBIND11_NUMPY_DTYPE(Bearing, time_s, bearing_rad, reflector, vehicle, epoch, line);
  PYBIND11_NUMPY_DTYPE(FixRow, time_s, epoch, vehicle, status, ok, x_m, y_m, z_m, heading_rad, qx, qy, qz, qw,
                       sigma_x_m, sigma_y_m, sigma_heading_rad, protection_level_m, covariance, velocity_mps,
                       turn_rate_radps, sigma_velocity_mps, sigma_turn_rate_radps, arrivals_used,
                       arrivals_rejected);
}

FixRow row_of(const Fix& fix) {
  FixRow row;
  // Missing values are NaN, so that plots omit them.
  row.x_m = row.y_m = row.z_m = row.heading_rad = row.qx = row.qy = row.qz = row.qw = row.sigma_x_m =
      row.sigma_y_m = row.sigma_heading_rad = row.protection_level_m =
          std::numeric_limits<double>::quiet_NaN();
  for (auto& line : row.covariance) std::ranges::fill(line, row.x_m);
  for (auto* list :
       {&row.velocity_mps, &row.turn_rate_radps, &row.sigma_velocity_mps, &row.sigma_turn_rate_radps})
    std::ranges::fill(*list, row.x_m);
  row.epoch = fix.epoch;
  row.status = static_cast<std::int32_t>(fix.status);
  fill_row(fix, row);
  return row;
}

py::array poses_array(const std::vector<TimedPose>& poses) {
  py::array_t<double> array({poses.size(), std::size_t{8}});
  auto out = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < out.shape(0); ++i) {
    const TimedPose& pose = poses[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& p = pose.T_map_vehicle.translation_m;
    const Eigen::Quaterniond& q = pose.T_map_vehicle.rotation;
    const double row[] = {pose.time_s, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
    for (py::ssize_t j = 0; j < 8; ++j) out(i, j) = row[j];
  }
  return array;
}

}  // namespace octant::python

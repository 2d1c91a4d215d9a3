// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "models/fix.h"
#include "models/run.h"

// What Octant keeps in lists, as NumPy sees it: views into the list itself, which its owner keeps alive.
namespace octant::python {

/// One column: its name, NumPy's code of its type, where it stands in a row.
struct Column {
  const char* name;
  const char* type;
  std::size_t offset;
};

[[nodiscard]] pybind11::dtype dtype_of(const std::vector<Column>& columns, std::size_t row_size);

[[nodiscard]] inline pybind11::dtype dtype_of(const Arrival*) {
  return dtype_of({{"time_s", "f8", offsetof(Arrival, time_s)},
                   {"tof_s", "f8", offsetof(Arrival, tof_s)},
                   {"beacon", "i4", offsetof(Arrival, beacon)},
                   {"receiver", "i4", offsetof(Arrival, receiver)},
                   {"vehicle", "i4", offsetof(Arrival, vehicle)},
                   {"epoch", "i8", offsetof(Arrival, epoch)},
                   {"amplitude_v", "f8", offsetof(Arrival, amplitude_v)},
                   {"temperature_degC", "f8", offsetof(Arrival, temperature_degC)},
                   {"line", "i4", offsetof(Arrival, line)}},
                  sizeof(Arrival));
}
[[nodiscard]] inline pybind11::dtype dtype_of(const OdometryStep*) {
  return dtype_of({{"time_s", "f8", offsetof(OdometryStep, time_s)},
                   {"dx_m", "f8", offsetof(OdometryStep, dx_m)},
                   {"dy_m", "f8", offsetof(OdometryStep, dy_m)},
                   {"dheading_rad", "f8", offsetof(OdometryStep, dheading_rad)},
                   {"vehicle", "i4", offsetof(OdometryStep, vehicle)},
                   {"dz_m", "f8", offsetof(OdometryStep, dz_m)},
                   {"turn_x_rad", "f8", offsetof(OdometryStep, turn_x_rad)},
                   {"turn_y_rad", "f8", offsetof(OdometryStep, turn_y_rad)}},
                  sizeof(OdometryStep));
}
[[nodiscard]] inline pybind11::dtype dtype_of(const Bearing*) {
  return dtype_of({{"time_s", "f8", offsetof(Bearing, time_s)},
                   {"bearing_rad", "f8", offsetof(Bearing, bearing_rad)},
                   {"reflector", "i4", offsetof(Bearing, reflector)},
                   {"vehicle", "i4", offsetof(Bearing, vehicle)},
                   {"epoch", "i8", offsetof(Bearing, epoch)},
                   {"line", "i4", offsetof(Bearing, line)}},
                  sizeof(Bearing));
}

/// A fix as a row of numbers.
struct FixRow {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  std::int32_t vehicle = -1;
  std::int32_t status = 0;  ///< FixStatus
  bool ok = false;
  double x_m, y_m, z_m, heading_rad, qx, qy, qz, qw;
  double sigma_x_m, sigma_y_m, sigma_heading_rad, protection_level_m;
  std::int32_t arrivals_used = 0, arrivals_rejected = 0;
};
[[nodiscard]] FixRow row_of(const Fix& fix);
[[nodiscard]] pybind11::dtype dtype_of(const FixRow*);

/// A view of a list; `owner` holds it.
template <class Row>
[[nodiscard]] pybind11::array view(const std::vector<Row>& rows, const pybind11::handle& owner) {
  return pybind11::array(dtype_of(static_cast<const Row*>(nullptr)), {rows.size()}, {sizeof(Row)},
                         rows.data(), owner);
}
/// A view of a list that is nobody else's.
template <class Row>
[[nodiscard]] pybind11::array own(std::vector<Row> rows) {
  auto* kept = new std::vector<Row>(std::move(rows));
  return view(*kept, pybind11::capsule(kept, [](void* p) { delete static_cast<std::vector<Row>*>(p); }));
}

/// time_s, x, y, z, qx, qy, qz, qw of each.
[[nodiscard]] pybind11::array poses_array(const std::vector<TimedPose>& poses);

}  // namespace octant::python

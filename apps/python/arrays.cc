// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/arrays.h"

#include <limits>

#include "models/plain_fix.h"

namespace octant::python {

namespace py = pybind11;

py::dtype dtype_of(const std::vector<Column>& columns, std::size_t row_size) {
  py::list names, formats, offsets;
  for (const Column& column : columns) {
    names.append(column.name);
    formats.append(column.type);
    offsets.append(column.offset);
  }
  return {names, formats, offsets, static_cast<py::ssize_t>(row_size)};
}

FixRow row_of(const Fix& fix) {
  FixRow row;
  // What there is none of is no number, so that a plot leaves it out.
  row.x_m = row.y_m = row.z_m = row.heading_rad = row.qx = row.qy = row.qz = row.qw = row.sigma_x_m =
      row.sigma_y_m = row.sigma_heading_rad = row.protection_level_m =
          std::numeric_limits<double>::quiet_NaN();
  row.epoch = fix.epoch;
  row.status = static_cast<std::int32_t>(fix.status);
  fill_row(fix, row);
  return row;
}

py::dtype dtype_of(const FixRow*) {
#define OCTANT_COLUMN(name, type) \
  { #name, type, offsetof(FixRow, name) }
  return dtype_of({OCTANT_COLUMN(time_s, "f8"), OCTANT_COLUMN(epoch, "i8"), OCTANT_COLUMN(vehicle, "i4"),
                   OCTANT_COLUMN(status, "i4"), OCTANT_COLUMN(ok, "?"), OCTANT_COLUMN(x_m, "f8"),
                   OCTANT_COLUMN(y_m, "f8"), OCTANT_COLUMN(z_m, "f8"), OCTANT_COLUMN(heading_rad, "f8"),
                   OCTANT_COLUMN(qx, "f8"), OCTANT_COLUMN(qy, "f8"), OCTANT_COLUMN(qz, "f8"),
                   OCTANT_COLUMN(qw, "f8"), OCTANT_COLUMN(sigma_x_m, "f8"), OCTANT_COLUMN(sigma_y_m, "f8"),
                   OCTANT_COLUMN(sigma_heading_rad, "f8"), OCTANT_COLUMN(protection_level_m, "f8"),
                   OCTANT_COLUMN(arrivals_used, "i4"), OCTANT_COLUMN(arrivals_rejected, "i4")},
                  sizeof(FixRow));
#undef OCTANT_COLUMN
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

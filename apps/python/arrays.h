// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "models/fix.h"
#include "models/run.h"

namespace pybind11::detail {

/// An id converts to its number.
template <class Tag>
struct npy_format_descriptor<octant::Id<Tag>> : npy_format_descriptor<std::int32_t> {
  static std::string format() { return format_descriptor<std::int32_t>::format(); }
};

}  // namespace pybind11::detail

// NumPy views of Octant's lists, without copies; the owner of a list is kept alive.
namespace octant::python {

/// Registers the types of rows with NumPy. Call once, before any view is made.
void register_rows();

/// A fix as a row of numbers.
struct FixRow {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  std::int32_t vehicle = -1;
  std::int32_t status = 0;  ///< FixStatus
  bool ok = false;
  double x_m, y_m, z_m, heading_rad, qx, qy, qz, qw;
  double sigma_x_m, sigma_y_m, sigma_heading_rad, protection_level_m;
  double covariance[6][6], velocity_mps[3], turn_rate_radps[3], sigma_velocity_mps[3],
      sigma_turn_rate_radps[3];
  std::int32_t arrivals_used = 0, arrivals_rejected = 0;
};
[[nodiscard]] FixRow row_of(const Fix& fix);

/// View of a list that `owner` contains.
template <class Row>
[[nodiscard]] pybind11::array view(const std::vector<Row>& rows, const pybind11::handle& owner) {
  return pybind11::array(pybind11::dtype::of<Row>(), {rows.size()}, {sizeof(Row)}, rows.data(), owner);
}
/// View of a list that the view itself owns.
template <class Row>
[[nodiscard]] pybind11::array own(std::vector<Row> rows) {
  auto* kept = new std::vector<Row>(std::move(rows));
  return view(*kept, pybind11::capsule(kept, [](void* p) { delete static_cast<std::vector<Row>*>(p); }));
}

/// Columns time_s, x, y, z, qx, qy, qz, qw.
[[nodiscard]] pybind11::array poses_array(const std::vector<TimedPose>& poses);

}  // namespace octant::python

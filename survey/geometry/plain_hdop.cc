// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/plain_hdop.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/support/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "survey/geometry/plain_hdop.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#ifndef OCTANT_PLAIN_ROW
#define OCTANT_PLAIN_ROW
namespace octant::survey {
/// One row of cells: what each beacon adds depends on x alone.
struct PlainRow {
  const float *x_m, *y_m,
      *square_m2;  ///< of beacons: x from the grid's middle, y and its and the height's square from the row
  std::size_t beacons, columns;
  float first_m, cell_m;
};
}  // namespace octant::survey
#endif

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Four vectors of cells at once, so that no sum waits for the one before.
void plain_row_in_lanes(const PlainRow& row, float* out) {
  using D = hn::ScalableTag<float>;
  using V = hn::Vec<D>;
  const D d;
  constexpr std::size_t kAtOnce = 4;
  const std::size_t lanes = hn::Lanes(d);
  const V two = hn::Set(d, 2.0F), n = hn::Set(d, static_cast<float>(row.beacons)), zero = hn::Zero(d);
  for (std::size_t at = 0; at < row.columns; at += kAtOnce * lanes) {
    V x[kAtOnce], xx[kAtOnce], xy[kAtOnce], yy[kAtOnce];
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      x[k] = hn::MulAdd(hn::Iota(d, static_cast<float>(at + k * lanes)), hn::Set(d, row.cell_m),
                        hn::Set(d, row.first_m));
      xx[k] = xy[k] = yy[k] = zero;
    }
    for (std::size_t b = 0; b < row.beacons; ++b) {
      const V xb = hn::Set(d, row.x_m[b]), yb = hn::Set(d, row.y_m[b]), yb2 = hn::Mul(yb, yb),
              rest = hn::Set(d, row.square_m2[b]);
      for (std::size_t k = 0; k < kAtOnce; ++k) {
        const V dx = hn::Sub(x[k], xb), square = hn::MulAdd(dx, dx, rest);
        V inverse = hn::ApproximateReciprocal(square);
        inverse = hn::Mul(inverse, hn::NegMulAdd(square, inverse, two));  // a step of Newton's
        const V part = hn::Mul(dx, inverse);
        xx[k] = hn::MulAdd(part, dx, xx[k]);
        xy[k] = hn::MulAdd(part, yb, xy[k]);
        yy[k] = hn::MulAdd(yb2, inverse, yy[k]);
      }
    }
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const V determinant = hn::NegMulAdd(xy[k], xy[k], hn::Mul(xx[k], yy[k])), trace = hn::Add(xx[k], yy[k]);
      // HDOP^2 = trace / determinant; beyond 1000^2 it is rounding.
      const auto sound = hn::Gt(hn::Mul(determinant, hn::Set(d, 1e6F)), trace);
      const V hdop = hn::Sqrt(hn::Div(trace, hn::IfThenElse(sound, determinant, n)));
      hn::StoreU(hn::IfThenElse(sound, hdop, hn::Set(d, std::numeric_limits<float>::infinity())), d,
                 out + at + k * lanes);
    }
  }
}

std::size_t plain_room() { return 4 * hn::Lanes(hn::ScalableTag<float>()); }

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::survey {

HWY_EXPORT(plain_row_in_lanes);
HWY_EXPORT(plain_room);

std::vector<float> plain_hdop(const std::vector<Eigen::Vector3d>& beacons_m, double z_m,
                              const PlainGrid& grid, int threads) {
  constexpr std::size_t kRowsAtOnce = 16;
  std::vector<float> hdop(grid.columns * grid.rows);
  const std::size_t room = HWY_DYNAMIC_DISPATCH(plain_room)();
  // From the middle on, so that floats keep their digits however far the map's origin is.
  const double middle_m = grid.origin_m.x() + grid.cell_m * static_cast<double>(grid.columns) / 2;
  std::vector<float> x_m;
  for (const Eigen::Vector3d& b : beacons_m) x_m.push_back(static_cast<float>(b.x() - middle_m));
  for_each_parallel((grid.rows + kRowsAtOnce - 1) / kRowsAtOnce, threads, [&](std::size_t stretch) {
    std::vector<float> y_m(beacons_m.size()), square_m2(beacons_m.size()), padded(grid.columns + room);
    for (std::size_t r = stretch * kRowsAtOnce; r < std::min(grid.rows, (stretch + 1) * kRowsAtOnce); ++r) {
      const double y = grid.origin_m.y() + grid.cell_m * (static_cast<double>(r) + 0.5);
      for (std::size_t b = 0; b < beacons_m.size(); ++b) {
        const double dy = y - beacons_m[b].y(), dz = z_m - beacons_m[b].z();
        y_m[b] = static_cast<float>(dy);
        square_m2[b] = static_cast<float>(std::max(dy * dy + dz * dz, 1e-12));
      }
      HWY_DYNAMIC_DISPATCH(plain_row_in_lanes)
      ({x_m.data(), y_m.data(), square_m2.data(), beacons_m.size(), grid.columns,
        static_cast<float>(grid.origin_m.x() + grid.cell_m / 2 - middle_m), static_cast<float>(grid.cell_m)},
       padded.data());
      std::copy_n(padded.begin(), grid.columns, hdop.begin() + static_cast<std::ptrdiff_t>(r * grid.columns));
    }
  });
  return hdop;
}

}  // namespace octant::survey
#endif

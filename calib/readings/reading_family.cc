// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/reading_family.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <boost/math/tools/minima.hpp>

#include "calib/readings/pose_clock.h"

namespace octant::calib {
namespace {

constexpr double kLeastLag_s = 0.02, kMostLag_s = 2.0;
constexpr double kLeastScale = 0.01, kMostScale = 0.5;  ///< natural logarithms of factors
/// Share of the arrivals with a pose that a lag must leave.
constexpr double kPosesKept = 0.9;

/// Where it is; empty: there is none, or it is in space.
std::string planar_odometry(const std::vector<MeasurementLog>& runs) {
  const auto driven = std::ranges::find_if(runs, [](const auto& run) { return !run.odometry.empty(); });
  return driven != runs.end() && std::ranges::all_of(driven->odometry, &OdometryStep::is_planar)
             ? driven->path + "/odometry.csv"
             : "";
}

/// What of odometry is measured by one constant.
struct Measured {
  const char *subject, *too_much, *too_little, *columns, *cause;
  void (*rescale)(OdometryStep& step, double factor);
};
constexpr Measured kWay = {"its way is",
                           "long",
                           "short",
                           "dx_m and dy_m",
                           "the diameter of the wheels",
                           [](OdometryStep& step, double factor) {
                             step.dx_m *= factor, step.dy_m *= factor, step.way_m *= factor;
                           }};
constexpr Measured kTurns = {"its turns are",
                             "large",
                             "small",
                             "dheading_rad",
                             "the distance between the wheels, or the gyroscope",
                             [](OdometryStep& step, double factor) { step.dheading_rad *= factor; }};

/// Sizes are logarithms of the factor by which it comes out too large.
ReadingFamily of_other_scale(const std::string& file, const Measured& m) {
  const auto reading = [file, &m](double size) -> Reading {
    const double factor = std::exp(-size);
    return {{ContradictionKind::kLog, file, "metres and radians as the vehicle went them",
             fmt::format("that {} {:.2g} % too {}", m.subject, 100 * std::expm1(std::abs(size)),
                         size > 0 ? m.too_much : m.too_little),
             0.0, fmt::format("look at {}, or multiply {} by {:.4g}", m.cause, m.columns, factor)},
            {},
            [&m, factor](std::size_t, MeasurementLog& run) {
              for (OdometryStep& step : run.odometry) m.rescale(step, factor);
            },
            true};
  };
  return {reading, kLeastScale, kMostScale};
}

}  // namespace

std::vector<ReadingFamily> poses_stamped_late(const std::vector<MeasurementLog>& runs) {
  if (std::ranges::none_of(runs, poses_are_of_motion)) return {};
  const auto keeps_poses = [&runs](double lag_s) {
    return std::ranges::all_of(runs, [lag_s](const MeasurementLog& run) {
      return share_with_pose(run, lag_s) >= kPosesKept * share_with_pose(run, 0.0);
    });
  };
  return {{[&runs](double lag_s) { return poses_of_other_clock(runs, lag_s); }, kLeastLag_s, kMostLag_s,
           keeps_poses}};
}

std::vector<ReadingFamily> odometry_of_other_scale(const std::vector<MeasurementLog>& runs) {
  const std::string file = planar_odometry(runs);
  if (file.empty()) return {};
  return {of_other_scale(file, kWay), of_other_scale(file, kTurns)};
}

std::vector<ReadingFamily> odometry_stamped_late(const std::vector<MeasurementLog>& runs) {
  const std::string file = planar_odometry(runs);
  if (file.empty()) return {};
  const auto late = [file](double lag_s) -> Reading {
    return {
        {ContradictionKind::kLog, file, "times by the clock of the arrivals",
         fmt::format("that it is stamped {:.3g} s {}", std::abs(lag_s), lag_s > 0 ? "late" : "early"), 0.0,
         fmt::format("look at how the two clocks are synchronised, or {} {:.3g} s {} each time of {}",
                     lag_s > 0 ? "subtract" : "add", std::abs(lag_s), lag_s > 0 ? "from" : "to", file)},
        {},
        [lag_s](std::size_t, MeasurementLog& run) {
          for (OdometryStep& step : run.odometry) step.time_s -= lag_s;
        },
        true};
  };
  return {{late, kLeastLag_s, kMostLag_s}};
}

double likeliest_size(double least, double most, const std::function<double(double)>& loss) {
  constexpr int kBits = 8;
  constexpr std::uintmax_t kMostSteps = 12;
  double best = least, loss_of_best = INFINITY;
  for (int doublings = 0; std::ldexp(least, doublings) < most; ++doublings)
    for (const double sign : {1.0, -1.0}) {
      const double tried = sign * std::ldexp(least, doublings);
      if (const double here = loss(tried); here < loss_of_best) {
        loss_of_best = here;
        best = tried;
      }
    }
  std::uintmax_t steps = kMostSteps;
  const auto [log_size, refined] = boost::math::tools::brent_find_minima(
      [&](double log_of) { return loss(std::copysign(std::exp(log_of), best)); },
      std::log(std::abs(best) / 2), std::log(std::abs(best) * 2), kBits, steps);
  return refined < loss_of_best ? std::copysign(std::exp(log_size), best) : best;
}

}  // namespace octant::calib

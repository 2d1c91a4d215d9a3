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
constexpr double kLeastScale = 0.01, kMostScale = 0.5;
/// Of the errors that residuals show, the clearest; their sizes come out too small, as all bends to them.
constexpr std::size_t kCommonErrors = 3;
constexpr double kMostOverFound = 16.0;
/// Share of the arrivals with a pose that a lag must leave.
constexpr double kPosesKept = 0.9;

/// Where it is; empty: there is none, or it is in space.
std::string planar_odometry(const std::vector<MeasurementLog>& runs) {
  const auto driven = std::ranges::find_if(runs, [](const auto& run) { return !run.odometry.empty(); });
  return driven != runs.end() && std::ranges::all_of(driven->odometry, &OdometryStep::is_planar)
             ? driven->path + "/odometry.csv"
             : "";
}

/// With an error of that kind and of any size.
ReadingFamily with_error(CommonError error, const Site& site, const std::vector<MeasurementLog>& runs) {
  std::vector<std::pair<double, double>> spans_s;
  for (const MeasurementLog& run : runs) spans_s.push_back(span_of(run.arrivals));
  error.sigmas = 0.0;
  const auto reading = [error, &site, &runs, spans_s](double size) -> Reading {
    CommonError sized = error;
    sized.size = size;
    return {contradiction_of(sized, site, runs),
            {},
            [sized, spans_s](std::size_t run, MeasurementLog& log) {
              if (is_of_odometry(sized) || run == sized.run) take_back(sized, spans_s[run], log);
            },
            true};
  };
  return {reading};
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

std::vector<ReadingFamily> odometry_of_other_scale(const Site& site,
                                                   const std::vector<MeasurementLog>& runs) {
  if (planar_odometry(runs).empty()) return {};
  const auto driven = std::ranges::find_if(runs, [](const auto& run) { return !run.odometry.empty(); });
  std::vector<ReadingFamily> families;
  for (const CommonError::Kind kind : {CommonError::Kind::kWay, CommonError::Kind::kTurns}) {
    families.push_back(
        with_error({.kind = kind, .run = static_cast<std::size_t>(driven - runs.begin())}, site, runs));
    families.back().least = kLeastScale;
    families.back().most = kMostScale;
  }
  return families;
}

std::vector<ReadingFamily> with_common_errors(const std::vector<CommonError>& errors, const Site& site,
                                              const std::vector<MeasurementLog>& runs) {
  std::vector<ReadingFamily> families;
  for (const CommonError& error : errors) {
    if (families.size() == kCommonErrors) break;
    if (is_of_odometry(error)) continue;
    families.push_back(with_error(error, site, runs));
    families.back().least = std::abs(error.size) / 2;
    families.back().most = std::abs(error.size) * kMostOverFound;
  }
  return families;
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

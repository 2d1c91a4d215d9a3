// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/reading.h"

#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <boost/math/tools/minima.hpp>

namespace octant::calib {

ReadingFamily of_other_clock(ContradictionKind kind, const std::string& subject, const std::string& file,
                             const std::string& are_stamped,
                             void (*take_back)(double lag_s, MeasurementLog& run)) {
  constexpr double kLeastLag_s = 0.02, kMostLag_s = 2.0;
  const auto reading = [=](double lag_s) -> Reading {
    return {
        {kind, subject, "times by the clock of the arrivals",
         fmt::format("that {} {:.3g} s {}", are_stamped, std::abs(lag_s), lag_s > 0 ? "late" : "early"), 0.0,
         fmt::format("check how the two clocks are synchronised, or {} {:.3g} s {} each time of {}",
                     lag_s > 0 ? "subtract" : "add", std::abs(lag_s), lag_s > 0 ? "from" : "to", file)},
        {},
        [=](std::size_t, MeasurementLog& run) { take_back(lag_s, run); },
        true};
  };
  return {reading, kLeastLag_s, kMostLag_s};
}

std::optional<double> likeliest_size(double least, double most, double loss_of_none,
                                     const std::function<double(double)>& loss) {
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
  if (!(loss_of_best < loss_of_none)) return std::nullopt;
  std::uintmax_t steps = kMostSteps;
  const auto [log_size, refined] = boost::math::tools::brent_find_minima(
      [&](double log_of) { return loss(std::copysign(std::exp(log_of), best)); },
      std::log(std::abs(best) / 2), std::log(std::abs(best) * 2), kBits, steps);
  return refined < loss_of_best ? std::copysign(std::exp(log_size), best) : best;
}

}  // namespace octant::calib

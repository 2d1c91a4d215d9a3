// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statistics.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>

#include "models/linearise.h"
#include "models/parallel.h"

namespace octant::calib {

double chi_square_p(double sum_of_squares, double degrees_of_freedom) {
  if (!(degrees_of_freedom > 0)) return 1.0;
  const boost::math::chi_squared distribution(degrees_of_freedom);
  const double below = boost::math::cdf(distribution, std::max(0.0, sum_of_squares));
  const double above = boost::math::cdf(boost::math::complement(distribution, std::max(0.0, sum_of_squares)));
  return std::min(1.0, 2 * std::min(below, above));
}

namespace {

/// Of the arrivals that a thread took; added up in their order.
struct Sums {
  std::size_t used = 0, rejected = 0, amplitudes = 0;
  double squares_s2 = 0.0;
};

}  // namespace

CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                                    const SharedState& state, double cost, int threads) {
  CalibrationStatistics s;
  double observations = 0.0, squares_s2 = 0.0;
  std::size_t states = 0;
  for (const MeasurementLog& run : problem.runs) s.rejected += run.rejected.size();
  for (const Trajectory& t : trajectories) {
    s.rejected += t.stateless_arrivals.size();
    std::vector<Sums> parts(chunk_count(t.arrivals.size(), kArrivalsAtOnce));
    for_each_chunk(t.arrivals.size(), kArrivalsAtOnce, threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      Sums& sums = parts[chunk];
      for (std::size_t i = first; i < last; ++i) {
        const ArrivalObservation& a = t.arrivals[i];
        if (a.rejection != Rejection::kUsed) {
          ++sums.rejected;
          continue;
        }
        ++sums.used;
        sums.amplitudes += a.log_amplitude_sigma > 0 && state.attenuation ? 1 : 0;
        sums.squares_s2 += std::pow(a.sigma_s * arrival_residual(t, a, state), 2);
      }
    });
    for (const Sums& sums : parts) {
      s.rejected += sums.rejected;
      s.arrivals += sums.used;
      observations += static_cast<double>(sums.used + sums.amplitudes);
      squares_s2 += sums.squares_s2;
    }
    ObservationRow rows[6];
    for (std::size_t i = 0; i < t.bearings.size(); ++i)
      if (t.bearings[i].rejection == Rejection::kUsed) observations += bearing_rows(t, i, state, rows);
    for (const Segment& segment : t.segments) {
      if (!t.nodes[segment.first_node].placed) continue;
      states += (segment.last_node - segment.first_node) * static_cast<std::size_t>(t.block_size());
      for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i) observations += pose_rows(t, i, rows);
      for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i) observations += odometry_rows(t, i, rows);
      for (std::size_t i = segment.first_motion; i < segment.last_motion; ++i) observations += motion_rows(t, i, rows);
    }
  }
  for (const Parameter& p : layout.parameters) observations += std::isfinite(p.prior_sigma) ? 1.0 : 0.0;
  observations += static_cast<double>(problem.site.distances.size());
  s.unknowns = static_cast<std::size_t>(layout.size()) + states;
  s.redundancy = observations - static_cast<double>(s.unknowns);
  s.variance_factor = s.redundancy > 0 ? 2 * cost / s.redundancy : 1.0;
  s.chi2_p = chi_square_p(2 * cost, s.redundancy);
  s.rms_s = s.arrivals > 0 ? std::sqrt(squares_s2 / static_cast<double>(s.arrivals)) : 0.0;
  return s;
}

}  // namespace octant::calib

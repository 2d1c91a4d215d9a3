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

void ObservationCounts::add(const ObservationCounts& other) {
  used += other.used;
  rejected += other.rejected;
  observations += other.observations;
  states += other.states;
  squares_s2 += other.squares_s2;
}

ObservationCounts count_observations(const Trajectory& t, const SharedState& state, int threads, bool residuals) {
  ObservationCounts counts;
  counts.rejected = t.stateless_arrivals.size();
  std::vector<ObservationCounts> parts(chunk_count(t.arrivals.size(), kArrivalsAtOnce));  // added up in their order
  for_each_chunk(t.arrivals.size(), kArrivalsAtOnce, threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    ObservationCounts& part = parts[chunk];
    std::size_t amplitudes = 0;
    for (std::size_t i = first; i < last; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (a.rejection != Rejection::kUsed) {
        ++part.rejected;
        continue;
      }
      ++part.used;
      amplitudes += a.log_amplitude_sigma > 0 && state.attenuation ? 1 : 0;
      if (residuals) part.squares_s2 += std::pow(a.sigma_s * arrival_residual(t, a, state), 2);
    }
    part.observations = static_cast<double>(part.used + amplitudes);
  });
  for (const ObservationCounts& part : parts) counts.add(part);
  ObservationRow rows[6];
  for (std::size_t i = 0; i < t.bearings.size(); ++i)
    if (t.bearings[i].rejection == Rejection::kUsed) counts.observations += bearing_rows(t, i, state, rows);
  for (const Segment& segment : t.segments) {
    if (!t.nodes[segment.first_node].placed) continue;
    counts.states += (segment.last_node - segment.first_node) * static_cast<std::size_t>(t.block_size());
    for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i) counts.observations += pose_rows(t, i, rows);
    for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i) counts.observations += odometry_rows(t, i, rows);
    for (std::size_t i = segment.first_motion; i < segment.last_motion; ++i) counts.observations += motion_rows(t, i, rows);
  }
  return counts;
}

CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout, ObservationCounts counts, double cost) {
  CalibrationStatistics s;
  for (const MeasurementLog& run : problem.runs) counts.rejected += run.rejected.size();
  for (const Parameter& p : layout.parameters) counts.observations += std::isfinite(p.prior_sigma) ? 1.0 : 0.0;
  counts.observations += static_cast<double>(problem.site.distances.size());
  s.arrivals = counts.used;
  s.rejected = counts.rejected;
  s.unknowns = static_cast<std::size_t>(layout.size()) + counts.states;
  s.redundancy = counts.observations - static_cast<double>(s.unknowns);
  s.variance_factor = s.redundancy > 0 ? 2 * cost / s.redundancy : 1.0;
  s.chi2_p = chi_square_p(2 * cost, s.redundancy);
  s.rms_s = s.arrivals > 0 ? std::sqrt(counts.squares_s2 / static_cast<double>(s.arrivals)) : 0.0;
  return s;
}

CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                                    const SharedState& state, double cost, int threads) {
  ObservationCounts counts;
  for (const Trajectory& t : trajectories) counts.add(count_observations(t, state, threads));
  return statistics_of(problem, layout, counts, cost);
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/conclude.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calib/datum.h"
#include "calib/label_check.h"
#include "calib/observability.h"
#include "calib/reliability.h"
#include "calib/start.h"
#include "calib/statistics.h"

namespace octant::calib {
namespace {

constexpr double kNoiseMatters = 0.02;

/// Beacons that a mirror image explains as well from the final states; the start saw them with rougher ranges.
std::vector<bool> still_mirrored(const Problem& problem, const Estimate& estimate, const std::vector<Trajectory>& trajectories,
                                 const SharedState& state) {
  std::vector<bool> still = estimate.beacon_mirrored;
  for (std::size_t b = 0; b < still.size(); ++b)
    if (still[b]) still[b] = has_mirror_image(problem, state, trajectories, b, 3 * estimate.sigma_m(problem));
  return still;
}

/// Amplitudes that are taken to be alike all round receivers that have axes.
bool may_be_directional(const Problem& problem, const std::vector<Trajectory>& trajectories) {
  const Site& site = problem.site;
  if (!site.attenuation || site.attenuation->half_power_angle_rad.value > 0) return false;
  const auto measured = [](const Trajectory& t) {
    return std::any_of(t.arrivals.begin(), t.arrivals.end(), [](const ArrivalObservation& a) { return a.log_amplitude_sigma > 0; });
  };
  return std::any_of(site.receivers.begin(), site.receivers.end(), [](const SiteReceiver& r) { return r.axis.has_value(); }) &&
         std::any_of(trajectories.begin(), trajectories.end(), measured);
}

void warn_of_noise(const Problem& problem, const Findings& findings, double noise_factor, const std::vector<Trajectory>& trajectories, Solution& solution) {
  const CalibrationStatistics& s = solution.statistics;
  if (s.redundancy >= 30 && noise_factor > 1.2)
    solution.warnings.push_back(
        fmt::format("residuals are {:.2f} times the stated noise (variance factor {:.3g}); sigmas are scaled to the residuals, "
                    "but errors that stay the "
                    "same at a place or a pair are not noise and make the beacons worse than their sigmas say",
                    noise_factor, s.variance_factor));
  if (s.redundancy >= 30 && noise_factor > 1.2 && may_be_directional(problem, trajectories))
    solution.warnings.push_back(
        "amplitudes are taken to be alike all round each receiver: where these hear less off their axes, state "
        "attenuation.half_power_angle_rad (half of the beam width at -3 dB, with a sigma)");
  const Whiteness& w = findings.whiteness;
  if (!w.white)
    solution.warnings.push_back(
        fmt::format("residuals are no white noise: those of a beacon-receiver pair keep a common part (variance of pair means "
                    "{:.3g} times that of noise, "
                    "correlation in time {:.2f}), as reflections and antennas cause; such errors do not average out, so expect "
                    "the beacons off by several "
                    "times their stated sigmas, or state noise.pair_sigma_s",
                    w.pair_ratio, w.autocorrelation));
}

}  // namespace

double noise_off_by(double data_cost, double redundancy) {
  const double squares = 2 * data_cost;
  if (!(redundancy >= 30) || !(squares > 0) || chi_square_p(squares, redundancy) > 0.01) return 1.0;
  const double off = std::sqrt(squares / redundancy);
  return std::abs(off - 1) < kNoiseMatters ? 1.0 : off;  // seen by the test, but of no consequence for any sigma
}

void conclude(const Problem& problem, const SolveOptions& options, const Estimate& estimate, Findings findings,
              std::vector<Trajectory>& trajectories, Solution& solution) {
  const AdjustResult& last = estimate.last;
  solution.state = estimate.state();
  solution.final_cost = last.cost;
  solution.tof_sigma_s = problem.site.noise.tof_sigma_s * estimate.noise_factor;
  solution.statistics = findings.statistics;
  solution.statistics.converged = last.converged;
  // The factor is told against what the site file states, not against the noise as found.
  solution.statistics.variance_factor *= estimate.noise_factor * estimate.noise_factor;
  solution.statistics.chi2_p =
      chi_square_p(solution.statistics.variance_factor * solution.statistics.redundancy, solution.statistics.redundancy);
  solution.status = last.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
  solution.message = last.converged ? "converged" : "the adjustment did not converge: " + last.message;
  solution.datum = datum_of(problem);
  // What the data do not determine is often what keeps the iteration from settling, and then that is the finding.
  const Covariance C = judge(problem, estimate.layout, estimate.x, estimate.beacon_usable,
                             still_mirrored(problem, estimate, trajectories, solution.state), options.strict, trajectories,
                             solution, options.workers(), last.data_information);
  solution.reliability =
      reliability_of(problem, estimate.layout, trajectories, solution.state, C, solution.beacon_status, estimate.noise_factor,
                     options.threads, kAllEpochs, findings.whole ? &*findings.whole : nullptr);
  solution.left_out = std::move(findings.left_out);
  solution.whole = std::move(findings.whole);
  warn_of_noise(problem, findings, estimate.noise_factor, trajectories, solution);
  solution.warnings.insert(solution.warnings.end(), findings.flips.begin(), findings.flips.end());
  for (std::string& warning : suspect_control_points(problem, solution.state, trajectories))
    solution.warnings.push_back(std::move(warning));
}

}  // namespace octant::calib

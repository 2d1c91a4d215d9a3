// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/shadows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/problem/ranges.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Number of arrivals beyond which a single stop has no effect.
constexpr std::size_t kMostHeard = 20'000;
/// Ratio of sigma to the median magnitude of a normal variable.
constexpr double kSigmaOfMedian = 1.4826;

bool is_stop(const Trajectory& t, const Segment& s) {
  return s.last_node - s.first_node == 1 && t.nodes[s.first_node].placed;
}

/// Hypothetical lateness of a beacon in use at a stop.
struct Lateness {
  double sigmas = 0.0;    ///< w
  double sigma_s = 0.0;   ///< standard deviation of the lateness
  Eigen::VectorXd shift;  ///< shift of the parameters by one sigma of it
};

/// Numbers of beacons at stops that are in use or late, and the lateness of the late ones.
struct HeardAtStops {
  std::size_t beacons = 0, late = 0;
  std::vector<double> late_s;
};

std::vector<BeaconId> beacons_of(const Trajectory& t, const Segment& s) {
  std::vector<BeaconId> heard;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    if (std::ranges::find(heard, t.arrivals[i].beacon) == heard.end()) heard.push_back(t.arrivals[i].beacon);
  return heard;
}

HeardAtStops heard_at_stops(const std::vector<Trajectory>& trajectories, const SharedState& state) {
  HeardAtStops heard;
  for (const Trajectory& t : trajectories)
    for (const Segment& s : t.segments) {
      if (!is_stop(t, s)) continue;
      for (const BeaconId beacon : beacons_of(t, s)) {
        bool used = false, late = false;
        for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
          const ArrivalObservation& a = t.arrivals[i];
          if (a.beacon != beacon) continue;
          used = used || a.rejection == Rejection::kUsed;
          if (a.rejection != Rejection::kLate) continue;
          late = true;
          heard.late_s.push_back(arrival_residual(t, a, state) * a.sigma_s);
        }
        heard.beacons += used || late;
        heard.late += late && !used;
      }
    }
  return heard;
}

std::vector<Lateness> latenesses(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                 const AdjustedParameters& parameters) {
  std::vector<Lateness> all;
  for (const Trajectory& t : trajectories)
    for (const Segment& s : t.segments) {
      if (!is_stop(t, s)) continue;
      const std::vector<BeaconId> heard = beacons_of(t, s);
      const auto errors = static_cast<Eigen::Index>(heard.size());
      const ScoreTest test =
          score_test(t, s, state, parameters.layout, errors,
                     [&](const Trajectory& of, const ObservationRow& row, Eigen::RowVectorXd& by) {
                       if (row.kind != RowKind::kTof) return false;
                       const ArrivalObservation& a = of.arrivals[row.index];
                       by[std::ranges::find(heard, a.beacon) - heard.begin()] = 1.0 / a.sigma_s;
                       return true;
                     });
      for (Eigen::Index i = 0; i < errors; ++i) {
        const ScoreTest::Finding found = test.of_error(i, parameters);
        if (found.sigmas == 0.0) continue;  // the stop needs it, or it is not in use
        const double sigma_s = found.size[0] / found.sigmas;
        all.push_back({found.sigmas, sigma_s, sigma_s * test.shift(i, parameters.covariance)});
      }
    }
  return all;
}

/// Ratio of their scatter to that of white errors, at least 1.
double scatter_of(const std::vector<Lateness>& all) {
  std::vector<double> magnitude;
  magnitude.reserve(all.size());
  for (const Lateness& l : all) magnitude.push_back(std::abs(l.sigmas));
  return magnitude.empty() ? 1.0 : std::max(1.0, kSigmaOfMedian * median(std::move(magnitude)));
}

}  // namespace

ShadowRisk shadow_risk(const std::vector<Trajectory>& trajectories, const SharedState& state,
                       const AdjustedParameters& parameters) {
  ShadowRisk risk;
  std::size_t arrivals = 0;
  for (const Trajectory& t : trajectories) arrivals += t.arrivals.size();
  if (arrivals > kMostHeard || !is_dense(parameters.layout)) return risk;
  HeardAtStops heard = heard_at_stops(trajectories, state);
  if (heard.late == 0 || heard.late >= heard.beacons) return risk;
  risk.share = static_cast<double>(heard.late) / static_cast<double>(heard.beacons);
  const double range_s = 2.0 * median(std::move(heard.late_s));
  const std::vector<Lateness> all = latenesses(trajectories, state, parameters);
  const double scatter = scatter_of(all);
  risk.covariance.setZero(parameters.layout.size(), parameters.layout.size());
  for (const Lateness& l : all) {
    const double w = l.sigmas / scatter, sigma_s = l.sigma_s * scatter,
                 below = 0.5 * std::erfc(-w / std::numbers::sqrt2),
                 density = std::exp(-0.5 * w * w) / std::sqrt(2 * std::numbers::pi);
    // sqrt(2 pi) exp(w^2 / 2) Phi(w) equals Phi(w) divided by the density.
    const double odds = risk.share / (1.0 - risk.share) * sigma_s / range_s * below / density,
                 late = std::isfinite(odds) ? odds / (1.0 + odds) : 1.0,
                 square = std::max(0.0, w * w + 1.0 + w * density / below);
    risk.covariance += late * square * scatter * scatter * l.shift * l.shift.transpose();
  }
  return risk;
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/datum.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/ranges.h"
#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

constexpr const char* kFreeNetwork = "inner constraints (free network)";

void describe(Datum& datum) {
  const std::string named =
      datum.position == "control points" ? fmt::format(" ({})", fmt::join(datum.control_points, ", ")) : "";
  datum.description = fmt::format("position by {}{}, orientation by {}, scale by {}", datum.position, named,
                                  datum.orientation, datum.scale);
}

bool approximately_known(const SiteBeacon& b) {
  return b.position_m[0] && b.position_m[1] && b.sigma_m[0] && b.sigma_m[1] && !b.is_control_point();
}

std::string scale_of(const Problem& problem, std::size_t control_points, bool poses) {
  std::vector<std::string> sources;
  const Site& site = problem.site;
  if (control_points >= 2) sources.emplace_back("control points");
  if (poses) sources.emplace_back("measured poses");
  if (!site.distances.empty()) sources.emplace_back("taped distances");
  for (const MeasurementLog& run : problem.runs)
    if (!run.odometry.empty()) {
      sources.emplace_back("odometry");
      break;
    }
  if (site.receivers.size() > 1) sources.emplace_back("receiver array");
  if (site.speed_sigma_mps == 0) {
    sources.emplace_back("medium (speed held)");
  } else if (site.speed_sigma_mps < 0.05 * speed_mps(site.medium)) {
    sources.emplace_back("medium (speed prior)");
  }
  return sources.empty() ? "nothing" : fmt::format("{}", fmt::join(sources, ", "));
}

}  // namespace

Datum datum_of(const Problem& problem) {
  Datum datum;
  const Site& site = problem.site;
  std::size_t approximate = 0;
  for (const SiteBeacon& b : site.beacons) {
    if (b.is_control_point()) datum.control_points.push_back(b.name);
    approximate += approximately_known(b);
  }
  const bool poses =
      std::ranges::any_of(problem.runs, [](const MeasurementLog& r) { return !r.poses.empty(); });
  const std::size_t fixed = datum.control_points.size();
  const std::string priors = approximate > 0 ? "approximate beacon positions (priors)" : kFreeNetwork;
  datum.position = fixed >= 1 ? "control points" : poses ? "measured poses" : priors;
  datum.orientation = fixed >= 2 ? "control points" : poses ? "measured poses" : priors;
  datum.scale = scale_of(problem, fixed, poses);
  describe(datum);
  return datum;
}

void set_free_network(Datum& datum) {
  if (datum.position != "control points") datum.position = kFreeNetwork;
  if (datum.orientation != "control points") datum.orientation = kFreeNetwork;
  describe(datum);
}

/// Share of the typical range from which a motion counts as undetermined.
constexpr double kVagueDatum = 0.25;

template <class Matrix>
Eigen::MatrixXd free_datum(const Problem& problem, const ParameterLayout& layout, const SharedState& state,
                           const Matrix& information) {
  const Motion motion = problem.site.motion;
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(layout.size(), pose_dof(motion));
  for (std::size_t b = 0; b < layout.beacon.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int column = layout.beacon[b][i]; column >= 0)
        F.row(column) = map_motions_at(state.beacon_p_map_m[b], motion).row(static_cast<Eigen::Index>(i));
  const PivotedQr qr(F);
  if (layout.size() == 0 || qr.rank() == 0) return Eigen::MatrixXd(layout.size(), 0);
  const Eigen::MatrixXd Q = qr.basis(), NQ = information * Q;
  const SymmetricEigen<Eigen::MatrixXd> eigen(Q.transpose() * NQ);
  const auto free_beacons = std::ranges::count_if(layout.beacon, [](const auto& c) {
    return std::max({c[0], c[1], c[2]}) >= 0;
  });
  // A unit motion moves each beacon by 1 / sqrt(beacons). Positions with a sigma of a hundred metres define
  // no map.
  const double limit_m =
      kVagueDatum * typical_range_m(problem) * std::sqrt(static_cast<double>(free_beacons));
  Eigen::Index unobservable = 0;
  while (unobservable < eigen.eigenvalues().size() &&
         eigen.eigenvalues()[unobservable] * limit_m * limit_m < 1.0)
    ++unobservable;
  return Q * eigen.eigenvectors().leftCols(unobservable);
}

template Eigen::MatrixXd free_datum(const Problem&, const ParameterLayout&, const SharedState&,
                                    const Eigen::MatrixXd&);
template Eigen::MatrixXd free_datum(const Problem&, const ParameterLayout&, const SharedState&,
                                    const Eigen::SparseMatrix<double>&);

}  // namespace octant::calib

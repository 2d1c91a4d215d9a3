// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/flips.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace octant::calib {
namespace {

constexpr std::size_t kNamed = 8;  ///< epochs listed before "and N more"

bool has_stops(const Trajectory& t) { return !t.moving && t.motion == Motion::kPlanar; }

std::string epochs_text(const std::vector<std::int64_t>& epochs) {
  const std::size_t shown = std::min(kNamed, epochs.size());
  std::string text =
      fmt::format("{}", fmt::join(epochs.begin(), epochs.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
  if (shown < epochs.size()) text += fmt::format(" and {} more", epochs.size() - shown);
  return text;
}

}  // namespace

std::vector<std::vector<double>> epoch_headings_rad(const std::vector<Trajectory>& trajectories) {
  std::vector<std::vector<double>> headings(trajectories.size());
  for (std::size_t i = 0; i < trajectories.size(); ++i)
    if (has_stops(trajectories[i]))
      for (const Node& node : trajectories[i].nodes)
        headings[i].push_back(node.placed ? node.T_map_vehicle.heading_rad() : NAN);
  return headings;
}

bool has_heading(const Site& site, VehicleId vehicle, bool measured) {
  constexpr double kSigmas = 3.0;  // nearer to each other receivers may be one
  std::vector<Eigen::Vector2d> ends;
  if (measured) ends.push_back(Eigen::Vector2d::Zero());
  double sigma_m = 0.0;
  for (const SiteReceiver& r : site.receivers) {
    if (r.vehicle != vehicle) continue;
    ends.emplace_back(r.position_m.head<2>());
    sigma_m = std::max(sigma_m, r.sigma_m.head<2>().maxCoeff());
  }
  return std::ranges::any_of(
      ends, [&](const Eigen::Vector2d& end) { return (end - ends.front()).norm() > kSigmas * sigma_m; });
}

bool is_flipped(const Node& node, double before_rad) {
  return node.placed && std::cos(node.T_map_vehicle.heading_rad() - before_rad) < 0;
}

std::vector<std::string> flips_in_words(const MeasurementLog& run, const std::vector<std::int64_t>& epochs) {
  if (epochs.empty()) return {};
  return {fmt::format("{}: {} epochs faced the wrong way at the start and were turned: {}", run.path,
                      epochs.size(), epochs_text(epochs))};
}

std::vector<std::string> report_flips(const Site& site, const std::vector<MeasurementLog>& runs,
                                      const std::vector<Trajectory>& trajectories,
                                      const std::vector<std::vector<double>>& before) {
  std::vector<std::string> reported;
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    const Trajectory& t = trajectories[i];
    if (t.bearings.empty() && !has_heading(site, t.vehicle, !t.poses.empty() || !t.odometry.empty()))
      continue;
    if (!has_stops(t) || before[i].size() != trajectories[i].nodes.size()) continue;
    std::vector<std::int64_t> flipped;
    for (std::size_t k = 0; k < before[i].size(); ++k)
      if (is_flipped(trajectories[i].nodes[k], before[i][k]))
        flipped.push_back(trajectories[i].nodes[k].epoch);
    for (std::string& words : flips_in_words(runs[trajectories[i].run], flipped))
      reported.push_back(std::move(words));
  }
  return reported;
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/weak_directions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "models/trajectory/trajectory.h"

namespace octant::calib {
namespace {

constexpr double kWorthReporting = 0.5;  ///< share of the tolerance from which a combination is reported
constexpr double kNamedPart =
    0.1;  ///< share of a combination's square from which a kind of parameter is named
constexpr double kParameterPart = 0.03;  ///< share from which a single parameter is named
constexpr std::size_t kSegmentsMoved = 2000;
/// Order in descriptions, most important first: "delays against speed of sound".
constexpr std::array<ParameterTopic, kParameterTopics> kReportOrder = {
    ParameterTopic::kHeight,   ParameterTopic::kPlace,       ParameterTopic::kDelay, ParameterTopic::kSpeed,
    ParameterTopic::kReceiver, ParameterTopic::kAttenuation, ParameterTopic::kGain,  ParameterTopic::kDrift};
static_assert(std::ranges::is_permutation(kReportOrder, []() {
  std::array<ParameterTopic, kParameterTopics> all = {};
  for (std::size_t i = 0; i < kParameterTopics; ++i) all[i] = static_cast<ParameterTopic>(i);
  return all;
}()));
constexpr ParameterId kRiseTime = parameters::attenuation(2);

/// Describes a unit combination (in metres).
WeakDirection in_words(const ParameterLayout& layout, const NameTable& names, const Eigen::VectorXd& v) {
  WeakDirection w;
  std::array<double, kParameterTopics> share = {};
  std::vector<int> order(static_cast<std::size_t>(v.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&v](int a, int b) { return std::abs(v[a]) > std::abs(v[b]); });
  std::vector<std::string> beacons;
  for (const int i : order) {
    const ParameterId& id = layout.parameter(i).id;
    share[static_cast<std::size_t>(topic_of(id))] += v[i] * v[i];
    if (v[i] * v[i] < kParameterPart) continue;
    w.parameters.push_back(parameter_name(id, names));
    const auto beacon = beacon_of(id);
    if (beacon && std::ranges::find(beacons, names.beacons[*beacon]) == beacons.end())
      beacons.push_back(names.beacons[*beacon]);
  }
  std::vector<std::string> parts;
  const auto takes_part = [&](ParameterTopic topic) {
    return share[static_cast<std::size_t>(topic)] > kNamedPart;
  };
  for (const ParameterTopic topic : kReportOrder)
    if (takes_part(topic)) parts.emplace_back(words_of(topic));
  for (std::size_t k = 0; k < kParameterTopics && w.remedy.empty(); ++k)  // topics are in order of cost
    if (takes_part(static_cast<ParameterTopic>(k))) w.remedy = remedy_of(static_cast<ParameterTopic>(k));
  w.description = fmt::format("{}{}", fmt::join(parts, " against "),
                              beacons.empty() ? "" : fmt::format(" ({})", fmt::join(beacons, ", ")));
  return w;
}

}  // namespace

double shift_at_robot_m(const ParameterLayout& layout, const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                        const std::vector<Trajectory>& trajectories) {
  const SharedState there = layout.state_of(y), here = layout.state_of(x);
  double squares = 0.0;
  std::size_t count = 0;
  for (const Trajectory& whole : trajectories) {
    const Trajectory t =
        some_segments(whole, std::max<std::size_t>(1, whole.segments.size() / kSegmentsMoved));
    Trajectory moved = t;
    for (const Segment& segment : t.segments) {
      if (!t.nodes[segment.first_node].placed) continue;
      if (segment.first_pose < segment.last_pose) {
        // A measured pose does not move, so the change of its ranges counts.
        for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
          const ArrivalObservation& a = t.arrivals[i];
          const double range_m =
              a.sigma_s * a.model_speed_mps * (arrival_residual(t, a, there) - arrival_residual(t, a, here));
          squares += range_m * range_m;
          ++count;
        }
        continue;
      }
      solve_states(moved, segment, there, {});
      for (std::size_t k = segment.first_node; k < segment.last_node; ++k) {
        squares += (moved.nodes[k].T_map_vehicle.translation_m - t.nodes[k].T_map_vehicle.translation_m)
                       .head<2>()
                       .squaredNorm();
        ++count;
      }
    }
  }
  return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
}

std::vector<WeakDirection> weak_directions(const ParameterLayout& layout, const NameTable& names,
                                           const Eigen::VectorXd& x, const Covariance& C,
                                           const std::vector<bool>& usable,
                                           const std::vector<Trajectory>& trajectories,
                                           const WeakDirectionOptions& options) {
  std::vector<WeakDirection> reported;
  Eigen::VectorXd metres = Eigen::VectorXd::Ones(layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    const ParameterId& id = layout.parameter(i).id;
    const ParameterWorth worth = row_of(id.kind).worth;
    if (worth == ParameterWorth::kRange) metres[i] = options.typical_range_m;
    if (worth == ParameterWorth::kOpen && id != kRiseTime) metres[i] = 0.0;
  }
  for (std::size_t b = 0; b < usable.size(); ++b)  // reported already
    for (const int column : layout.columns_of_beacon(b))
      if (!usable[b] && column >= 0) metres[column] = 0.0;
  if (layout.size() == 0) return reported;
  for (const auto& [variance, v] :
       C.largest(metres, options.most, std::pow(kWorthReporting * options.limit_m, 2))) {
    const double sigma_m = std::sqrt(variance);
    WeakDirection w = in_words(layout, names, v);
    w.sigma_m = sigma_m;
    // All parameters move as they are correlated with the combination.
    const Eigen::VectorXd step = C.times(metres.cwiseProduct(v)) / sigma_m;
    w.consequence_m = shift_at_robot_m(layout, x, x + step, trajectories);
    reported.push_back(std::move(w));
  }
  return reported;
}

}  // namespace octant::calib

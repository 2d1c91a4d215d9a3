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

constexpr double kTold = 0.5;  ///< share of the tolerance from which a combination is worth telling
constexpr double kNamedPart =
    0.1;  ///< share of a combination's square that makes a kind of parameter a part of it
constexpr double kParameterPart = 0.03;  ///< the same for a single parameter
constexpr std::size_t kSegmentsMoved = 2000;

enum ParameterKind { kHeight, kPlace, kDelay, kSpeed, kReceiver, kAttenuation, kDrift, kOther, kKinds };

ParameterKind parameter_kind_of(const std::string& name) {
  const auto ends = [&name](const char* end) {
    return name.size() >= std::string(end).size() &&
           name.compare(name.size() - std::string(end).size(), std::string::npos, end) == 0;
  };
  if (name.rfind("medium/", 0) == 0) return kSpeed;
  if (name.rfind("attenuation/", 0) == 0) return kAttenuation;
  if (ends("/delay_s") || ends("/bias_s")) return kDelay;
  if (name.rfind("receiver/", 0) == 0 || name.rfind("array/", 0) == 0) return kReceiver;
  if (ends("/clock_drift")) return kDrift;
  if (name.rfind("beacon/", 0) == 0) return ends("/z_m") ? kHeight : kPlace;
  return kOther;
}

constexpr std::array<const char*, kKinds> kWords = {"heights of beacons",
                                                    "horizontal places of beacons",
                                                    "delays",
                                                    "speed of sound and overall scale",
                                                    "places of receivers",
                                                    "attenuation and time-walk",
                                                    "drift of the vehicle's clock",
                                                    "other parameters"};
constexpr std::array<const char*, kKinds> kRemedies = {
    "tape the height of one of these beacons",
    "survey one of these beacons, or hear it from another side",
    "hear these beacons from near and from far",
    "tape the distance between two beacons that are far apart, or measure the temperature",
    "measure the receivers on the vehicle, or turn it on the spot among the beacons",
    "log amplitudes, or hear the beacons from two metres and from the end of their range",
    "fire each beacon again at the end of the cycle",
    ""};
/// Of the kinds that take part, the one that is cheapest to settle by a measurement.
constexpr std::array<ParameterKind, kKinds> kCheapestFirst = {kSpeed,    kHeight,      kPlace, kDelay,
                                                              kReceiver, kAttenuation, kDrift, kOther};

std::string beacon_of(const std::string& name) {
  if (name.rfind("beacon/", 0) != 0) return {};
  return name.substr(7, name.rfind('/') - 7);
}

/// Puts a unit combination (in metres) into words.
WeakDirection in_words(const ParameterLayout& layout, const Eigen::VectorXd& v) {
  WeakDirection w;
  std::array<double, kKinds> share = {};
  std::vector<int> order(static_cast<std::size_t>(v.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&v](int a, int b) { return std::abs(v[a]) > std::abs(v[b]); });
  std::vector<std::string> beacons;
  for (const int i : order) {
    const std::string& name = layout.parameters[static_cast<std::size_t>(i)].name;
    share[parameter_kind_of(name)] += v[i] * v[i];
    if (v[i] * v[i] < kParameterPart) continue;
    w.parameters.push_back(name);
    const std::string beacon = beacon_of(name);
    if (!beacon.empty() && std::find(beacons.begin(), beacons.end(), beacon) == beacons.end())
      beacons.push_back(beacon);
  }
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < kKinds; ++k)
    if (share[k] > kNamedPart) parts.emplace_back(kWords[k]);
  w.description = fmt::format("{}{}", fmt::join(parts, " against "),
                              beacons.empty() ? "" : fmt::format(" ({})", fmt::join(beacons, ", ")));
  for (const ParameterKind kind : kCheapestFirst)
    if (w.remedy.empty() && share[kind] > kNamedPart) w.remedy = kRemedies[kind];
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
        // A measured pose does not move; what counts is how far ranges to it are then off.
        for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
          const ArrivalObservation& a = t.arrivals[i];
          const double range_m =
              a.sigma_s * a.model_speed_mps * (arrival_residual(t, a, there) - arrival_residual(t, a, here));
          squares += range_m * range_m;
          ++count;
        }
        continue;
      }
      settle(moved, segment, there, {});
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

std::vector<WeakDirection> weak_directions(const ParameterLayout& layout, const Eigen::VectorXd& x,
                                           const Covariance& C, const std::vector<bool>& usable,
                                           const std::vector<Trajectory>& trajectories,
                                           const WeakDirectionOptions& options) {
  std::vector<WeakDirection> told;
  // Metres: the speed over the typical range; what a share of the amplitude or of the absorption means in
  // metres is left open.
  Eigen::VectorXd metres = Eigen::VectorXd::Ones(layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    const std::string& name = layout.parameters[static_cast<std::size_t>(i)].name;
    const ParameterKind kind = parameter_kind_of(name);
    if (kind == kSpeed) metres[i] = options.typical_range_m;
    if (kind == kAttenuation && name != "attenuation/rise_time_s") metres[i] = 0.0;
  }
  for (std::size_t b = 0; b < usable.size(); ++b)  // told already
    for (const int column :
         {layout.beacon[b][0], layout.beacon[b][1], layout.beacon[b][2], layout.beacon_delay[b]})
      if (!usable[b] && column >= 0) metres[column] = 0.0;
  if (layout.size() == 0) return told;
  for (const auto& [variance, v] : C.largest(metres, options.most, std::pow(kTold * options.limit_m, 2))) {
    const double sigma_m = std::sqrt(variance);
    WeakDirection w = in_words(layout, v);
    w.sigma_m = sigma_m;
    // The parameters move together with all that is correlated with the combination.
    const Eigen::VectorXd step = C.times(metres.cwiseProduct(v)) / sigma_m;
    w.consequence_m = shift_at_robot_m(layout, x, x + step, trajectories);
    told.push_back(std::move(w));
  }
  return told;
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/mirror_images.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include <Eigen/Eigenvalues>

#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"
#include "calib/start/start.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Half the squares by which one of two solutions has to be better: four sigmas.
constexpr double kDecided = 8.0;
/// Threshold for ranges only: a mirror image that explains them worse by less than this is as good (see
/// trilaterate.cc, where it is kAsGood at three times the scale, with a quarter of the weight).
constexpr double kDecidedByRanges = 144.0;
/// Half of the difference of squares by which arrivals must distinguish a beacon above the receivers from one
/// below: more than kDecided, because a part of the constant errors of a pair is absorbed by the beacon's
/// position and delay.
constexpr double kDecidedByHeight = 12.0;
/// Places this many sigmas off a line are not in line; a prior beyond this share of the typical range is no
/// known place.
constexpr double kOffLineSigmas = 5.0;
constexpr double kVaguePlace = 0.25;
constexpr double kLeastSigmaM = 1e-3;  ///< sigma of a known position: the accuracy of a tape
/// Arrivals of a pair at one place that count in full.
constexpr double kMostOfOnePlace = 4.0;

/// A place in the plane that is known to sigma_m.
struct KnownPlace {
  Eigen::Vector2d p_m;
  double sigma_m = 0.0;
};

bool has_measured_pose(const Trajectory& t, const Segment& segment, std::size_t node) {
  return std::any_of(t.poses.begin() + static_cast<std::ptrdiff_t>(segment.first_pose),
                     t.poses.begin() + static_cast<std::ptrdiff_t>(segment.last_pose),
                     [node](const PoseObservation& p) { return p.node == node || p.node + 1 == node; });
}

std::vector<KnownPlace> known_places(const Problem& problem, const AdjustedLog& log) {
  const ParameterLayout& layout = log.estimate.layout;
  std::vector<KnownPlace> places;
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b) {
    const SiteBeacon& beacon = problem.site.beacons[b];
    if (!beacon.position_m[0] || !beacon.position_m[1]) continue;
    double sigma_m = 0.0;
    for (std::size_t i = 0; i < 2; ++i)
      if (const int column = layout.beacon[b][i];
          column >= 0)  // a label that was found wrong has lost its prior
        sigma_m = std::max(sigma_m, layout.parameter(column).prior_sigma);
      else
        sigma_m = std::max(sigma_m, beacon.sigma_m[i].value_or(INFINITY));
    if (sigma_m < kVaguePlace * problem.typical_range_m)
      places.push_back({{*beacon.position_m[0], *beacon.position_m[1]}, sigma_m});
  }
  for (const Trajectory& t : log.trajectories)
    for (const PoseObservation& p : t.poses)
      if (p.position_sigma_m < kVaguePlace * problem.typical_range_m)
        places.push_back({p.T_map_vehicle.translation_m.head<2>(), p.position_sigma_m});
  return places;
}

/// Line in which a map can be reflected without moving known positions.
struct Line {
  Eigen::Vector2d mean_m = Eigen::Vector2d::Zero(), normal = Eigen::Vector2d::UnitY();
  [[nodiscard]] Eigen::Vector2d image(const Eigen::Vector2d& p_m) const {
    return p_m - 2 * normal.dot(p_m - mean_m) * normal;
  }
};

std::optional<Line> line_through(const std::vector<KnownPlace>& places, double off_line_m = 0.0) {
  Line line;
  if (places.empty()) return line;
  for (const KnownPlace& place : places) line.mean_m += place.p_m / static_cast<double>(places.size());
  Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
  for (const KnownPlace& place : places)
    C += (place.p_m - line.mean_m) * (place.p_m - line.mean_m).transpose();
  line.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(C).eigenvectors().col(0);
  const bool in_line = std::ranges::all_of(places, [&](const KnownPlace& place) {
    return std::abs(line.normal.dot(place.p_m - line.mean_m)) <=
           off_line_m + kOffLineSigmas * std::max(place.sigma_m, kLeastSigmaM);
  });
  return in_line ? std::optional<Line>(line) : std::nullopt;
}

/// @param by_others, by_all  half squares by which the second of two solutions is worse
/// @param clearly, both  from which all together decide, or the others with them
Preference decided(double by_others, double by_all, double clearly, double both) {
  if (std::abs(by_all) <= clearly &&
      (by_others * by_all <= 0 || std::min(std::abs(by_others), std::abs(by_all)) <= both))
    return Preference::kNeither;
  return by_all > 0 ? Preference::kFirst : Preference::kSecond;
}

/// Odometry, or receivers that do not lie in a vertical plane by more than the noise of a range.
bool distinguishes_left_from_right(const Problem& problem, const std::vector<Trajectory>& trajectories) {
  for (const Trajectory& t : trajectories)
    if (!t.odometry.empty()) return true;
  const double noise_m =
      problem.site.noise.tof_sigma_s * (trajectories.empty() ? 0.0 : trajectories.front().nominal_speed_mps);
  for (std::size_t v = 0; v < problem.site.vehicles.size(); ++v) {
    std::vector<KnownPlace> receivers;
    for (const SiteReceiver& r : problem.site.receivers)
      if (r.vehicle.index() == v)
        receivers.push_back(
            {r.position_m.head<2>(), std::max(r.sigma_m.maxCoeff(), noise_m) / kOffLineSigmas});
    if (!line_through(receivers)) return true;
  }
  return false;
}

}  // namespace

ConsensusCost consensus_cost_of(const Problem& problem, const AdjustedLog& log, double rejection_sigmas,
                                const ArrivalWeights& weights, double early_more) {
  const SharedState state = log.estimate.state();
  const double cap = 0.5 * rejection_sigmas * rejection_sigmas;
  const auto counts = [](Rejection r) { return r != Rejection::kBeaconUnusable && r != Rejection::kNoPose; };
  ConsensusCost cost;
  cost.others = prior_cost(problem, log.estimate.layout, log.estimate.x);
  ObservationRow rows[6];
  for (std::size_t k = 0; k < log.trajectories.size(); ++k) {
    const Trajectory& t = log.trajectories[k];
    for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
      if (!counts(t.arrivals[i].rejection)) continue;
      const double r = arrival_residual(t, t.arrivals[i], state);
      cost.arrivals +=
          (weights.empty() ? 1.0 : weights[k][i]) * std::min(cap + (r < 0 ? early_more : 0.0), 0.5 * r * r);
    }
    for (std::size_t i = 0; i < t.bearings.size(); ++i)
      if (counts(t.bearings[i].rejection) && bearing_rows(t, i, state, rows) > 0)
        cost.others += std::min(cap, 0.5 * std::pow(rows[0].residual, 2));
    for (std::size_t i = 0; i < t.poses.size(); ++i)
      for (int r = pose_rows(t, i, rows); r-- > 0;)
        cost.others += std::min(cap, 0.5 * std::pow(rows[r].residual, 2));
  }
  return cost;
}

ArrivalWeights weights_by_place(const Problem& problem, const std::vector<Trajectory>& trajectories) {
  std::map<std::tuple<BeaconId, ReceiverId, Place>, double> counts;
  const auto count_of = [&](const Trajectory& t, const ArrivalObservation& a) -> double& {
    return counts[{a.beacon, a.receiver,
                   place_at(t.nodes[a.node].T_map_vehicle.translation_m, problem.typical_range_m)}];
  };
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) count_of(t, a) += 1.0;
  ArrivalWeights weights;
  for (const Trajectory& t : trajectories)
    for (std::vector<double>& of = weights.emplace_back(); const ArrivalObservation& a : t.arrivals)
      of.push_back(std::min(1.0, kMostOfOnePlace / count_of(t, a)));
  return weights;
}

Preference prefer(const ConsensusCost& first, const ConsensusCost& second, double noise) {
  const double scale = std::max(1.0, noise * noise), by_others = second.others - first.others,
               by_all = second.total() - first.total();
  return decided(by_others, by_all, scale * kDecidedByRanges, scale * kDecided);
}

Preference prefer_by_all(const Problem& problem, const AdjustedLog& first, const AdjustedLog& second,
                         double rejection_sigmas) {
  const ArrivalWeights weights = weights_by_place(problem, first.trajectories);
  const auto cost_of = [&](const AdjustedLog& of) {
    return consensus_cost_of(problem, of, rejection_sigmas, weights);
  };
  return prefer(cost_of(first), cost_of(second), agreeing_sigma(first.trajectories, first.estimate.state()));
}

double arrivals_against(const Problem& problem, const AdjustedLog& first, const AdjustedLog& second,
                        double rejection_sigmas) {
  struct Difference {
    double first = 0.0, second = 0.0;  ///< residuals
    std::pair<BeaconId, ReceiverId> pair;
    Place place;
  };
  const double cap = 0.5 * rejection_sigmas * rejection_sigmas;
  std::vector<Difference> differences;
  double against = 0.0, squares = 0.0;  // of the differences
  const SharedState of_first = first.estimate.state(), of_second = second.estimate.state();
  for (std::size_t k = 0; k < first.trajectories.size(); ++k) {
    const Trajectory &a = first.trajectories[k], &b = second.trajectories[k];
    for (std::size_t i = 0; i < a.arrivals.size(); ++i) {
      const ArrivalObservation& arrival = a.arrivals[i];
      if (arrival.rejection == Rejection::kBeaconUnusable || arrival.rejection == Rejection::kNoPose)
        continue;
      const double r = arrival_residual(a, arrival, of_first),
                   s = arrival_residual(b, b.arrivals[i], of_second);
      against += std::min(cap, 0.5 * s * s) - std::min(cap, 0.5 * r * r);
      if (std::max(std::abs(r), std::abs(s)) > rejection_sigmas) continue;
      squares += (s - r) * (s - r);
      differences.push_back(
          {r,
           s,
           {arrival.beacon, arrival.receiver},
           place_at(a.nodes[arrival.node].T_map_vehicle.translation_m, problem.typical_range_m)});
    }
  }
  // Residuals of the better solution, summed along the difference.
  double white = 0.0;
  std::map<std::pair<BeaconId, ReceiverId>, double> by_pair;
  std::map<Place, double> by_place;
  for (const Difference& d : differences) {
    const double along = (d.second - d.first) * (against < 0 ? d.second : d.first);
    white += along * along;
    by_pair[d.pair] += along;
    by_place[d.place] += along;
  }
  const auto variance = [](const auto& sums) {
    double sum = 0.0;
    for (const auto& [key, along] : sums) sum += along * along;
    return sum;
  };
  return against * squares / std::max({squares, white, variance(by_pair), variance(by_place), 1e-300});
}

bool is_across_receivers(const Problem& problem, const Eigen::Vector3d& p_m, const Eigen::Vector3d& image_m) {
  const Eigen::Vector3d apart_m = image_m - p_m;
  return problem.site.motion == Motion::kPlanar && apart_m.head<2>().norm() < 0.5 * std::abs(apart_m.z());
}

Preference prefer_height(const Problem& problem, const AdjustedLog& first, const AdjustedLog& second,
                         double rejection_sigmas) {
  const auto others_of = [&](const AdjustedLog& of) {
    return consensus_cost_of(problem, of, rejection_sigmas).others;
  };
  const double by_others = others_of(second) - others_of(first),
               by_all = by_others + arrivals_against(problem, first, second, rejection_sigmas);
  return decided(by_others, by_all, kDecidedByHeight, kDecided);
}

std::optional<Eigen::Vector3d> image_across_receivers(const Problem& problem, const Estimate& estimate,
                                                      std::size_t beacon) {
  const int column = estimate.layout.beacon[beacon][2];
  if (problem.site.motion != Motion::kPlanar || column < 0 || problem.site.receivers.empty())
    return std::nullopt;
  const SharedState state = estimate.state();
  double receivers_m = 0.0;
  for (const Eigen::Vector3d& p : state.receiver_p_vehicle_m)
    receivers_m += p.z() / static_cast<double>(state.receiver_p_vehicle_m.size());
  Eigen::Vector3d image = state.beacon_p_map_m[beacon];
  image.z() = 2 * receivers_m - image.z();
  const Parameter& height = estimate.layout.parameter(column);
  const auto half_squares = [&](double z) {
    return 0.5 * std::pow((z - height.prior_mean) / height.prior_sigma, 2);
  };
  const bool is_told = !std::isfinite(height.prior_sigma) ||
                       half_squares(image.z()) - half_squares(estimate.x[column]) > kDecided;
  if (is_told || std::abs(image.z() - estimate.x[column]) < tolerance_m(problem)) return std::nullopt;
  return image;
}

bool is_known_in_line(const Problem& problem, const AdjustedLog& log) {
  const std::vector<KnownPlace> places = known_places(problem, log);
  return problem.site.motion == Motion::kPlanar && places.size() >= 2 && line_through(places) &&
         !distinguishes_left_from_right(problem, log.trajectories);
}

bool reflect_site(const Problem& problem, AdjustedLog& log, double off_line_m) {
  const ParameterLayout& layout = log.estimate.layout;
  const bool all_fixed = std::ranges::all_of(
      layout.beacon, [](const auto& columns) { return std::max(columns[0], columns[1]) < 0; });
  if (problem.site.motion != Motion::kPlanar || all_fixed ||
      distinguishes_left_from_right(problem, log.trajectories))
    return false;
  const std::optional<Line> line = line_through(known_places(problem, log), off_line_m);
  if (!line) return false;
  const SharedState state = log.estimate.state();
  for (std::size_t b = 0; b < layout.beacon.size(); ++b) {
    Eigen::Vector3d image = state.beacon_p_map_m[b];
    image.head<2>() = line->image(image.head<2>());
    layout.set_place(b, image, log.estimate.x);
  }
  const double axis_rad = std::atan2(-line->normal.x(), line->normal.y());
  for (Trajectory& t : log.trajectories)
    for (const Segment& segment : t.segments)
      for (std::size_t k = segment.first_node; k < segment.last_node; ++k) {
        Node& node = t.nodes[k];
        if (!node.placed || has_measured_pose(t, segment, k)) continue;
        const Eigen::Vector2d image = line->image(node.T_map_vehicle.translation_m.head<2>());
        node.T_map_vehicle =
            Pose::planar(image.x(), image.y(), wrap_angle(2 * axis_rad - node.T_map_vehicle.heading_rad()));
        const Eigen::Vector2d way = node.velocity.head<2>();
        node.velocity.head<2>() = way - 2 * line->normal.dot(way) * line->normal;
        node.velocity.z() = -node.velocity.z();
      }
  return true;
}

bool reflect_beacons(const Problem& problem, AdjustedLog& log, double sigma_m) {
  constexpr double kFlatSigmas = 3.0;
  const Estimate& estimate = log.estimate;
  const SharedState state = estimate.state();
  const double off_plane_m = kFlatSigmas * sigma_m * std::max(1.0, agreeing_sigma(log.trajectories, state));
  Eigen::VectorXd x = estimate.x;
  std::size_t images = 0;
  for (std::size_t b = 0; b < estimate.beacon_usable.size(); ++b) {
    if (!estimate.beacon_usable[b] || *std::ranges::max_element(estimate.layout.beacon[b]) < 0) continue;
    const auto image = mirror_image(problem, state, log.trajectories, b, off_plane_m);
    if (!image) continue;
    estimate.layout.set_place(b, *image, x);
    ++images;
  }
  if (images < 2) return false;
  log.estimate.x = std::move(x);
  return true;
}

}  // namespace octant::calib

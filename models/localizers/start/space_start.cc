// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/space_start.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "models/localizers/least_squares/spatial_start.h"
#include "models/localizers/start/rigid_path.h"
#include "models/localizers/start/rigid_piece.h"
#include "models/localizers/start/stretch_states.h"
#include "models/physics/plane.h"
#include "models/support/observed.h"

namespace octant {
namespace {

constexpr double kClearMargin = 8.0;  ///< cost difference to any other pose
/// Sigmas up to which linearisation is safe: of the attitude, and of the position relative to the ranges.
/// Among roughly known beacons only odometry follows, and everything is adjusted jointly afterwards.
constexpr double kMostAngleRad = 0.25, kMostShare = 0.05, kMostRoughAngleRad = 0.1, kMostRoughShare = 0.02;

struct Placing {
  Pose T_map_anchor;
  double cost = 0.0;
  Matrix6 information = Matrix6::Zero();
};

/// Positions of the middle of a piece, within its size, from small random samples of the arrivals (random
/// sample consensus, Fischler and Bolles 1981), because a single echo spoils a solution by squares of ranges.
std::vector<Eigen::Vector3d> likely_places(const SearchProblem& problem, const Eigen::Vector3d& middle_m) {
  constexpr std::size_t kSamples = 40, kOfSample = 10, kKept = 4;
  double size2 = square(problem.median_sigma_m + problem.uncertainty_m);
  for (const SearchRange& r : problem.ranges)
    size2 += (r.p_lever_m - middle_m).squaredNorm() / static_cast<double>(problem.ranges.size());
  const double cap = std::max(2.0, std::log(problem.span_m / std::sqrt(size2)));
  const auto cost = [&](const Eigen::Vector3d& p) {
    double sum = 0.0;
    for (const SearchRange& r : problem.ranges)
      sum += std::min(0.5 * square(r.range_m - (p - r.p_beacon_map_m).norm()) / size2, cap);
    return sum;
  };
  std::vector<std::pair<double, Eigen::Vector3d>> found;
  SearchProblem sample;
  std::uint32_t draw = 1;  // deterministic for given ranges
  for (std::size_t k = 0; k < kSamples; ++k) {
    sample.ranges.clear();
    for (std::size_t i = 0; i < kOfSample; ++i) {
      draw = draw * 1664525U + 1013904223U;
      sample.ranges.push_back(problem.ranges[(draw >> 8U) % problem.ranges.size()]);
    }
    const LinearPositions positions = linear_positions(sample);
    for (std::size_t i = 0; i < positions.count; ++i)
      if (positions.p_map_m[i].allFinite())
        found.emplace_back(cost(positions.p_map_m[i]), positions.p_map_m[i]);
  }
  std::ranges::sort(found, [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::Vector3d> places;
  for (const auto& [cost_of_pose, p] : found)
    if (places.size() < kKept && std::ranges::all_of(places, [&, &at = p](const auto& other) {
          return (at - other).squaredNorm() > size2;
        }))
      places.push_back(p);
  return places;
}

/// A pose close to a solution, and the corresponding offsets of the beacons.
struct Basin {
  Pose T_map_anchor;
  double cost = 0.0;
  std::vector<Eigen::Vector3d> beacons_off_m = {};
};

/// Keeps the best of similar ones, best first.
template <class Found>
std::vector<Found> distinct(std::vector<Found> found, double apart_m) {
  std::ranges::sort(found, {}, &Found::cost);
  std::vector<Found> kept;
  for (Found& one : found)
    if (std::ranges::all_of(
            kept, [&](const Found& other) { return differs(other.T_map_anchor, one.T_map_anchor, apart_m); }))
      kept.push_back(std::move(one));
  return kept;
}

/// Solutions under the wide loss from all likely positions and a coarse set of attitudes.
std::vector<Basin> basins(const SearchProblem& problem, RigidPiece& piece, double apart_m) {
  constexpr double kNearEnough = 1e-3;
  const Eigen::Vector3d middle_m = piece.middle_m();
  std::vector<Basin> found;
  for (const Eigen::Vector3d& place : likely_places(problem, middle_m))
    for (const Eigen::Quaterniond& q : coarse_rotations()) {
      Basin basin{.T_map_anchor = {place - q * middle_m, q}};
      piece.begin();
      piece.solve_pose(basin.T_map_anchor, kWidePiece, 15, kNearEnough);
      basin.cost = piece.score();
      basin.beacons_off_m = piece.beacons_off_m();
      if (std::isfinite(basin.cost)) found.push_back(std::move(basin));
    }
  return distinct(std::move(found), apart_m);
}

/// Distinct poses, best first.
std::vector<Placing> search(const SearchProblem& problem, double uncertainty_m, double apart_m) {
  RigidPiece piece(problem, uncertainty_m);
  std::vector<Placing> found;
  for (const Basin& basin : basins(problem, piece, apart_m)) {
    Placing p{.T_map_anchor = basin.T_map_anchor};
    piece.go_on(basin.beacons_off_m);
    piece.solve_pose(p.T_map_anchor, kNarrowPiece, 20);
    p.information = piece.information();
    p.cost = piece.score();
    if (std::isfinite(p.cost)) found.push_back(p);
  }
  return distinct(std::move(found), apart_m);
}

bool is_tight(const Placing& p, const SearchProblem& problem) {
  const ObservedState<Matrix6> observed(p.information);
  if (!observed.all()) return false;
  const Matrix6 P = observed.covariance();
  const bool rough = problem.uncertainty_m > 0;
  // Among roughly known beacons the accuracy is limited by the common error of the beacons, for pieces of any
  // length.
  const double most_m = rough ? std::max(kMostRoughShare * problem.span_m, 1.2 * problem.uncertainty_m)
                              : std::max(kMostShare * problem.span_m, 2 * problem.median_sigma_m);
  return P.topLeftCorner<3, 3>().trace() < square(most_m) &&
         P.bottomRightCorner<3, 3>().trace() < square(rough ? kMostRoughAngleRad : kMostAngleRad);
}

/// Returns true if one path is the mirror image of the other in the plane of the beacons.
bool are_images(const SearchProblem& problem, const RigidPath& path, const Pose& a, const Pose& b,
                double within_m) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const auto groups = static_cast<double>(problem.groups());
  const auto beacon = [&](std::size_t group) -> const Eigen::Vector3d& {
    return problem.ranges[problem.group_first[group]].p_beacon_map_m;
  };
  for (std::size_t g = 0; g < problem.groups(); ++g) centre += beacon(g) / groups;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t g = 0; g < problem.groups(); ++g)
    spread += (beacon(g) - centre) * (beacon(g) - centre).transpose() / groups;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (std::abs(normal.z()) < 0.7)
    return false;  // for a steep plane the distance from the floor does not distinguish them
  return std::ranges::all_of(path.T_anchor_node, [&](const Pose& T) {
    const Eigen::Vector3d p = a * T.translation_m, q = b * T.translation_m;
    return (p - 2 * normal.dot(p - centre) * normal - q).norm() < within_m;
  });
}

double lowest_m(const RigidPath& path, const Pose& T_map_anchor) {
  double lowest = INFINITY;
  for (const Pose& T : path.T_anchor_node) lowest = std::min(lowest, (T_map_anchor * T.translation_m).z());
  return lowest;
}

/// Returns true if the first of two images is the one to keep: the lower one above the floor.
bool is_below(const RigidPath& path, const Placing& a, const Placing& b, double scale_m) {
  const double a_m = lowest_m(path, a.T_map_anchor), b_m = lowest_m(path, b.T_map_anchor);
  const double below_m = 0.1 * std::abs(a_m - b_m) + 3 * scale_m;  // above the floor within errors
  return std::min(a_m, b_m) >= -below_m ? a_m < b_m : a_m > b_m;
}

/// Keeps one pose of each pair of mirror images.
void leave_one_image(const SearchProblem& problem, const RigidPath& path, double scale_m,
                     std::vector<Placing>& found) {
  const double within_m = std::max(10 * scale_m, 0.03 * problem.span_m);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = i + 1; k < found.size(); ++k) {
      if (!are_images(problem, path, found[i].T_map_anchor, found[k].T_map_anchor, within_m)) continue;
      if (!is_below(path, found[i], found[k], scale_m)) std::swap(found[i], found[k]);
      found.erase(found.begin() + static_cast<std::ptrdiff_t>(k));
      break;
    }
}

}  // namespace

std::vector<LikelyPose> likely_poses(const Trajectory& t, const Segment& stretch, const EpochFixModel& model,
                                     const TrackerOptions& options, const RigidPath& path, double margin) {
  SearchProblem problem = make_search_problem(t, stretch, model, options.range_uncertainty_m, path);
  if (problem.ranges.size() < kFewestRangesOfPiece || problem.groups() < kFewestBeaconsOfPiece) return {};
  thin_out(problem);
  const double scale_m = std::hypot(problem.median_sigma_m, options.range_uncertainty_m);
  std::vector<Placing> found = search(problem, options.range_uncertainty_m, 10 * scale_m);
  if (found.empty()) return {};
  const double most = std::min(found.front().cost + margin,
                               kMostMeanCostOfPiece * static_cast<double>(problem.ranges.size()));
  std::erase_if(found, [most](const Placing& p) { return p.cost > most; });
  leave_one_image(problem, path, scale_m, found);
  std::vector<LikelyPose> likely;
  for (const Placing& p : found) likely.push_back({p.T_map_anchor, p.cost, is_tight(p, problem)});
  return likely;
}

bool place_stretch_in_space(Trajectory& t, const Segment& stretch, const EpochFixModel& model,
                            const TrackerOptions& options) {
  const std::size_t anchor = stretch.first_node + (stretch.last_node - stretch.first_node) / 2;
  const RigidPath path = rigid_path(t, stretch, anchor);
  const std::vector<LikelyPose> likely = likely_poses(t, stretch, model, options, path, kClearMargin);
  if (likely.size() != 1 || !likely.front().tight) return false;
  lay_stretch(t, stretch, model, 0.0, likely.front().T_map_anchor, path);
  return true;
}

}  // namespace octant

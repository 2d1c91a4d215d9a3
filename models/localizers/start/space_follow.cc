// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/space_follow.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/start/rigid_path.h"
#include "models/localizers/start/rigid_piece.h"
#include "models/physics/plane.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/stretches.h"

namespace octant {
namespace {

/// Sigmas of the drift of odometry between two nodes, in position and attitude.
struct OdometryDrift {
  double place_m = 0.0, attitude_rad = 0.0;
};

OdometryDrift drift_between(const Trajectory& t, const Segment& segment, std::size_t a, std::size_t b) {
  double distance = 0.0, turn = 0.0;
  for (std::size_t k = std::min(a, b); k < std::max(a, b); ++k) {
    const OdometryObservation& o = t.odometry[segment.first_odometry + k - segment.first_node];
    distance += square(o.distance_sigma_m);
    turn += square(o.heading_sigma_rad);
  }
  const double way_m =
      (t.nodes[b].T_map_vehicle.translation_m - t.nodes[a].T_map_vehicle.translation_m).norm();
  return {std::sqrt(distance + turn * square(way_m) / 3), std::sqrt(turn)};
}

constexpr double kRoughAngleRad = 0.1;  ///< sigma of the attitude of a piece among beacons with errors

/// Result of solving a piece at its pose from odometry.
struct SolvedPiece {
  bool heard = false, agrees = false;  ///< heard is false if there are too few arrivals
  double cost = 0.0;
};

/// Solves the pose of a piece, starting from odometry.
/// @param drift  since the middle of the previous solved piece
SolvedPiece solve_roughly(Trajectory& t, const Segment& piece, const EpochFixModel& model,
                          double uncertainty_m, std::size_t middle, const OdometryDrift& drift) {
  const RigidPath path = rigid_path(t, piece, middle);
  SearchProblem problem = make_search_problem(t, piece, model, uncertainty_m, path);
  if (problem.ranges.size() < kFewestRangesOfPiece || problem.groups() < kFewestBeaconsOfPiece) return {};
  thin_out(problem);
  RigidPiece rigid(problem, uncertainty_m);
  Pose T = t.nodes[middle].T_map_vehicle;
  Vector6 sigma;
  sigma.head<3>().setConstant(std::hypot(uncertainty_m, drift.place_m));
  sigma.tail<3>().setConstant(std::hypot(kRoughAngleRad, drift.attitude_rad));
  rigid.expect(T, sigma);
  rigid.solve_pose(T, kWidePiece, 15);
  rigid.solve_pose(T, kNarrowPiece, 20);
  SolvedPiece solved{.heard = true, .cost = rigid.score()};
  solved.agrees = solved.cost <= kMostMeanCostOfPiece * static_cast<double>(problem.ranges.size());
  if (solved.agrees) lay_rigidly(t, piece, T, path);
  return solved;
}

}  // namespace

RoughPieces follow_roughly(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                           const TrackerOptions& options, std::size_t node, bool forward) {
  constexpr double kPiece_s = 8.0;
  constexpr int kMostInDoubt = 2;  // consecutive pieces
  RoughPieces pieces;
  std::size_t last_solved = node;
  for (int in_doubt = 0; forward ? node + 1 < segment.last_node : node > segment.first_node;) {
    const std::size_t reached = follow_odometry(t, segment, node, forward, kPiece_s);
    const Segment piece = stretch_of(t, segment, std::min(node, reached), std::max(node, reached) + 1);
    const std::size_t middle = piece.first_node + (piece.last_node - piece.first_node) / 2;
    const SolvedPiece solved = solve_roughly(t, piece, model, options.range_uncertainty_m, middle,
                                             drift_between(t, segment, last_solved, middle));
    node = reached;
    if (!solved.heard) continue;
    pieces.cost += solved.cost;
    in_doubt = solved.agrees ? 0 : in_doubt + 1;
    if (solved.agrees) {
      last_solved = middle;
      pieces.poses.push_back(rough_pose(t, middle, options.range_uncertainty_m));
    }
    if (forward && in_doubt == kMostInDoubt) break;
  }
  pieces.reached = node;
  return pieces;
}

PoseObservation rough_pose(const Trajectory& t, std::size_t node, double uncertainty_m) {
  return {.node = node,
          .T_map_vehicle = t.nodes[node].T_map_vehicle,
          .position_sigma_m = uncertainty_m,
          .heading_sigma_rad = kRoughAngleRad,
          .attitude_sigma_rad = kRoughAngleRad};
}

void join_pieces(Trajectory& t, const Segment& segment, const SharedState& state,
                 const std::vector<PoseObservation>& pieces, int threads) {
  const std::size_t before = t.poses.size();
  t.poses.insert(t.poses.end(), pieces.begin(), pieces.end());
  std::sort(t.poses.begin() + static_cast<std::ptrdiff_t>(before), t.poses.end(),
            [](const PoseObservation& a, const PoseObservation& b) { return a.node < b.node; });
  Segment unheard = segment;
  unheard.last_arrival = unheard.first_arrival;
  unheard.last_bearing = unheard.first_bearing;
  unheard.first_pose = before;
  unheard.last_pose = t.poses.size();
  solve_states(t, unheard, state, RobustLoss{},
               {.max_iterations = 20, .tolerance = 1e-6, .threads = threads});
  t.poses.resize(before);
}

}  // namespace octant

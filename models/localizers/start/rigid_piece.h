// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/least_squares/search_problem.h"
#include "models/physics/pose.h"
#include "models/trajectory/trajectory.h"

namespace octant {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Losses for solving a piece: far from the solution, and close to it.
inline constexpr RobustLoss kWidePiece{.late_scale = 30.0, .early_scale = 60.0},
    kNarrowPiece{.late_scale = 2.5, .early_scale = 4.0};
inline constexpr std::size_t kFewestRangesOfPiece = 12, kFewestBeaconsOfPiece = 3;
inline constexpr double kMostMeanCostOfPiece = 2.0;  ///< mean cost of an arrival: 0.5 for a perfect fit

/// A part of the odometry as a rigid body, with its arrivals. With roughly known beacons each beacon has an
/// unknown offset, which is eliminated (Schur complement). Errors common to its arrivals then do not average
/// out, and a height is not better determined than the beacons' own heights.
class RigidPiece {
 public:
  /// @param problem  must outlive this object. @param uncertainty_m  sigma of each coordinate of a beacon; 0:
  /// exactly known
  RigidPiece(const SearchProblem& problem, double uncertainty_m);

  /// Adds a prior of the pose; tangents as for Motion::kSpatial.
  void expect(const Pose& T, const Vector6& sigma);
  /// Resets the beacons to their nominal positions.
  void begin();
  /// Levenberg-Marquardt iteration on pose and beacons, until a step decreases the cost by less than the
  /// given share.
  void solve_pose(Pose& T, const RobustLoss& loss, int iterations, double tolerance = 1e-6);
  /// Offsets of the beacons from their nominal positions after the last solution; can be set to continue from
  /// another solution.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& beacons_off_m() const { return at_.off_m; }
  void go_on(const std::vector<Eigen::Vector3d>& beacons_off_m) { at_.off_m = beacons_off_m; }
  /// Negative log likelihood, up to a constant, of a mixture of direct, late and early arrivals: the cost of
  /// an outlier does not depend on its size (see consensus.h for the caps).
  [[nodiscard]] double score() const;
  /// Gauss-Newton matrix of the pose at the last solution.
  [[nodiscard]] const Matrix6& information() const { return H_; }
  [[nodiscard]] Eigen::Vector3d middle_m() const;

 private:
  struct State {
    Pose T;
    std::vector<Eigen::Vector3d> off_m;  ///< offset of each beacon from its nominal position
  };
  /// Normal equations of the pose, and for each beacon the terms of its offset: off = -A^-1 (b + B' step).
  struct PieceNormal {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    double cost = 0.0;
    std::vector<Eigen::Matrix3d> A_inverse;
    std::vector<Eigen::Matrix<double, 6, 3>> B;
    std::vector<Eigen::Vector3d> b;
  };

  template <class Visit>
  void for_each_range(Visit&& visit) const;
  [[nodiscard]] PieceNormal build(const State& at, const RobustLoss& loss) const;
  [[nodiscard]] State moved(const Vector6& step, const PieceNormal& by) const;

  const SearchProblem& problem_;
  double prior_;  ///< information of each coordinate of a beacon; 0: exactly known
  std::vector<double> weight_;
  State at_;
  Matrix6 H_ = Matrix6::Zero();
  Pose T_expected_;
  Vector6 expected_ = Vector6::Zero();  ///< information of the prior
};

}  // namespace octant

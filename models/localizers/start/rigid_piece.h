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

/// Losses under which a piece is solved: from afar, and to the end.
inline constexpr RobustLoss kWidePiece{.late_scale = 30.0, .early_scale = 60.0},
    kNarrowPiece{.late_scale = 2.5, .early_scale = 4.0};
inline constexpr std::size_t kFewestRangesOfPiece = 12, kFewestBeaconsOfPiece = 3;
inline constexpr double kMostMeanCostOfPiece = 2.0;  ///< of an arrival: 0.5 where all is well

/// A stretch of odometry that moves as one, and what is heard along it. With uncertainty each beacon is off
/// by an unknown of its own, which is eliminated (Schur complement): what all its arrivals share does not
/// average out, and a height is told no better than the beacons' own are.
class RigidPiece {
 public:
  /// @param problem  outlives it. @param uncertainty_m  sigma of each coordinate of a beacon; 0: they are
  /// known
  RigidPiece(const SearchProblem& problem, double uncertainty_m);

  /// The pose is expected there; tangents as Motion::kSpatial has them.
  void expect(const Pose& T, const Vector6& sigma);
  /// Beacons are where they are said to be.
  void begin();
  /// Levenberg-Marquardt on pose and beacons together, until a step gains less than this share of the cost.
  void solve_pose(Pose& T, const RobustLoss& loss, int iterations, double tolerance = 1e-6);
  /// Where the beacons are by the last of it, from where they are said to be; and to go on from there.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& beacons_off_m() const { return at_.off_m; }
  void go_on(const std::vector<Eigen::Vector3d>& beacons_off_m) { at_.off_m = beacons_off_m; }
  /// Negative log likelihood up to a constant of a mixture of what came straight, late and early: an outlier
  /// costs the same however far off it is (consensus.h has the caps).
  [[nodiscard]] double score() const;
  /// Gauss-Newton matrix of the pose where it was last solved.
  [[nodiscard]] const Matrix6& information() const { return H_; }
  [[nodiscard]] Eigen::Vector3d middle_m() const;

 private:
  struct State {
    Pose T;
    std::vector<Eigen::Vector3d> off_m;  ///< of each beacon from where it is said to be
  };
  /// Normal equations of the pose, and of each beacon what it takes to follow: off = -A^-1 (b + B' step).
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
  double prior_;  ///< information of each coordinate of a beacon; 0: they are known
  std::vector<double> weight_;
  State at_;
  Matrix6 H_ = Matrix6::Zero();
  Pose T_expected_;
  Vector6 expected_ = Vector6::Zero();  ///< information of it
};

}  // namespace octant

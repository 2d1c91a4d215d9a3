// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <boost/math/distributions/chi_squared.hpp>

#include "models/localizers/chain/chain_windows.h"
#include "models/support/observed.h"
#include "models/support/parallel.h"
#include "models/support/unit_diagonal.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

double chi_square_p(double sum_of_squares, double degrees_of_freedom) {
  if (!(degrees_of_freedom > 0)) return 1.0;
  const boost::math::chi_squared distribution(degrees_of_freedom);
  const double below = boost::math::cdf(distribution, std::max(0.0, sum_of_squares));
  const double above = boost::math::cdf(boost::math::complement(distribution, std::max(0.0, sum_of_squares)));
  return std::min(1.0, 2 * std::min(below, above));
}

void ObservationCounts::add(const ObservationCounts& other) {
  used += other.used;
  rejected += other.rejected;
  observations += other.observations;
  states += other.states;
  squares_s2 += other.squares_s2;
}

namespace {

/// A heading with a sigma of more than a whole turn is not determined: it needs no redundancy.
constexpr double kBlindRad = 2 * std::numbers::pi;

/// Returns true if a measured pose includes all angles.
bool is_complete(const Trajectory& t, const PoseObservation& p) {
  return std::isfinite(p.position_sigma_m) && p.heading_sigma_rad < kBlindRad &&
         (t.motion == Motion::kPlanar || p.attitude_sigma_rad < kBlindRad);
}

/// Returns true if a state may have unobservable directions: it is separate, has one receiver or few
/// arrivals, and no bearings.
bool may_be_blind(const Trajectory& t, const Segment& s) {
  if (s.last_node - s.first_node != 1 || t.motion_prior) return false;
  if (!t.has_cycle_offset && std::any_of(t.poses.begin() + static_cast<std::ptrdiff_t>(s.first_pose),
                                         t.poses.begin() + static_cast<std::ptrdiff_t>(s.last_pose),
                                         [&t](const PoseObservation& p) { return is_complete(t, p); }))
    return false;
  std::size_t used = 0;
  ReceiverId first;
  bool several = false;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    if (used++ == 0) first = a.receiver;
    several = several || a.receiver != first;
  }
  return !several || used < static_cast<std::size_t>(t.block_size());
}

std::size_t rank_of(const Eigen::MatrixXd& A) {
  if (A.rows() == 0) return 0;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                                     UnitDiagonal<Eigen::MatrixXd>(A).scaled, Eigen::EigenvaluesOnly)
                                     .eigenvalues();
  return static_cast<std::size_t>((values.array() > kUnobserved).count());
}

/// Number of observed directions of a separate state. Angles are counted by the information that remains when
/// everything else is free.
std::size_t observed_directions(const Trajectory& t, const Segment& segment, const SharedState& state) {
  ChainSystem system;
  build_chain_system(t, segment, state, RobustLoss{}, system);
  const Eigen::MatrixXd D = system.D.front();
  const Eigen::Index first = first_turn(t.motion), count = pose_dof(t.motion) - first, size = D.rows();
  std::vector<Eigen::Index> angles, others;
  for (Eigen::Index i = 0; i < size; ++i) (i >= first && i < first + count ? angles : others).push_back(i);
  const Eigen::MatrixXd open = D(others, others);
  const Eigen::MatrixXd angular =
      D(angles, angles) -
      D(angles, others) *
          Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(open).solve(D(others, angles));
  const Eigen::VectorXd information =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(angular, Eigen::EigenvaluesOnly).eigenvalues();
  return rank_of(open) +
         static_cast<std::size_t>((information.array() > 1.0 / (kBlindRad * kBlindRad)).count());
}

/// Part of an observation that its states absorb.
double leverage_of(const ObservationRow& row, const ChainWindow& window, std::size_t node) {
  double leverage = row.by_node.dot(window.marginal[node] * row.by_node.transpose());
  if (row.has_next)
    leverage += 2 * row.by_node.dot(window.cross[node] * row.by_next.transpose()) +
                row.by_next.dot(window.marginal[node + 1] * row.by_next.transpose());
  return leverage;
}

PoseSquares squares_of_poses(const Trajectory& t, const Segment& segment, const SharedState& state) {
  PoseSquares of_all;
  // Windows come from the end.
  std::size_t pose = segment.last_pose, step = segment.last_odometry, bearing = segment.last_bearing;
  ChainVariant chain;
  chain.visit = [&](const ChainWindow& window) {
    ObservationRow rows[6];
    const auto add = [&](std::size_t node, int count, double& squares, double& redundancy) {
      for (const ObservationRow& row : std::span(rows, static_cast<std::size_t>(count))) {
        squares += row.residual * row.residual;
        redundancy += 1.0 - leverage_of(row, window, node - window.first_node);
      }
    };
    for (; pose > segment.first_pose && t.poses[pose - 1].node >= window.first_node; --pose)
      add(t.poses[pose - 1].node, pose_rows(t, pose - 1, rows), of_all.squares, of_all.redundancy);
    for (; step > segment.first_odometry && t.odometry[step - 1].node >= window.first_node; --step)
      add(t.odometry[step - 1].node, odometry_rows(t, step - 1, rows), of_all.other_squares,
          of_all.other_redundancy);
    for (; bearing > segment.first_bearing && t.bearings[bearing - 1].node >= window.first_node; --bearing)
      if (t.bearings[bearing - 1].rejection == Rejection::kUsed)
        add(t.bearings[bearing - 1].node, bearing_rows(t, bearing - 1, state, rows), of_all.other_squares,
            of_all.other_redundancy);
  };
  const bool is_determined = solve_by_windows(t, segment, state, {&chain, 1}).front();
  return is_determined ? of_all : PoseSquares{};
}

}  // namespace

PoseSquares squares_of_poses(const Trajectory& t, const SharedState& state) {
  PoseSquares of_all;
  for (const Segment& segment : t.segments)
    if (t.nodes[segment.first_node].placed &&
        (segment.last_pose > segment.first_pose || segment.last_bearing > segment.first_bearing))
      of_all.add(squares_of_poses(t, segment, state));
  return of_all;
}

ObservationCounts count_observations(const Trajectory& t, const SharedState& state, int threads,
                                     bool residuals) {
  ObservationCounts counts;
  counts.rejected = t.stateless_arrivals.size();
  std::vector<ObservationCounts> parts(
      chunk_count(t.arrivals.size(), kArrivalsAtOnce));  // added up in their order
  for_each_chunk(t.arrivals.size(), kArrivalsAtOnce, threads,
                 [&](std::size_t chunk, std::size_t first, std::size_t last) {
                   ObservationCounts& part = parts[chunk];
                   std::size_t amplitudes = 0;
                   ArrivalResiduals residual_of(t, state);
                   for (std::size_t i = first; i < last; ++i) {
                     const ArrivalObservation& a = t.arrivals[i];
                     if (a.rejection != Rejection::kUsed) {
                       ++part.rejected;
                       continue;
                     }
                     ++part.used;
                     amplitudes += a.log_amplitude_sigma > 0 && state.attenuation ? 1 : 0;
                     if (residuals) part.squares_s2 += std::pow(a.sigma_s * residual_of(a), 2);
                   }
                   part.observations = static_cast<double>(part.used + amplitudes);
                 });
  for (const ObservationCounts& part : parts) counts.add(part);
  ObservationRow rows[6];
  for (std::size_t i = 0; i < t.bearings.size(); ++i)
    if (t.bearings[i].rejection == Rejection::kUsed) counts.observations += bearing_rows(t, i, state, rows);
  for (const Segment& segment : t.segments) {
    if (!t.nodes[segment.first_node].placed) continue;
    counts.states += may_be_blind(t, segment) ? observed_directions(t, segment, state)
                                              : (segment.last_node - segment.first_node) *
                                                    static_cast<std::size_t>(t.block_size());
    for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i)
      counts.observations += pose_rows(t, i, rows);
    for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i)
      counts.observations += odometry_rows(t, i, rows);
    for (std::size_t i = segment.first_motion; i < segment.last_motion; ++i)
      counts.observations += motion_rows(t, i, rows);
  }
  return counts;
}

CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout,
                                    ObservationCounts counts, double cost) {
  CalibrationStatistics s;
  for (const MeasurementLog& run : problem.runs) counts.rejected += run.rejected.size();
  for (const Parameter& p : layout.parameters)
    counts.observations += std::isfinite(p.prior_sigma) ? 1.0 : 0.0;
  if (layout.joint_prior) counts.observations += static_cast<double>(layout.joint_prior->mean.size());
  counts.observations +=
      static_cast<double>(problem.site.distances.size() + problem.beacon_ranges.pairs.size());
  s.arrivals = counts.used;
  s.rejected = counts.rejected;
  s.unknowns = static_cast<std::size_t>(layout.size()) + counts.states;
  s.redundancy = counts.observations - static_cast<double>(s.unknowns);
  s.variance_factor =
      // A cost of zero may be negative by rounding
      s.redundancy > 0 ? 2 * std::max(0.0, cost) / s.redundancy : 1.0;
  s.chi2_p = chi_square_p(2 * cost, s.redundancy);
  s.rms_s = s.arrivals > 0 ? std::sqrt(counts.squares_s2 / static_cast<double>(s.arrivals)) : 0.0;
  return s;
}

CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout,
                                    const std::vector<Trajectory>& trajectories, const SharedState& state,
                                    double cost, int threads) {
  ObservationCounts counts;
  for (const Trajectory& t : trajectories) counts.add(count_observations(t, state, threads));
  return statistics_of(problem, layout, counts, cost);
}

NoiseFactors NoiseSearch::step(const DataSquares& data) {
  constexpr double kFewest = 30.0, kSigmas = 4.0, kLeast = 0.1;
  const PoseSquares& poses = data.poses;
  // Odometry and bearings that are better or worse than stated say nothing about the arrivals.
  const double data_squares = 2 * data.cost - poses.other_squares,
               data_redundancy = data.redundancy - poses.other_redundancy;
  const double redundancy = data_redundancy - poses.redundancy, squares = data_squares - poses.squares;
  const bool are_better = poses.redundancy >= kFewest && redundancy >= kFewest && squares > 0 &&
                          poses.squares / poses.redundancy < 1 - kSigmas * std::sqrt(2 / poses.redundancy);
  if (!are_better) return {.arrivals = step_of_arrivals(0.5 * data_squares, data_redundancy)};
  variance_before_.reset();  // belongs to another weight of the poses
  NoiseFactors factors{std::sqrt(squares / redundancy),
                       std::max(kLeast, std::sqrt(poses.squares / poses.redundancy))};
  factor_ *= factors.arrivals;
  return factors;
}

double NoiseSearch::step_of_arrivals(double data_cost, double redundancy) {
  // Smaller factors may be significant but are irrelevant for any sigma
  constexpr double kNoiseMatters = 0.02;
  constexpr double kApart = 0.05, kLongest = 6.0;
  const double variance = 2 * data_cost / redundancy;
  if (!(redundancy >= 30) || !(data_cost > 0) || chi_square_p(2 * data_cost, redundancy) > 0.01) return 1.0;
  const double plain = std::sqrt(variance);
  if (std::abs(plain - 1) < kNoiseMatters) return 1.0;
  double multiply = plain;
  const double weight = 1 / (factor_ * factor_), weight_before = 1 / (before_ * before_);
  if (variance_before_ && std::abs(weight - weight_before) > kApart * weight) {
    const double b = (variance - *variance_before_) / (weight - weight_before), a = variance - b * weight;
    // Never less than the plain step, because a is positive, and not far beyond the two points.
    const double farthest = std::pow(plain, kLongest);
    if (b > 0 && a < 1)
      multiply =
          std::clamp(std::sqrt(b * weight / (1 - a)), std::min(plain, farthest), std::max(plain, farthest));
  }
  variance_before_ = variance;
  before_ = std::exchange(factor_, factor_ * multiply);
  return multiply;
}

}  // namespace octant::calib

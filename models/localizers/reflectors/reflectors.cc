// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/reflectors/reflectors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "models/physics/plane.h"
#include "models/physics/pose.h"
#include "models/support/decompositions.h"
#include "models/support/observed.h"

namespace octant {
namespace {

constexpr double kSmallestSigma_rad = 1e-9;  // used if no noise is stated
constexpr double kSmallestSight_m = 1e-6;
constexpr int kResectionSteps = 20, kRematches = 4;
constexpr double kSameSigmas = 5.0;               // hypotheses within this distance are the same pose
constexpr double kNear_m = 0.3, kNear_rad = 0.1;  // nearly equal poses, of which one is adjusted

/// Derivative of a bearing by x, y, heading.
Eigen::Vector3d by_pose(const Eigen::Vector2d& sight) {
  const double squared = std::max(sight.squaredNorm(), square(kSmallestSight_m));
  return {sight.y() / squared, -sight.x() / squared, -1.0};
}

Eigen::Vector3d pose_difference(const ResectedPose& a, const ResectedPose& b) {
  return {a.p_map_m.x() - b.p_map_m.x(), a.p_map_m.y() - b.p_map_m.y(),
          angle_of(turn_between(b.ahead, a.ahead))};
}

}  // namespace

Result<void> reflectors_fits(const Deployment& deployment) {
  const std::size_t usable = usable_beacons(deployment);
  if (usable < 3)
    return bad_input("reflectors: " + std::to_string(usable) + " usable beacons",
                     "three reflectors or more among the beacons");
  if (deployment.motion != Motion::kPlanar)
    return bad_input("reflectors: the motion is spatial", "planar motion");
  return {};
}

Reflectors::Reflectors(const Deployment& deployment, const ReflectorsOptions& options)
    : Localizer(deployment, RejectionsOf::kBearings),
      options_(options),
      index_(deployment.beacons.size(), -1),
      sums_(3, deployment.beacons.size()) {
  sigma_rad_ =
      std::max(options.bearing_sigma_rad.value_or(deployment.noise.bearing_sigma_rad), kSmallestSigma_rad);
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b) {
    const DeploymentBeacon& beacon = deployment.beacons[b];
    if (beacon.status == BeaconStatus::kUndetermined) continue;
    index_[b] = static_cast<int>(reflectors_.size());
    reflectors_.push_back(
        {beacon.position_m.head<2>(), beacon.covariance_m2.topLeftCorner<2, 2>(), BeaconId(b)});
  }
  match_.resize(kMaxBearings);
  sights_.resize(kMaxBearings);
  seen_.resize(reflectors_.size());
  named_.resize(reflectors_.size());
}

void Reflectors::predict(const Pose& T_map_vehicle, double sigma_m, double sigma_rad) noexcept {
  given_ = Prediction{
      {T_map_vehicle.translation_m.head<2>(), direction_of(T_map_vehicle.heading_rad())}, sigma_m, sigma_rad};
}

void Reflectors::locate_known(const Observations& observations, Fix& fix) noexcept {
  begin(observations, fix);
  const auto bearings = observations.bearings.first(std::min(observations.bearings.size(), kMaxBearings));
  const auto usable = std::ranges::count(fix.rejections, Rejection::kUsed);
  Hypothesis best;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  if (usable >= 3) {
    search(bearings);
    fix.status = judge(bearings, best, information);
  }
  given_.reset();
  if (!fix.ok()) return;
  fix.covariance = information.ldlt().solve(Eigen::Matrix3d::Identity());
  fix.T_map_vehicle = Pose::planar(best.pose.p_map_m.x(), best.pose.p_map_m.y(), best.pose.heading_rad());
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    if (fix.rejections[i] != Rejection::kUsed) continue;
    if (match_[i] < 0) {
      fix.rejections[i] = Rejection::kOutvoted;
      continue;
    }
    const Reflector& reflector = reflectors_[static_cast<std::size_t>(match_[i])];
    const Eigen::Vector2d sight = reflector.p_map_m - best.pose.p_map_m;
    fix.cost += 0.5 * square(off_rad(best.pose, i, sight)) / variance(reflector, sight);
  }
  count_rejections(fix);
  protect(best.pose, bearings, fix);
  last_ = best.pose;
  last_fix_s_ = fix.time_s;
  last_sigma_ = {std::sqrt(fix.covariance(0, 0) + fix.covariance(1, 1)), std::sqrt(fix.covariance(2, 2))};
}

/// Computes the protection level from the fixes without each of the reflectors.
void Reflectors::protect(const ResectedPose& pose, std::span<const Bearing> bearings, Fix& fix) noexcept {
  sums_.clear();
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    if (fix.rejections[i] != Rejection::kUsed) continue;
    const Reflector& reflector = reflectors_[static_cast<std::size_t>(match_[i])];
    const Eigen::Vector2d sight = reflector.p_map_m - pose.p_map_m;
    const double sigma = std::sqrt(variance(reflector, sight));
    const double off = off_rad(pose, i, sight);
    sums_.add(reflector.beacon, Eigen::RowVector3d(by_pose(sight).transpose() / sigma), off / sigma, 0.0);
  }
  fix.protection_level_m = sums_.level_m(horizontal_variance(fix.covariance));
}

/// Resets the fix and sets the prior of the pose.
void Reflectors::begin(const Observations& observations, Fix& fix) noexcept {
  const auto& bearings = observations.bearings;
  begin_fix(bearings, fix);
  fix.covariance.setZero(3, 3);
  fix.rejections.assign(bearings.size(), Rejection::kUsed);
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    const BeaconId id = bearings[i].reflector;
    if (i >= kMaxBearings || !std::isfinite(bearings[i].bearing_rad))
      fix.rejections[i] = Rejection::kNotNeeded;
    if (id.valid() && (id.index() >= index_.size() || index_[id.index()] < 0))
      fix.rejections[i] = Rejection::kBeaconUnusable;
    if (i < kMaxBearings) match_[i] = fix.rejections[i] == Rejection::kUsed ? -1 : -2;  // -2: never matched
    if (i < kMaxBearings) sights_[i] = direction_of(bearings[i].bearing_rad);
  }
  prediction_ = given_;
  if (!prediction_ && last_fix_s_ && options_.speed_mps > 0) {
    const double gap_s = std::abs(fix.time_s - *last_fix_s_);
    prediction_ = Prediction{last_, std::hypot(last_sigma_.x(), options_.speed_mps * gap_s),
                             std::hypot(last_sigma_.y(), options_.turn_rate_radps * gap_s)};
  }
}

double Reflectors::Prediction::cost(const ResectedPose& at, double gate_sigmas) const {
  const double most = square(gate_sigmas);
  const double distance =
      (at.p_map_m - pose.p_map_m).squaredNorm() / square(std::max(sigma_m, kSmallestSight_m));
  if (distance >= most) return 0.5 * most;
  const double turn = angle_of(turn_between(pose.ahead, at.ahead)) / std::max(sigma_rad, kSmallestSigma_rad);
  return 0.5 * std::min(distance + square(turn), most);
}

/// Angle by which a bearing lies to the left of the direction of a reflector.
/// @param sight_m  vector from the pose to the reflector, on the map
double Reflectors::off_rad(const ResectedPose& pose, std::size_t bearing,
                           const Eigen::Vector2d& sight_m) const noexcept {
  return angle_of(turn_between(turn_between(pose.ahead, sight_m), sights_[bearing]));
}

void Reflectors::predict_sight(std::size_t reflector, const ResectedPose& from) noexcept {
  const Eigen::Vector2d sight = reflectors_[reflector].p_map_m - from.p_map_m;
  seen_[reflector] = {turn_between(from.ahead, sight), variance(reflectors_[reflector], sight),
                      sight.squaredNorm() > square(options_.range_m)};
}

double Reflectors::variance(const Reflector& reflector, const Eigen::Vector2d& sight_m) const noexcept {
  const Eigen::Vector2d across = left_of(sight_m) / std::max(sight_m.squaredNorm(), square(kSmallestSight_m));
  return square(sigma_rad_) + across.dot(reflector.covariance_m2 * across);
}

/// Matches every bearing to the reflector that explains it best, each reflector at most once. An unexplained
/// bearing costs as much as one at the gate. For a pose that reaches the bound the matching may be
/// incomplete.
double Reflectors::explain(const ResectedPose& pose, std::span<const Bearing> bearings,
                           double bound) noexcept {
  const double outlier = 0.5 * square(options_.gate_sigmas);
  for (Seen& seen : seen_) seen.variance = 0.0;
  double cost = prediction_ ? prediction_->cost(pose, options_.gate_sigmas) : 0.0;
  for (const bool labelled : {true, false}) {
    for (std::size_t i = 0; i < bearings.size() && cost < bound; ++i) {
      if (match_[i] == -2 || bearings[i].reflector.valid() != labelled) continue;
      const std::size_t first =
          labelled ? static_cast<std::size_t>(index_[bearings[i].reflector.index()]) : 0;
      const std::size_t last = labelled ? first + 1 : reflectors_.size();
      double nearest = outlier;
      match_[i] = -1;
      for (std::size_t k = first; k < last; ++k) {
        const Seen& seen = seen_[k];
        if (seen.variance == 0.0) predict_sight(k, pose);
        if (seen.used) continue;
        // An angle is at least its sine, and more than a right angle if the cosine is negative. This bound
        // avoids the arctangent for most reflectors.
        const Eigen::Vector2d off = turn_between(sights_[i], seen.sight_m);
        const double widest = 2 * nearest * seen.variance;
        if (off.x() > 0 ? square(off.y()) >= widest * seen.sight_m.squaredNorm()
                        : square(std::numbers::pi / 2) >= widest)
          continue;
        const double off_cost = 0.5 * square(angle_of(off)) / seen.variance;
        if (off_cost >= nearest) continue;
        nearest = off_cost;
        match_[i] = static_cast<int>(k);
      }
      cost += nearest;
      if (match_[i] >= 0) seen_[static_cast<std::size_t>(match_[i])].used = true;
    }
  }
  return cost;
}

/// Hypothesis that a new one has to beat: the first that is nearly the same pose, since triples of one set of
/// bearings give similar poses, else the worst one.
Reflectors::Hypothesis& Reflectors::rival_of(const ResectedPose& pose) noexcept {
  for (Hypothesis& other : best_) {
    if (!std::isfinite(other.cost)) break;
    if ((pose.p_map_m - other.pose.p_map_m).squaredNorm() > square(kNear_m)) continue;
    const Eigen::Vector2d turn = turn_between(other.pose.ahead, pose.ahead);
    if (turn.x() > 0 && std::abs(turn.y()) <= kNear_rad) return other;
  }
  return best_.back();
}

void Reflectors::keep(const Hypothesis& hypothesis, Hypothesis& rival) noexcept {
  if (!(hypothesis.cost < rival.cost)) return;
  rival = hypothesis;
  std::ranges::sort(best_, {}, &Hypothesis::cost);
}

/// Fills `best_` with the poses that explain the bearings best.
void Reflectors::search(std::span<const Bearing> bearings) noexcept {
  best_.fill({});
  tried_ = 0;
  std::array<std::size_t, kSearched> order{};
  std::size_t count = 0;
  bool all_explained = false;
  if (prediction_ && prediction_->is_tight()) {
    Hypothesis seed{prediction_->pose, 0.0};
    Eigen::Matrix3d information;
    // A predicted pose is inexact, so the gate is widened at the start.
    const double sigma = sigma_rad_;
    sigma_rad_ = std::hypot(sigma, prediction_->sigma_rad);
    explain(seed.pose, bearings);
    sigma_rad_ = sigma;
    if (refine(seed, bearings, information)) {
      keep(seed, rival_of(seed.pose));
      all_explained = true;
      for (std::size_t i = 0; i < bearings.size(); ++i) all_explained = all_explained && match_[i] != -1;
      all_explained = all_explained && prediction_->cost(seed.pose, options_.gate_sigmas) < 0.5 * square(3.0);
    }
  }
  if (all_explained) return;
  // Labelled bearings come first, because their triples have one hypothesis instead of many.
  std::ranges::fill(named_, 0);
  for (const bool labelled : {true, false})
    for (std::size_t i = 0; i < bearings.size(); ++i) {
      if (match_[i] == -2 || bearings[i].reflector.valid() != labelled) continue;
      if (labelled) named_[static_cast<std::size_t>(index_[bearings[i].reflector.index()])] = 1;
      if (count < kSearched) order[count++] = i;
    }
  const std::span<const std::size_t> searched(order.data(), count);
  try_triples(bearings, searched, false);
  // A bearing matched to the reflector of another bearing leaves that one, or itself, unexplained. If a pose
  // explains all bearings, no such pose can be better.
  if (!explains_all(bearings)) try_triples(bearings, searched, true);
}

/// Returns true if the best pose so far, after adjustment, is better than any pose that leaves a bearing
/// unexplained.
bool Reflectors::explains_all(std::span<const Bearing> bearings) noexcept {
  Hypothesis best = best_.front();
  if (!std::isfinite(best.cost)) return false;
  explain(best.pose, bearings);
  Eigen::Matrix3d information;
  return refine(best, bearings, information) &&
         best.cost + options_.ambiguity_margin < 0.5 * square(options_.gate_sigmas);
}

void Reflectors::try_triples(std::span<const Bearing> bearings, std::span<const std::size_t> order,
                             bool of_others) noexcept {
  for (std::size_t k = 2; k < order.size(); ++k)
    for (std::size_t j = 1; j < k; ++j)
      for (std::size_t i = 0; i < j; ++i) try_triple(bearings, {order[i], order[j], order[k]}, of_others);
}

/// @param of_others  if true, some unlabelled bearing must match a reflector that a label names; otherwise
/// none may
void Reflectors::try_triple(std::span<const Bearing> bearings, const std::array<std::size_t, 3>& triple,
                            bool of_others) noexcept {
  std::array<std::size_t, 3> first{}, last{};
  std::array<Eigen::Vector2d, 3> sight;
  std::array<bool, 3> labelled{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Bearing& b = bearings[triple[i]];
    labelled[i] = b.reflector.valid();
    first[i] = labelled[i] ? static_cast<std::size_t>(index_[b.reflector.index()]) : 0;
    last[i] = labelled[i] ? first[i] + 1 : reflectors_.size();
    sight[i] = sights_[triple[i]];
  }
  const auto of_another = [&](std::size_t i, std::size_t k) { return !labelled[i] && named_[k] != 0; };
  for (std::size_t a = first[0]; a < last[0]; ++a)
    for (std::size_t b = first[1]; b < last[1]; ++b)
      for (std::size_t c = first[2]; c < last[2]; ++c) {
        if (a == b || b == c || a == c) continue;
        if (of_others != (of_another(0, a) || of_another(1, b) || of_another(2, c))) continue;
        if (tried_++ >= options_.max_hypotheses) return;
        const auto pose =
            resect({reflectors_[a].p_map_m, reflectors_[b].p_map_m, reflectors_[c].p_map_m}, sight);
        if (!pose) continue;
        Hypothesis& rival = rival_of(*pose);
        keep({*pose, explain(*pose, bearings, rival.cost)}, rival);
      }
}

/// Gauss-Newton on the matched bearings, with new matches after each step. False if the geometry does not
/// determine the pose.
bool Reflectors::refine(Hypothesis& hypothesis, std::span<const Bearing> bearings,
                        Eigen::Matrix3d& information) noexcept {
  ResectedPose& pose = hypothesis.pose;
  for (int round = 0; round < kRematches; ++round) {
    bool converged = false;
    for (int step = 0; step < kResectionSteps && !converged; ++step) {
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      information.setZero();
      for (std::size_t i = 0; i < bearings.size(); ++i) {
        if (match_[i] < 0) continue;
        const Reflector& reflector = reflectors_[static_cast<std::size_t>(match_[i])];
        const Eigen::Vector2d sight = reflector.p_map_m - pose.p_map_m;
        const Eigen::Vector3d J = by_pose(sight);
        const double off = off_rad(pose, i, sight);
        const double weight = 1 / variance(reflector, sight);
        information += weight * J * J.transpose();
        gradient += weight * off * J;
      }
      const ObservedState<Eigen::Matrix3d> observed(information);
      if (!observed.all()) return false;
      const Eigen::Vector3d change = observed.solve(gradient);
      if (!change.allFinite()) return false;
      pose.p_map_m += change.head<2>();
      pose.ahead = direction_of(pose.heading_rad() + change.z());
      converged = change.cwiseAbs().maxCoeff() < 1e-10;
    }
    if (!converged) return false;
    const double before = hypothesis.cost;
    hypothesis.cost = explain(pose, bearings);
    if (round > 0 && hypothesis.cost == before) break;
  }
  return true;
}

/// Refines the best hypotheses and leaves the matches of the best one in `match_`.
FixStatus Reflectors::judge(std::span<const Bearing> bearings, Hypothesis& best,
                            Eigen::Matrix3d& information) noexcept {
  std::array<Eigen::Matrix3d, kBest> informations;
  std::size_t winner = kBest;
  for (std::size_t h = 0; h < kBest; ++h) {
    if (!std::isfinite(best_[h].cost)) continue;
    explain(best_[h].pose, bearings);
    if (!refine(best_[h], bearings, informations[h])) {
      best_[h].cost = std::numeric_limits<double>::infinity();
    } else if (winner == kBest || best_[h].cost < best_[winner].cost) {
      winner = h;
    }
  }
  if (winner == kBest) return FixStatus::kPoorGeometry;
  best = best_[winner];
  information = informations[winner];
  explain(best.pose, bearings);
  int matched = 0, named = 0;
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    matched += match_[i] >= 0;
    named += match_[i] >= 0 && bearings[i].reflector.valid();
  }
  const bool is_predicted = prediction_ && prediction_->is_tight() &&
                            prediction_->cost(best.pose, options_.gate_sigmas) < 0.5 * square(3.0);
  if (matched < 3 || (matched == 3 && named < 3 && !is_predicted)) return FixStatus::kNoConsensus;
  const Eigen::Matrix3d covariance = information.ldlt().solve(Eigen::Matrix3d::Identity());
  const SymmetricEigen<Eigen::Matrix2d> axes(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  if (!(axes.eigenvalues().minCoeff() >= 0) ||
      !(axes.eigenvalues().maxCoeff() < square(options_.max_sigma_m)))
    return FixStatus::kPoorGeometry;
  for (const Hypothesis& other : best_) {
    if (!(other.cost < best.cost + options_.ambiguity_margin)) continue;
    const Eigen::Vector3d d = pose_difference(other.pose, best.pose);
    if (d.dot(information * d) > square(kSameSigmas)) return FixStatus::kAmbiguous;
  }
  return FixStatus::kOk;
}

}  // namespace octant

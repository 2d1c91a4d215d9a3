// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_longsolve.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace octant {
namespace {

constexpr int kMaxAveraged = 32;
constexpr double kLongsolveRounding_m = 1e-6;  // deviations below this are due to the iteration
constexpr double kThin =
    0.2;  // beacons are collinear if their lateral spread is below this share of their extent
constexpr double kOutside_m =
    1.0;  // largest distance of a valid position from the bounding box of all beacons
using Gain = Eigen::Matrix<double, 2, kKleemanBeacons>;
using Row = Eigen::Matrix<double, 1, kKleemanBeacons>;

Eigen::Vector2d mirrored(const Eigen::Vector2d& p, const Eigen::Vector2d& on_line,
                         const Eigen::Vector2d& along) {
  const Eigen::Vector2d from = p - on_line, unit = along.normalized();
  return on_line + 2 * unit * unit.dot(from) - from;
}

}  // namespace

/// Data shared by all attempts at one position.
struct Longsolve::Problem {
  const OffsetDistances& distances;
  BeaconSet valid;
  Row variance_m2;
  double scale_sigma;

  /// Variance of a linear combination of the distances, including their common scale.
  [[nodiscard]] double variance(const Row& by_distance, const Row& length_m) const {
    const double scale_m = scale_sigma * by_distance.dot(length_m);
    return by_distance.cwiseAbs2().dot(variance_m2) + scale_m * scale_m;
  }
};

struct Longsolve::Solution {
  std::uint16_t triple = 0;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Gain gain = Gain::Zero();
};

/// The averaged triples, with the number of uses of each beacon.
struct Longsolve::Average {
  std::array<Solution, kMaxAveraged> members;
  int count = 0;
  std::array<int, kKleemanBeacons> uses{};
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Gain gain = Gain::Zero();

  void add(const Solution& solution, const Triple& beacons) {
    members[static_cast<std::size_t>(count++)] = solution;
    for (const std::uint8_t b : beacons) ++uses[b];
  }
  void remove(int at, const Triple& beacons) {
    members[static_cast<std::size_t>(at)] = members[static_cast<std::size_t>(--count)];
    for (const std::uint8_t b : beacons) --uses[b];
  }
  /// Step 3: weights of x and y are the inverses of their estimated errors.
  void weigh(const std::vector<Eigen::Vector2d>& error) {
    Eigen::Array2d sum = Eigen::Array2d::Zero(), at = Eigen::Array2d::Zero();
    gain.setZero();
    for (int i = 0; i < count; ++i) {
      const Solution& s = members[static_cast<std::size_t>(i)];
      const Eigen::Array2d weight = error[s.triple].array().inverse();
      sum += weight;
      at += weight * s.p.array();
      gain += weight.matrix().asDiagonal() * s.gain;
    }
    p = (at / sum).matrix();
    gain = sum.inverse().matrix().asDiagonal() * gain;
  }
};

Longsolve::Longsolve(std::span<const PlanBeacon> beacons, const LongsolveOptions& options)
    : beacons_(beacons.begin(), beacons.end()), options_(options) {
  options_.triples = std::clamp(options_.triples, 1, kMaxAveraged);
  const auto n = static_cast<std::uint8_t>(beacons_.size());
  for (std::uint8_t i = 0; i < n; ++i)
    for (std::uint8_t j = static_cast<std::uint8_t>(i + 1); j < n; ++j)
      for (std::uint8_t k = static_cast<std::uint8_t>(j + 1); k < n; ++k) triples_.push_back({i, j, k});
  low_m_ = high_m_ = beacons_.front().p_map_m;
  for (const PlanBeacon& b : beacons_) {
    low_m_ = low_m_.cwiseMin(b.p_map_m);
    high_m_ = high_m_.cwiseMax(b.p_map_m);
  }
}

LongsolveMemory Longsolve::memory() const {
  LongsolveMemory memory;
  memory.error.resize(triples_.size());
  memory.order.resize(triples_.size());
  return memory;
}

/// Step 2: "recalculate all errors".
void Longsolve::estimate_errors(const Eigen::Vector2d& at, LongsolveMemory& memory) const noexcept {
  for (std::size_t t = 0; t < triples_.size(); ++t) {
    const auto [i, j, k] = triples_[t];
    memory.error[t] = hyperbolic_error_m({beacons_[i], beacons_[j], beacons_[k]}, at, {1.0, 1.0, 1.0});
    memory.order[t] = static_cast<std::uint16_t>(t);
  }
  std::ranges::sort(memory.order, [&](std::uint16_t a, std::uint16_t b) {
    const double ea = memory.error[a].squaredNorm(), eb = memory.error[b].squaredNorm();
    return ea != eb ? ea < eb : a < b;
  });
  memory.errors_at_map_m = at;
  memory.has_errors = true;
}

bool Longsolve::solve_triple(const Problem& problem, std::uint16_t triple, const Eigen::Vector2d& start,
                             Solution& solution) const noexcept {
  const auto [i, j, k] = triples_[triple];
  const auto& d = problem.distances.distance_m;
  const HyperbolicFix fix =
      hyperbolic_fix({beacons_[i], beacons_[j], beacons_[k]}, {d[i], d[j], d[k]}, start, options_.hyperbolic);
  if (!fix.converged) return false;
  solution.triple = triple;
  solution.p = fix.p_map_m;
  solution.gain.setZero();
  const Eigen::Matrix<double, 2, 3> J = fix.step.by_distances();
  solution.gain.col(i) = J.col(0);
  solution.gain.col(j) = J.col(1);
  solution.gain.col(k) = J.col(2);
  return true;
}

/// Step 1: the "quick and dirty" solution from the triple with the smallest error that has one.
bool Longsolve::quick(const Problem& problem, BeaconSet subset, const LongsolveMemory& memory,
                      Eigen::Vector2d& p) const noexcept {
  Solution solution;
  for (const std::uint16_t t : memory.order) {
    if (!within(triples_[t], subset) || !memory.error[t].allFinite()) continue;
    if (!solve_triple(problem, t, p, solution)) continue;
    p = solution.p;
    return true;
  }
  return false;
}

/// The four steps of the paper.
/// @param wanted  beacons that may be averaged; less accurate ones are used in resolve() only
LongsolveFix Longsolve::attempt(const Problem& problem, BeaconSet wanted, const Eigen::Vector2d& start,
                                LongsolveMemory& memory) const noexcept {
  const BeaconSet subset = wanted & ~problem.distances.rough;
  LongsolveFix fix;
  fix.status = FixStatus::kNoConsensus;
  if (!memory.has_errors) estimate_errors(start, memory);
  Eigen::Vector2d p = start;
  if (!quick(problem, subset, memory, p)) return fix;                                              // step 1
  if (!((p - memory.errors_at_map_m).norm() <= options_.recompute_m)) estimate_errors(p, memory);  // step 2

  Average average;
  std::size_t next = 0;
  const auto fill = [&] {  // adds the next best triples whose beacons may still be used
    Solution solution;
    for (; next < memory.order.size() && average.count < options_.triples; ++next) {
      const std::uint16_t t = memory.order[next];
      const Triple& b = triples_[t];
      if (!within(b, subset) || !memory.error[t].allFinite()) continue;
      if (std::max({average.uses[b[0]], average.uses[b[1]], average.uses[b[2]]}) >= options_.max_uses)
        continue;
      if (solve_triple(problem, t, p, solution)) average.add(solution, b);
    }
    average.weigh(memory.error);  // step 3
  };
  fill();
  if (average.count == 0) return fix;
  while (average.count > options_.min_triples) {  // step 4
    Row length_m = Row::Zero();
    for (std::size_t b = 0; b < beacons_.size(); ++b)
      length_m[static_cast<int>(b)] = slant_distance_m(beacons_[b], average.p);
    int worst = -1;
    double worst_ratio = 1.0;
    for (int i = 0; i < average.count; ++i) {
      const Solution& s = average.members[static_cast<std::size_t>(i)];
      const Gain by = s.gain - average.gain;
      const double expected_m =
          std::sqrt(problem.variance(by.row(0), length_m) + problem.variance(by.row(1), length_m));
      const double ratio =
          (s.p - average.p).norm() / (options_.deviation_sigmas * expected_m + kLongsolveRounding_m);
      if (ratio > worst_ratio) worst = i, worst_ratio = ratio;
    }
    if (worst < 0) break;
    average.remove(worst, triples_[average.members[static_cast<std::size_t>(worst)].triple]);
    fill();
  }
  fix.status = FixStatus::kOk;
  fix.p_map_m = average.p;
  fix.gain = average.gain;
  fix.triples = average.count;
  for (std::size_t b = 0; b < beacons_.size(); ++b) fix.averaged[b] = average.uses[b] > 0;
  resolve(problem, fix);
  return fix;
}

/// Residual of each beacon at the averaged position, whether used in it or not.
void Longsolve::resolve(const Problem& problem, LongsolveFix& fix) const noexcept {
  const auto n = static_cast<int>(beacons_.size());
  Row length_m = Row::Zero(), by_offset = Row::Zero();
  std::array<Row, kKleemanBeacons> by;  // derivative of each residual by the distances
  double sum_m = 0.0;
  for (int b = 0; b < n; ++b) {
    const auto i = static_cast<std::size_t>(b);
    length_m[b] = slant_distance_m(beacons_[i], fix.p_map_m);
    fix.residual_m[i] = problem.distances.distance_m[i] - length_m[b];
    by[i] = foreshortened(beacons_[i], fix.p_map_m).transpose() * fix.gain;
    by[i][b] += 1.0;
    if (!fix.averaged[i]) continue;
    sum_m += fix.residual_m[i];
    by_offset += by[i];
  }
  const auto used = static_cast<double>(fix.averaged.count());
  fix.offset_m = sum_m / used;
  by_offset /= used;
  for (std::size_t i = 0; i < beacons_.size(); ++i) {
    if (!problem.valid[i]) continue;
    fix.residual_m[i] -= fix.offset_m;
    const double sigma_m = std::sqrt(problem.variance(by[i] - by_offset, length_m));
    const double gate_m = options_.deviation_sigmas * sigma_m + kLongsolveRounding_m;
    fix.agreeing[i] = std::abs(fix.residual_m[i]) <= gate_m;
    fix.late[i] = fix.residual_m[i] > gate_m;
    fix.early[i] = fix.residual_m[i] < -gate_m;
    if (fix.agreeing[i])
      fix.chi2 += fix.residual_m[i] * fix.residual_m[i] / problem.variance_m2[static_cast<int>(i)];
  }
}

/// Accepts a solution if all averaged distances agree, enough of them agree, and the others are late. A
/// direct pulse cannot be early; an early one counts as spurious if six agree.
bool Longsolve::acceptable(const Problem& problem, const LongsolveFix& fix) const noexcept {
  if (!fix.ok() || (fix.averaged & ~fix.agreeing).any()) return false;
  // Inaccurate distances agree with many positions: they neither replace others nor may they contradict.
  for (const BeaconSet counted :
       {problem.distances.heard & ~problem.distances.rough, problem.distances.heard}) {
    const auto heard = static_cast<int>(counted.count());
    const auto agreeing = static_cast<int>((fix.agreeing & counted).count());
    if (agreeing < std::max(3, std::min(options_.min_agreeing, heard))) return false;
    if (!(agreeing > options_.agreeing_share * heard)) return false;
    if (fix.early.any() && agreeing < 6) return false;
  }
  return true;
}

LongsolveFix Longsolve::search_exclusions(const Problem& problem, const Eigen::Vector2d& start,
                                          LongsolveMemory& memory) const noexcept {
  LongsolveFix best;
  best.status = FixStatus::kNoConsensus;
  const auto n = beacons_.size();
  const auto consider = [&](BeaconSet left_out) {
    const BeaconSet subset = problem.valid & ~left_out;
    if (static_cast<int>(subset.count()) < std::max(3, options_.min_agreeing)) return;
    LongsolveFix fix = attempt(problem, subset, start, memory);
    if (!acceptable(problem, fix)) return;
    const bool rivals = best.ok() && fix.agreeing != best.agreeing &&
                        fix.agreeing.count() == best.agreeing.count() &&
                        std::abs(fix.chi2 - best.chi2) < options_.ambiguity_margin;
    const double variance_m2 = fix.gain.cwiseAbs2().colwise().sum().dot(problem.variance_m2);
    if (rivals &&
        (fix.p_map_m - best.p_map_m).norm() > options_.deviation_sigmas * std::sqrt(2 * variance_m2)) {
      best.status = FixStatus::kAmbiguous;
      return;
    }
    const bool better = best.status == FixStatus::kNoConsensus ||
                        fix.agreeing.count() > best.agreeing.count() ||
                        (fix.agreeing.count() == best.agreeing.count() && fix.chi2 < best.chi2);
    if (!better) return;
    const bool still_ambiguous = best.status == FixStatus::kAmbiguous &&
                                 fix.agreeing.count() == best.agreeing.count() &&
                                 std::abs(fix.chi2 - best.chi2) < options_.ambiguity_margin;
    best = fix;
    if (still_ambiguous) best.status = FixStatus::kAmbiguous;
  };
  if (options_.max_exclusions >= 1)
    for (std::size_t i = 0; i < n; ++i)
      if (problem.valid[i]) consider(BeaconSet().set(i));
  if (options_.max_exclusions < 2 || best.status != FixStatus::kNoConsensus) return best;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      if (problem.valid[i] && problem.valid[j]) consider(BeaconSet().set(i).set(j));
  return best;
}

double Longsolve::outside_m(const Eigen::Vector2d& p) const noexcept {
  return (low_m_ - p).cwiseMax(p - high_m_).cwiseMax(0.0).norm();
}

/// Centre of the beacons, displaced to the side if they are collinear.
Eigen::Vector2d Longsolve::first_guess(BeaconSet valid) const noexcept {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  const auto count = static_cast<double>(valid.count());
  for (std::size_t b = 0; b < beacons_.size(); ++b)
    if (valid[b]) middle += beacons_[b].p_map_m / count;
  for (std::size_t b = 0; b < beacons_.size(); ++b)
    if (valid[b])
      spread += (beacons_[b].p_map_m - middle) * (beacons_[b].p_map_m - middle).transpose() / count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(spread);
  if (axes.eigenvalues()[0] < kThin * kThin * axes.eigenvalues()[1])
    middle += std::sqrt(axes.eigenvalues()[1]) * axes.eigenvectors().col(0);
  return middle;
}

/// Returns true if another position explains the distances equally well: the mirror image at a line of
/// beacons, or, without redundancy, the second intersection of the same two hyperbolas. Beacons surround the
/// environment, so a position between them is preferred over one a metre outside.
bool Longsolve::ambiguous(const Problem& problem, const LongsolveFix& fix,
                          LongsolveMemory& memory) const noexcept {
  const double sigma_m = std::sqrt(fix.gain.cwiseAbs2().colwise().sum().dot(problem.variance_m2));
  const auto rivals = [&](const Eigen::Vector2d& start) {
    const LongsolveFix other = attempt(problem, fix.agreeing, start, memory);
    if (!acceptable(problem, other) || other.agreeing.count() < fix.agreeing.count()) return false;
    if ((other.p_map_m - fix.p_map_m).norm() < 0.01 + 2 * options_.deviation_sigmas * sigma_m) return false;
    if (other.chi2 > fix.chi2 + options_.ambiguity_margin) return false;
    return !(outside_m(fix.p_map_m) == 0 && outside_m(other.p_map_m) > kOutside_m);
  };
  std::array<std::size_t, kKleemanBeacons> in{};
  std::size_t count = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t b = 0; b < beacons_.size(); ++b)
    if (fix.agreeing[b]) middle += beacons_[in[count++] = b].p_map_m;
  middle /= static_cast<double>(count);
  if (count == 3) {
    const auto other = other_intersection({beacons_[in[0]], beacons_[in[1]], beacons_[in[2]]}, fix.p_map_m);
    if (other && !(outside_m(fix.p_map_m) == 0 && outside_m(*other) > kOutside_m) &&
        (*other - fix.p_map_m).norm() > options_.deviation_sigmas * sigma_m)
      return true;
  }
  const Eigen::Vector2d guess = first_guess(fix.agreeing);
  if ((guess - middle).norm() < kLongsolveRounding_m) return false;
  const Eigen::Vector2d across = guess - middle;
  return rivals(mirrored(fix.p_map_m, middle, {-across.y(), across.x()}));
}

LongsolveFix Longsolve::solve(const OffsetDistances& distances, BeaconSet valid, double scale_sigma,
                              LongsolveMemory& memory) const noexcept {
  LongsolveFix none;
  if (distances.heard.count() < 3) return none;
  none.status = FixStatus::kNoConsensus;
  if (valid.count() < 3) return none;
  Problem problem{distances, valid, Row::Zero(), scale_sigma};
  for (std::size_t b = 0; b < beacons_.size(); ++b)
    problem.variance_m2[static_cast<int>(b)] = valid[b] ? distances.sigma_m[b] * distances.sigma_m[b] : 0.0;
  const Eigen::Vector2d guess = first_guess(valid);
  LongsolveFix fix = attempt(problem, valid, memory.placed ? memory.p_map_m : guess, memory);
  if (!acceptable(problem, fix) && memory.placed)
    fix = attempt(problem, valid, guess, memory);  // the vehicle was carried elsewhere
  if (!acceptable(problem, fix)) fix = search_exclusions(problem, guess, memory);
  if (!fix.ok()) {
    bool determined = false;
    for (std::size_t t = 0; t < triples_.size(); ++t)
      determined = determined || (within(triples_[t], valid) && memory.error[t].allFinite());
    if (!determined) fix.status = FixStatus::kPoorGeometry;
    return fix;
  }
  const Eigen::Array2d variance_m2 = (fix.gain.cwiseAbs2() * problem.variance_m2.transpose()).array();
  if (!(variance_m2.maxCoeff() <= options_.max_sigma_m * options_.max_sigma_m)) {
    fix.status = FixStatus::kPoorGeometry;
    return fix;
  }
  if (ambiguous(problem, fix, memory)) {
    fix.status = FixStatus::kAmbiguous;
    return fix;
  }
  memory.placed = true;
  memory.p_map_m = fix.p_map_m;
  return fix;
}

}  // namespace octant

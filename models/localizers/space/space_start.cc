// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_start.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "models/localizers/drive/drive_start.h"
#include "models/localizers/drive/rigid_path.h"
#include "models/localizers/least_squares/spatial_start.h"
#include "models/physics/plane.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/settle.h"

namespace octant {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kFewestRangesOfPiece = 12, kFewestBeaconsOfPiece = 3;
constexpr double kClearMargin = 8.0;   ///< of the cost, to any other pose
constexpr double kMostMeanCost = 2.0;  ///< of an arrival: 0.5 where all is well
/// Sigmas within which what follows linearises safely: of the attitude, of the place as a share of the
/// ranges; where beacons are known roughly nothing but odometry follows, and all are then adjusted together.
constexpr double kMostAngleRad = 0.25, kMostShare = 0.05, kMostRoughAngleRad = 0.1, kMostRoughShare = 0.02;
constexpr RobustLoss kWide{.late_scale = 30.0, .early_scale = 60.0},
    kNarrow{.late_scale = 2.5, .early_scale = 4.0};

/// A stretch of odometry that moves as one, and what is heard along it. With slack each beacon is off by an
/// unknown of its own, which is eliminated (Schur complement): what all its arrivals share does not average
/// out, and a height is told no better than the beacons' own are.
class RigidPiece {
 public:
  RigidPiece(const SearchProblem& problem, double slack_m)
      : problem_(problem), prior_(slack_m > 0 ? 1.0 / square(slack_m) : 0.0) {
    for (const SearchRange& r : problem.ranges) weight_.push_back(1.0 / r.sigma_m);
    at_.off_m.assign(problem.groups(), Eigen::Vector3d::Zero());
  }

  /// Levenberg-Marquardt, beacons first where they are said to be.
  void begin() { std::fill(at_.off_m.begin(), at_.off_m.end(), Eigen::Vector3d::Zero()); }
  void settle(Pose& T, const RobustLoss& loss, int iterations) {
    at_.T = T;
    Normal now = build(at_, loss);
    double lambda = 1e-6;
    for (int i = 0; i < iterations; ++i) {
      Matrix6 A = now.H;
      A.diagonal() += lambda * now.H.diagonal() + Vector6::Constant(1e-9);
      const State tried = moved(-A.ldlt().solve(now.g), now);
      Normal next = build(tried, loss);
      if (!(next.cost < now.cost)) {
        lambda *= 10;
        if (lambda > 1e4) break;
        continue;
      }
      const bool at_rest = now.cost - next.cost < 1e-6 * (1.0 + now.cost);
      at_ = tried;
      now = std::move(next);
      lambda = std::max(0.1 * lambda, 1e-9);
      if (at_rest) break;
    }
    T = at_.T;
    H_ = now.H;
  }

  /// Negative log likelihood up to a constant of a mixture of what came straight, late and early: an outlier
  /// costs the same however far off it is (consensus.h has the caps).
  [[nodiscard]] double score() const {
    double sum = 0.0;
    for (const Eigen::Vector3d& off_m : at_.off_m) sum += 0.5 * prior_ * off_m.squaredNorm();
    for_each_range([&](std::size_t i, std::size_t group) {
      const SearchRange& r = problem_.ranges[i];
      const double residual =
          weight_[i] * (r.range_m - (at_.T * r.p_lever_m - r.p_beacon_map_m - at_.off_m[group]).norm());
      const double ratio = problem_.span_m * weight_[i];
      const double cap =
          residual > 0 ? std::max(2.0, std::log(1.4 * ratio)) : std::max(4.0, std::log(28.0 * ratio));
      sum += std::min(0.5 * residual * residual, cap);
    });
    return sum;
  }

  /// Gauss-Newton matrix of the pose where it was last settled.
  [[nodiscard]] const Matrix6& information() const { return H_; }
  [[nodiscard]] Eigen::Vector3d middle_m() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const SearchRange& r : problem_.ranges) sum += r.p_lever_m;
    return sum / static_cast<double>(problem_.ranges.size());
  }

 private:
  struct State {
    Pose T;
    std::vector<Eigen::Vector3d> off_m;  ///< of each beacon from where it is said to be
  };
  /// Normal equations of the pose, and of each beacon what it takes to follow: off = -A^-1 (b + B' step).
  struct Normal {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    double cost = 0.0;
    std::vector<Eigen::Matrix3d> A_inverse;
    std::vector<Eigen::Matrix<double, 6, 3>> B;
    std::vector<Eigen::Vector3d> b;
  };

  template <class Visit>
  void for_each_range(Visit&& visit) const {
    for (std::size_t group = 0; group < problem_.groups(); ++group)
      for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i)
        visit(i, group);
  }

  [[nodiscard]] Normal build(const State& at, const RobustLoss& loss) const {
    Normal out;
    const std::size_t groups = problem_.groups();
    out.A_inverse.assign(groups, prior_ * Eigen::Matrix3d::Identity());
    out.B.assign(groups, Eigen::Matrix<double, 6, 3>::Zero());
    out.b.resize(groups);
    for (std::size_t group = 0; group < groups; ++group) {
      out.b[group] = prior_ * at.off_m[group];
      out.cost += 0.5 * prior_ * at.off_m[group].squaredNorm();
    }
    for_each_range([&](std::size_t i, std::size_t group) {
      const SearchRange& r = problem_.ranges[i];
      const Eigen::Vector3d v = at.T * r.p_lever_m - r.p_beacon_map_m - at.off_m[group];
      const double d = std::max(v.norm(), 1e-6), residual = weight_[i] * (r.range_m - d);
      const Eigen::Vector3d u = weight_[i] / d * v;  // by the beacon; the opposite by the place
      Vector6 J;
      J << -u, -r.p_lever_m.cross(at.T.rotation.conjugate() * u);
      double rho = 0.0, w = 1.0;
      loss.evaluate(residual, rho, w);
      out.cost += 0.5 * rho;
      out.H += w * J * J.transpose();
      out.g += w * residual * J;
      if (prior_ == 0.0) return;
      out.A_inverse[group] += w * u * u.transpose();
      out.B[group] += w * J * u.transpose();
      out.b[group] += w * residual * u;
    });
    for (std::size_t group = 0; group < groups && prior_ > 0; ++group) {
      out.A_inverse[group] = out.A_inverse[group].inverse().eval();
      const Eigen::Matrix<double, 6, 3> taken = out.B[group] * out.A_inverse[group];
      out.H -= taken * out.B[group].transpose();
      out.g -= taken * out.b[group];
    }
    return out;
  }

  [[nodiscard]] State moved(const Vector6& step, const Normal& by) const {
    State out = at_;
    out.T = retract(at_.T, step, Motion::kSpatial);
    for (std::size_t group = 0; group < out.off_m.size() && prior_ > 0; ++group)
      out.off_m[group] -= by.A_inverse[group] * (by.b[group] + by.B[group].transpose() * step);
    return out;
  }

  const SearchProblem& problem_;
  double prior_;  ///< information of each coordinate of a beacon; 0: they are known
  std::vector<double> weight_;
  State at_;
  Matrix6 H_ = Matrix6::Zero();
};

struct Placing {
  Pose T_map_anchor;
  double cost = 0.0;
  Matrix6 information;
};

/// Places of a piece's middle, as far as its own size lets them be told: by small samples of what is heard,
/// as an echo among the squares of ranges spoils all of them (random sample consensus, Fischler and Bolles
/// 1981).
std::vector<Eigen::Vector3d> likely_places(const SearchProblem& problem, const Eigen::Vector3d& middle_m) {
  constexpr std::size_t kSamples = 40, kOfSample = 10, kKept = 4;
  double size2 = square(problem.median_sigma_m + problem.slack_m);
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
  std::uint32_t draw = 1;  // the same for the same ranges
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
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::Vector3d> places;
  for (const auto& [its_cost, p] : found)
    if (places.size() < kKept && std::all_of(places.begin(), places.end(), [&, &at = p](const auto& other) {
          return (at - other).squaredNorm() > size2;
        }))
      places.push_back(p);
  return places;
}

/// Distinct poses, best first.
std::vector<Placing> search(const SearchProblem& problem, double slack_m, double apart_m) {
  RigidPiece piece(problem, slack_m);
  const Eigen::Vector3d middle_m = piece.middle_m();
  std::vector<Placing> found;
  for (const Eigen::Vector3d& place : likely_places(problem, middle_m))
    for (const Eigen::Quaterniond& q : coarse_rotations()) {
      Placing p;
      p.T_map_anchor = {place - q * middle_m, q};
      piece.begin();
      piece.settle(p.T_map_anchor, kWide, 15);
      piece.settle(p.T_map_anchor, kNarrow, 20);
      p.information = piece.information();
      p.cost = piece.score();
      if (std::isfinite(p.cost)) found.push_back(p);
    }
  std::sort(found.begin(), found.end(), [](const Placing& a, const Placing& b) { return a.cost < b.cost; });
  std::vector<Placing> distinct;
  for (const Placing& p : found)
    if (std::all_of(distinct.begin(), distinct.end(),
                    [&](const Placing& d) { return differs(d.T_map_anchor, p.T_map_anchor, apart_m); }))
      distinct.push_back(p);
  return distinct;
}

bool is_tight(const Placing& p, const SearchProblem& problem) {
  const Eigen::LDLT<Matrix6> ldlt(p.information);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return false;
  const Matrix6 P = ldlt.solve(Matrix6::Identity());
  const bool rough = problem.slack_m > 0;
  const double most_m = rough ? kMostRoughShare * problem.span_m
                              : std::max(kMostShare * problem.span_m, 2 * problem.median_sigma_m);
  return P.topLeftCorner<3, 3>().trace() < square(most_m) &&
         P.bottomRightCorner<3, 3>().trace() < square(rough ? kMostRoughAngleRad : kMostAngleRad);
}

/// Whether one path is the other's image in the beacons' plane, as level as that.
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
  if (std::abs(normal.z()) < 0.7) return false;  // which of them is nearer the floor says nothing
  return std::all_of(path.T_anchor_node.begin(), path.T_anchor_node.end(), [&](const Pose& T) {
    const Eigen::Vector3d p = a * T.translation_m, q = b * T.translation_m;
    return (p - 2 * normal.dot(p - centre) * normal - q).norm() < within_m;
  });
}

double lowest_m(const RigidPath& path, const Pose& T_map_anchor) {
  double lowest = INFINITY;
  for (const Pose& T : path.T_anchor_node) lowest = std::min(lowest, (T_map_anchor * T.translation_m).z());
  return lowest;
}

/// The pose that stands clear of all others, of two images the lower one above the floor; none: nullptr.
const Placing* clear_one(const SearchProblem& problem, const RigidPath& path,
                         const std::vector<Placing>& found, double scale_m) {
  if (found.empty()) return nullptr;
  const auto rivals =
      static_cast<std::size_t>(std::count_if(found.begin(), found.end(), [&](const Placing& p) {
        return p.cost < found.front().cost + kClearMargin;
      }));
  const Placing* best = &found.front();
  if (rivals > 2) return nullptr;
  if (rivals == 2) {
    const Placing& second = found[1];
    if (!are_images(problem, path, best->T_map_anchor, second.T_map_anchor,
                    std::max(10 * scale_m, 0.03 * problem.span_m)))
      return nullptr;
    const double a_m = lowest_m(path, best->T_map_anchor), b_m = lowest_m(path, second.T_map_anchor);
    const double below_m = 0.1 * std::abs(a_m - b_m) + 3 * scale_m;  // the floor, within the errors
    if (std::min(a_m, b_m) >= -below_m ? b_m < a_m : b_m > a_m) best = &second;
  }
  const bool fits = best->cost <= kMostMeanCost * static_cast<double>(problem.ranges.size());
  return fits && is_tight(*best, problem) ? best : nullptr;
}

/// Nodes [first, last).
struct NodeRange {
  std::size_t first = 0, last = 0;
};

/// Whether most of the arrivals of some nodes do not agree.
bool is_lost(const Trajectory& t, const Segment& segment, const NodeRange& piece, const SharedState& state,
             double sigmas) {
  constexpr std::size_t kFewest = 8;
  std::size_t heard = 0, off = 0;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.node < piece.first || a.node >= piece.last || a.rejection != Rejection::kUsed) continue;
    ++heard;
    off += std::abs(arrival_residual(t, a, state)) > sigmas;
  }
  return heard >= kFewest && 2 * off > heard;
}

}  // namespace

bool place_stretch_in_space(Trajectory& t, const Segment& stretch, const EpochFixModel& model,
                            const TrackerOptions& options) {
  const std::size_t anchor = stretch.first_node + (stretch.last_node - stretch.first_node) / 2;
  const RigidPath path = rigid_path(t, stretch, anchor);
  SearchProblem problem = make_search_problem(t, stretch, model, options.range_slack_m, path);
  if (problem.ranges.size() < kFewestRangesOfPiece || problem.groups() < kFewestBeaconsOfPiece) return false;
  thin_out(problem);
  const double scale_m = std::hypot(problem.median_sigma_m, options.range_slack_m);
  const std::vector<Placing> found = search(problem, options.range_slack_m, 10 * scale_m);
  const Placing* const best = clear_one(problem, path, found, scale_m);
  if (best == nullptr) return false;
  if (options.range_slack_m > 0) {
    // Settled among beacons that are off, it would bend towards them.
    lay_rigidly(t, stretch, best->T_map_anchor, path);
  } else {
    lay_stretch(t, stretch, model, 0.0, best->T_map_anchor, path);
  }
  return true;
}

std::size_t follow_in_space(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                            const TrackerOptions& options, std::size_t node, bool forward) {
  if (options.range_slack_m > 0) return follow_odometry(t, segment, node, forward);
  constexpr double kPiece_s = 2.0, kBefore_s = 4.0;
  const auto is_before = [&](std::size_t k) {
    return t.nodes[k].placed && std::abs(t.nodes[k].time_s - t.nodes[node].time_s) <= kBefore_s;
  };
  while (forward ? node + 1 < segment.last_node : node > segment.first_node) {
    const std::size_t reached = follow_odometry(t, segment, node, forward, kPiece_s);
    const NodeRange next{std::min(node, reached), std::max(node, reached) + 1};
    NodeRange about = next;
    while (forward && about.first > segment.first_node && is_before(about.first - 1)) --about.first;
    while (!forward && about.last < segment.last_node && is_before(about.last)) ++about.last;
    const Segment piece = stretch_of(t, segment, about.first, about.last);
    settle(t, piece, model.state, kNarrow,
           {.max_iterations = 10, .hold_first = forward, .hold_last = !forward});
    node = reached;
    if (forward && is_lost(t, piece, next, model.state, 1.5 * options.rejection_sigmas)) break;
  }
  return node;
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/place_by_ranges.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "models/simulator/random.h"

namespace octant::calib {
namespace {

constexpr double kUnreached = std::numeric_limits<double>::infinity();
/// Rounds of new weights, and steps of majorization in each.
constexpr int kWeightRounds = 15, kMajorizations = 20;
/// Scale of the weights relative to the median residual: an ordinary residual keeps most of its weight.
constexpr double kResidualScale = 3.0;
/// Displacement of another start relative to the extent of the points.
constexpr double kDisplacement = 0.3;

using Neighbours = std::vector<std::vector<std::pair<int, double>>>;

/// Lengths of the shortest paths from one point (Dijkstra).
Eigen::VectorXd shortest_paths(const Neighbours& neighbours, int start) {
  Eigen::VectorXd length_m =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(neighbours.size()), kUnreached);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length_m[start] = 0.0;
  open.emplace(0.0, start);
  while (!open.empty()) {
    const auto [reached_m, p] = open.top();
    open.pop();
    if (reached_m > length_m[p]) continue;
    for (const auto& [next, edge_m] : neighbours[static_cast<std::size_t>(p)])
      if (reached_m + edge_m < length_m[next]) open.emplace(length_m[next] = reached_m + edge_m, next);
  }
  return length_m;
}

/// Columns of the points in the largest connected part; -1 for the others.
std::vector<int> largest_part(const Neighbours& neighbours) {
  const std::size_t n = neighbours.size();
  std::vector<int> part(n, -1), sizes;
  for (std::size_t start = 0; start < n; ++start) {
    if (part[start] >= 0) continue;
    const Eigen::VectorXd reached = shortest_paths(neighbours, static_cast<int>(start));
    sizes.push_back(0);
    for (std::size_t p = 0; p < n; ++p)
      if (std::isfinite(reached[static_cast<Eigen::Index>(p)])) {
        part[p] = static_cast<int>(sizes.size()) - 1;
        ++sizes.back();
      }
  }
  const int largest = sizes.empty() ? 0 : static_cast<int>(std::ranges::max_element(sizes) - sizes.begin());
  int next = 0;
  for (int& p : part) p = p == largest ? next++ : -1;
  return part;
}

Eigen::MatrixXd classical_scaling(const Eigen::MatrixXd& length_m, int dimensions) {
  const Eigen::Index n = length_m.rows();
  const Eigen::MatrixXd centre = Eigen::MatrixXd::Identity(n, n).array() - 1.0 / static_cast<double>(n);
  const Eigen::MatrixXd gram = -0.5 * centre * length_m.cwiseAbs2() * centre;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const Eigen::Index d = std::min<Eigen::Index>(dimensions, n);
  Eigen::MatrixXd positions_m = Eigen::MatrixXd::Zero(dimensions, n);
  for (Eigen::Index k = 0; k < d; ++k)
    positions_m.row(k) = std::sqrt(std::max(eigen.eigenvalues()[n - 1 - k], 0.0)) *
                         eigen.eigenvectors().col(n - 1 - k).transpose();
  return positions_m;
}

Eigen::VectorXd stress_weights(const std::vector<RangeEdge>& edges, const Eigen::MatrixXd& positions_m) {
  Eigen::VectorXd residual_m(static_cast<Eigen::Index>(edges.size()));
  for (std::size_t e = 0; e < edges.size(); ++e)
    residual_m[static_cast<Eigen::Index>(e)] =
        std::abs((positions_m.col(edges[e].from) - positions_m.col(edges[e].to)).norm() - edges[e].length_m);
  std::vector<double> sorted(residual_m.begin(), residual_m.end());
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double scale_m = kResidualScale * std::max(sorted[sorted.size() / 2], 1e-6);
  return (1.0 + (residual_m / scale_m).array().square()).inverse();
}

/// Minimises the weighted stress, with new weights in each round.
void majorize(const std::vector<RangeEdge>& edges, Eigen::MatrixXd& positions_m) {
  const Eigen::Index n = positions_m.cols();
  for (int round = 0; round < kWeightRounds; ++round) {
    const Eigen::VectorXd weight = stress_weights(edges, positions_m);
    Eigen::MatrixXd laplacian = Eigen::MatrixXd::Constant(n, n, 1.0 / static_cast<double>(n));
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const double w = weight[static_cast<Eigen::Index>(e)];
      laplacian(edges[e].from, edges[e].to) -= w;
      laplacian(edges[e].to, edges[e].from) -= w;
      laplacian(edges[e].from, edges[e].from) += w;
      laplacian(edges[e].to, edges[e].to) += w;
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(laplacian);
    for (int step = 0; step < kMajorizations; ++step) {
      Eigen::MatrixXd target = Eigen::MatrixXd::Zero(n, positions_m.rows());
      for (std::size_t e = 0; e < edges.size(); ++e) {
        const Eigen::VectorXd v = positions_m.col(edges[e].from) - positions_m.col(edges[e].to);
        const Eigen::RowVectorXd pull = weight[static_cast<Eigen::Index>(e)] * edges[e].length_m /
                                        std::max(v.norm(), 1e-9) * v.transpose();
        target.row(edges[e].from) += pull;
        target.row(edges[e].to) -= pull;
      }
      positions_m = factor.solve(target).transpose();
    }
  }
}

}  // namespace

PlacedByRanges place_by_ranges(int points, const std::vector<RangeEdge>& edges, int dimensions, int start) {
  Neighbours neighbours(static_cast<std::size_t>(points));
  for (const RangeEdge& e : edges) {
    neighbours[static_cast<std::size_t>(e.from)].emplace_back(e.to, e.length_m);
    neighbours[static_cast<std::size_t>(e.to)].emplace_back(e.from, e.length_m);
  }
  PlacedByRanges placed;
  placed.column = largest_part(neighbours);
  std::vector<int> members;
  for (int p = 0; p < points; ++p)
    if (placed.column[static_cast<std::size_t>(p)] >= 0) members.push_back(p);
  if (members.size() < 2) return placed;
  Eigen::MatrixXd length_m(static_cast<Eigen::Index>(members.size()),
                           static_cast<Eigen::Index>(members.size()));
  for (Eigen::Index i = 0; i < length_m.rows(); ++i)
    length_m.row(i) = shortest_paths(neighbours, members[static_cast<std::size_t>(i)])(members).transpose();
  std::vector<RangeEdge> within;
  for (const RangeEdge& e : edges) {
    const int from = placed.column[static_cast<std::size_t>(e.from)],
              to = placed.column[static_cast<std::size_t>(e.to)];
    if (from >= 0 && to >= 0) within.push_back({from, to, e.length_m});
  }
  placed.positions_m = classical_scaling(length_m, dimensions);
  if (start > 0) {
    Random draws(static_cast<std::uint64_t>(start));
    const double size_m = kDisplacement * placed.positions_m.norm() / std::sqrt(placed.positions_m.size());
    for (double& coordinate_m : placed.positions_m.reshaped()) coordinate_m += size_m * draws.normal();
  }
  majorize(within, placed.positions_m);
  return placed;
}

RigidFit fit_rigidly(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to, bool reflected) {
  const Eigen::VectorXd from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  const Eigen::MatrixXd product = (to.colwise() - to_mean) * (from.colwise() - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::VectorXd sign = Eigen::VectorXd::Ones(from.rows());
  const bool flips = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0;
  if (flips != reflected) sign[sign.size() - 1] = -1.0;
  RigidFit fit;
  fit.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  fit.shift_m = to_mean - fit.rotation * from_mean;
  const Eigen::MatrixXd residual = ((fit.rotation * from).colwise() + fit.shift_m) - to;
  fit.rms_m = std::sqrt(residual.colwise().squaredNorm().mean());
  return fit;
}

}  // namespace octant::calib

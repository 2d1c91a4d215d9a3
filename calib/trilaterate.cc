// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/trilaterate.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace octant::calib {
namespace {

constexpr int kSubsets = 200;
constexpr int kSubsetSize = 6;

double robust_cost(const std::vector<RangeFrom>& ranges, const Eigen::Vector3d& p, double scale_m) {
  double cost = 0.0;
  for (const RangeFrom& r : ranges) {
    const double e = ((r.p_map_m - p).norm() - r.range_m) / scale_m;
    cost += std::log1p(e * e / 4);
  }
  return cost;
}

/// Spread of the places along their weakest direction, and that direction.
struct Spread {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), weakest = Eigen::Vector3d::UnitZ(), second = Eigen::Vector3d::UnitY();
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< ascending
};

Spread spread_of(const std::vector<RangeFrom>& ranges) {
  Spread s;
  for (const RangeFrom& r : ranges) s.mean += r.p_map_m / static_cast<double>(ranges.size());
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const RangeFrom& r : ranges) C += (r.p_map_m - s.mean) * (r.p_map_m - s.mean).transpose() / static_cast<double>(ranges.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(C);
  s.sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  s.weakest = eigen.eigenvectors().col(0);
  s.second = eigen.eigenvectors().col(1);
  return s;
}

class Solver {
 public:
  Solver(const std::vector<RangeFrom>& ranges, const TrilaterationOptions& options)
      : ranges_(ranges), options_(options), spread_(spread_of(ranges)) {
    for (int i = 0; i < 3; ++i)
      if (!options.held[static_cast<std::size_t>(i)]) free_.push_back(i);
  }

  /// Solutions of the linearised system on a subset; directions in which its places do not spread are found from the range.
  void candidates_of(const std::vector<std::size_t>& subset, std::vector<Eigen::Vector3d>& out) const {
    const auto n = static_cast<Eigen::Index>(subset.size());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const std::size_t i : subset) mean += ranges_[i].p_map_m / static_cast<double>(n);
    // Differences to the mean equation remove |p|^2.
    Eigen::MatrixXd A(n, 3);
    Eigen::VectorXd b(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const RangeFrom& r = ranges_[subset[static_cast<std::size_t>(k)]];
      const Eigen::Vector3d q = r.p_map_m - mean;
      A.row(k) = 2 * q.transpose();
      b[k] = q.squaredNorm() - r.range_m * r.range_m;
    }
    b.array() -= b.mean();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> open;
    for (int i = 0; i < 3; ++i) {
      // Below the noise of a range against its distance a direction is not observed by this subset.
      if (i < svd.singularValues().size() && svd.singularValues()[i] > 6 * options_.scale_m) {
        y += svd.matrixV().col(i) * (svd.matrixU().col(i).dot(b) / svd.singularValues()[i]);
      } else {
        open.push_back(svd.matrixV().col(i));
      }
    }
    // The mean equation gives |p|^2 = mean(r^2 - |q|^2), and so how far the solution lies along the open directions.
    double squares = 0.0;
    for (const std::size_t i : subset)
      squares += (std::pow(ranges_[i].range_m, 2) - (ranges_[i].p_map_m - mean).squaredNorm()) / static_cast<double>(n);
    const double rest = std::sqrt(std::max(0.0, squares - y.squaredNorm()));
    if (open.empty()) {
      out.push_back(mean + y);
    } else if (open.size() == 1) {
      for (const double sign : {1.0, -1.0}) out.push_back(mean + y + sign * rest * open[0]);
    } else {
      for (int k = 0; k < 8; ++k) {
        const double a = k * M_PI / 4;
        out.push_back(mean + y + rest * (std::cos(a) * open[0] + std::sin(a) * open.back()));
      }
    }
  }

  void impose_held(Eigen::Vector3d& p) const {
    for (int i = 0; i < 3; ++i)
      if (options_.held[static_cast<std::size_t>(i)]) p[i] = options_.guess[i];
  }

  /// Levenberg-Marquardt under Cauchy's loss, the scale shrinking to options.scale_m.
  Eigen::Vector3d refine(Eigen::Vector3d p, double start_scale_m, Eigen::Matrix3d* information = nullptr) const {
    for (double scale = start_scale_m; ; scale = std::max(scale / 3, options_.scale_m)) {
      double lambda = 1e-4, cost = robust_cost(ranges_, p, scale);
      for (int iteration = 0; iteration < 30; ++iteration) {
        Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        for (const RangeFrom& r : ranges_) {
          const Eigen::Vector3d v = p - r.p_map_m;
          const double d = std::max(v.norm(), 1e-6), e = (d - r.range_m) / scale, w = 0.25 / (1 + e * e / 4);
          H += w * v * v.transpose() / (d * d * scale * scale);
          g += w * e * v / (d * scale);
        }
        if (information != nullptr) *information = 4 * H * scale * scale / (options_.scale_m * options_.scale_m);
        H.diagonal() *= 1 + lambda;
        H.diagonal().array() += 1e-9 * (1.0 + H.trace());
        for (int i = 0; i < 3; ++i)
          if (options_.held[static_cast<std::size_t>(i)]) {
            H.row(i).setZero();
            H.col(i).setZero();
            H(i, i) = 1.0;
            g[i] = 0.0;
          }
        const Eigen::Vector3d step = -H.ldlt().solve(g);
        const double after = robust_cost(ranges_, p + step, scale);
        if (after <= cost) {
          p += step;
          lambda = std::max(lambda * 0.1, 1e-9);
          const bool still = step.norm() < 1e-7 || cost - after < 1e-10 * (1 + cost);
          cost = after;
          if (still) break;
        } else {
          lambda *= 10;
          if (lambda > 1e8) break;
        }
      }
      if (scale <= options_.scale_m) return p;
    }
  }

  [[nodiscard]] Trilateration solve() const {
    Trilateration out;
    if (ranges_.size() < free_.size()) return out;
    std::vector<Eigen::Vector3d> candidates;
    std::mt19937_64 random(ranges_.size());
    std::vector<std::size_t> subset;
    for (int k = 0; k < kSubsets; ++k) {
      subset.clear();
      for (int i = 0; i < kSubsetSize; ++i) subset.push_back(random() % ranges_.size());
      candidates_of(subset, candidates);
    }
    subset.resize(ranges_.size());
    for (std::size_t i = 0; i < subset.size(); ++i) subset[i] = i;
    candidates_of(subset, candidates);
    for (Eigen::Vector3d& p : candidates) impose_held(p);
    choose(candidates, out);
    return out;
  }

 private:
  void choose(const std::vector<Eigen::Vector3d>& candidates, Trilateration& out) const {
    const double coarse_m = 6 * options_.scale_m;
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (candidates[i].allFinite()) ranked.emplace_back(robust_cost(ranges_, candidates[i], coarse_m), i);
    std::sort(ranked.begin(), ranked.end());
    double best = INFINITY;
    for (std::size_t k = 0; k < std::min<std::size_t>(ranked.size(), 12); ++k) {
      const Eigen::Vector3d p = refine(candidates[ranked[k].second], coarse_m);
      const double cost = robust_cost(ranges_, p, options_.scale_m);
      if (cost < best) {
        best = cost;
        out.p_map_m = p;
      }
    }
    if (!std::isfinite(best)) return;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    out.p_map_m = refine(out.p_map_m, options_.scale_m, &information);
    finish(best, information, out);
  }

  /// Images of the solution in the plane of the places, and in the vertical plane through a straight track.
  void finish(double best, const Eigen::Matrix3d& information, Trilateration& out) const {
    out.cost = best;
    const bool flat = !options_.held[2] && std::abs(spread_.weakest.z()) > 0.99 && spread_.sigma[0] < options_.scale_m;
    if (flat && options_.above && out.p_map_m.z() < spread_.mean.z()) out.p_map_m.z() = 2 * spread_.mean.z() - out.p_map_m.z();
    for (const RangeFrom& r : ranges_)
      if (std::abs((r.p_map_m - out.p_map_m).norm() - r.range_m) < 3 * options_.scale_m) ++out.agreeing;
    for (const Eigen::Vector3d& normal : {spread_.weakest, spread_.second}) {
      if (flat && options_.above && std::abs(normal.z()) > 0.9) continue;  // settled by "above"
      Eigen::Vector3d p = out.p_map_m - 2 * normal.dot(out.p_map_m - spread_.mean) * normal;
      impose_held(p);
      p = refine(p, 2 * options_.scale_m);
      const double cost = robust_cost(ranges_, p, options_.scale_m);
      if ((p - out.p_map_m).norm() > 10 * options_.scale_m && cost < best + 8) {
        out.has_mirror = true;
        out.mirror_map_m = p;
      }
    }
    const auto free_count = static_cast<Eigen::Index>(free_.size());
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> F(free_count, free_count);
    for (std::size_t i = 0; i < free_.size(); ++i)
      for (std::size_t j = 0; j < free_.size(); ++j) F(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = information(free_[i], free_[j]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>> eigen(F);
    const double weakest = free_.empty() ? 1.0 : eigen.eigenvalues()[0];
    out.weakest_sigma_m = weakest > 0 ? 1 / std::sqrt(weakest) : INFINITY;
    out.ok = out.agreeing > static_cast<int>(free_.size());
  }

  const std::vector<RangeFrom>& ranges_;
  const TrilaterationOptions& options_;
  Spread spread_;
  std::vector<int> free_;
};

}  // namespace

Trilateration trilaterate(const std::vector<RangeFrom>& ranges, const TrilaterationOptions& options) {
  if (ranges.empty()) return {};
  return Solver(ranges, options).solve();
}

}  // namespace octant::calib

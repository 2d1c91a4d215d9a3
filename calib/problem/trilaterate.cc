// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/trilaterate.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

constexpr int kSubsets = 200;
constexpr int kSubsetSize = 6;

/// An image may explain the ranges worse by this in robust cost (four sigmas of one range) and still be as
/// good.
constexpr double kAsGood = 8.0;

/// Misfit of a ray divided by its standard deviation, which includes that of its origin; and this standard
/// deviation.
struct RayMisfit {
  double e = 0.0, sigma_rad = 1.0;
  Eigen::Vector2d v = Eigen::Vector2d::Zero();
  double distance2_m2 = 1.0;
};

RayMisfit misfit_of(const RayFrom& ray, const Eigen::Vector3d& p, double scale_m) {
  RayMisfit m;
  m.v = p.head<2>() - ray.p_map_m;
  m.distance2_m2 = std::max(m.v.squaredNorm(), 1e-12);
  m.sigma_rad = std::sqrt(ray.sigma_rad * ray.sigma_rad + scale_m * scale_m / m.distance2_m2);
  m.e = std::remainder(std::atan2(m.v.y(), m.v.x()) - ray.direction_rad, 2 * M_PI) / m.sigma_rad;
  return m;
}

double robust_cost(const std::vector<RangeFrom>& ranges, const std::vector<RayFrom>& rays,
                   const Eigen::Vector3d& p, double scale_m) {
  double cost = 0.0;
  for (const RangeFrom& r : ranges) {
    const double e = ((r.p_map_m - p).norm() - r.range_m) / scale_m;
    cost += std::log1p(e * e / 4);
  }
  for (const RayFrom& ray : rays) cost += std::log1p(std::pow(misfit_of(ray, p, scale_m).e, 2) / 4);
  return cost;
}

/// Spread of the places along their weakest direction, and that direction; and the weakest level one.
struct Spread {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), weakest = Eigen::Vector3d::UnitZ(),
                  second = Eigen::Vector3d::UnitY(), weakest_level = Eigen::Vector3d::UnitY();
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< ascending
};

Spread spread_of(const std::vector<RangeFrom>& ranges) {
  Spread s;
  for (const RangeFrom& r : ranges) s.mean += r.p_map_m / static_cast<double>(ranges.size());
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const RangeFrom& r : ranges)
    C += (r.p_map_m - s.mean) * (r.p_map_m - s.mean).transpose() / static_cast<double>(ranges.size());
  const SymmetricEigen<Eigen::Matrix3d> eigen(C);
  s.sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  s.weakest = eigen.eigenvectors().col(0);
  s.second = eigen.eigenvectors().col(1);
  const SymmetricEigen<Eigen::Matrix2d> level(Eigen::Matrix2d(C.topLeftCorner<2, 2>()));
  s.weakest_level.head<2>() = level.eigenvectors().col(0);
  s.weakest_level.z() = 0.0;
  return s;
}

class Solver {
 public:
  Solver(const std::vector<RangeFrom>& ranges, const std::vector<RayFrom>& rays,
         const TrilaterationOptions& options)
      : ranges_(ranges), rays_(rays), options_(options), spread_(spread_of(ranges)) {
    for (int i = 0; i < 3; ++i)
      if (!options.held[static_cast<std::size_t>(i)]) free_.push_back(i);
  }

  /// Solutions of the linearised system on a subset; directions in which its places do not spread are found
  /// from the range.
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
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeFullV);
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
    // The mean equation gives |p|^2 = mean(r^2 - |q|^2), and so how far the solution lies along the open
    // directions.
    double squares = 0.0;
    for (const std::size_t i : subset)
      squares += (std::pow(ranges_[i].range_m, 2) - (ranges_[i].p_map_m - mean).squaredNorm()) /
                 static_cast<double>(n);
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
  Eigen::Vector3d refine(Eigen::Vector3d p, double start_scale_m) const {
    for (double scale = start_scale_m;; scale = std::max(scale / 3, options_.scale_m)) {
      double lambda = 1e-4, cost = robust_cost(ranges_, rays_, p, scale);
      for (int iteration = 0; iteration < 30; ++iteration) {
        Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        for (const RangeFrom& r : ranges_) {
          const Eigen::Vector3d v = p - r.p_map_m;
          const double d = std::max(v.norm(), 1e-6), e = (d - r.range_m) / scale, w = 0.25 / (1 + e * e / 4);
          H += w * v * v.transpose() / (d * d * scale * scale);
          g += w * e * v / (d * scale);
        }
        for (const RayFrom& ray : rays_) add_ray(misfit_of(ray, p, scale), H, g);
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
        const double after = robust_cost(ranges_, rays_, p + step, scale);
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
    if (ranges_.size() + rays_.size() < free_.size()) return out;
    std::vector<Eigen::Vector3d> candidates;
    std::mt19937_64 random(ranges_.size());
    std::vector<std::size_t> subset;
    for (int k = 0; k < kSubsets && !ranges_.empty(); ++k) {
      subset.clear();
      for (int i = 0; i < kSubsetSize; ++i) subset.push_back(random() % ranges_.size());
      candidates_of(subset, candidates);
    }
    subset.resize(ranges_.size());
    for (std::size_t i = 0; i < subset.size(); ++i) subset[i] = i;
    if (!ranges_.empty()) candidates_of(subset, candidates);
    for (int k = 0; k < kSubsets && rays_.size() > 1; ++k) {
      const std::size_t first = random() % rays_.size(),
                        second = random() % rays_.size();  // in this order, whatever the compiler
      crossing_of(rays_[first], rays_[second], candidates);
    }
    for (Eigen::Vector3d& p : candidates) impose_held(p);
    choose(candidates, out);
    return out;
  }

  /// Images of a place in the plane of the places, and in the vertical plane through a straight track, that
  /// explain all nearly as well as the place does, which costs `best`, or better.
  /// @param scales_apart  nearer to the place they are no images
  template <class Visit>
  void for_each_image(const Eigen::Vector3d& place, double best, double scales_apart, Visit&& visit) const {
    if (ranges_.empty()) return;
    for (const Eigen::Vector3d& normal : normals()) {
      if (is_flat() && options_.above && std::abs(normal.z()) > 0.9) continue;  // decided by "above"
      Eigen::Vector3d p = place - 2 * normal.dot(place - spread_.mean) * normal;
      impose_held(p);
      p = refine(p, 2 * options_.scale_m);
      const double cost = robust_cost(ranges_, rays_, p, options_.scale_m);
      // Back on its own side it is no image, however far the ranges alone would have the place.
      const bool is_opposite = normal.dot(p - spread_.mean) * normal.dot(place - spread_.mean) < 0;
      if (is_opposite && (p - place).norm() > scales_apart * options_.scale_m && cost < best + kAsGood)
        visit(p, cost);
    }
  }
  [[nodiscard]] double cost_of(const Eigen::Vector3d& p) const {
    return robust_cost(ranges_, rays_, p, options_.scale_m);
  }

 private:
  /// Normals of the mirror planes. A beacon of known height has vertical planes only, and for positions on a
  /// line the weakest directions are any two across it.
  [[nodiscard]] std::vector<Eigen::Vector3d> normals() const {
    if (options_.held[2]) return {spread_.weakest_level};
    return {spread_.weakest, spread_.second};
  }

  void choose(const std::vector<Eigen::Vector3d>& candidates, Trilateration& out) const {
    const double coarse_m = 6 * options_.scale_m;
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (candidates[i].allFinite())
        ranked.emplace_back(robust_cost(ranges_, rays_, candidates[i], coarse_m), i);
    std::ranges::sort(ranked);
    double best = INFINITY;
    for (std::size_t k = 0; k < std::min<std::size_t>(ranked.size(), 12); ++k) {
      const Eigen::Vector3d p = refine(candidates[ranked[k].second], coarse_m);
      const double cost = robust_cost(ranges_, rays_, p, options_.scale_m);
      if (cost < best) {
        best = cost;
        out.p_map_m = p;
      }
    }
    if (!std::isfinite(best)) return;
    out.p_map_m = refine(out.p_map_m, options_.scale_m);
    finish(best, out);
  }

  /// Contribution of a ray to Gauss-Newton with Cauchy's loss and a fixed standard deviation.
  static void add_ray(const RayMisfit& m, Eigen::Matrix3d& H, Eigen::Vector3d& g) {
    const double w = 0.25 / (1 + m.e * m.e / 4);
    const Eigen::Vector2d J = Eigen::Vector2d(-m.v.y(), m.v.x()) / (m.distance2_m2 * m.sigma_rad);
    H.topLeftCorner<2, 2>() += w * J * J.transpose();
    g.head<2>() += w * m.e * J;
  }

  /// Where two rays meet, at the height of the guess.
  void crossing_of(const RayFrom& a, const RayFrom& b, std::vector<Eigen::Vector3d>& out) const {
    const Eigen::Vector2d u(std::cos(a.direction_rad), std::sin(a.direction_rad)),
        v(std::cos(b.direction_rad), std::sin(b.direction_rad));
    const double cross = u.x() * v.y() - u.y() * v.x();
    if (std::abs(cross) < 3 * std::max(a.sigma_rad, b.sigma_rad)) return;
    const Eigen::Vector2d between = b.p_map_m - a.p_map_m;
    const double along_a = (between.x() * v.y() - between.y() * v.x()) / cross,
                 along_b = (between.x() * u.y() - between.y() * u.x()) / cross;
    if (along_a <= 0 || along_b <= 0) return;
    const Eigen::Vector2d p = a.p_map_m + along_a * u;
    out.emplace_back(p.x(), p.y(), options_.guess.z());
  }

  [[nodiscard]] bool is_flat() const {
    return !options_.held[2] && std::abs(spread_.weakest.z()) > 0.99 && spread_.sigma[0] < options_.scale_m;
  }

  void finish(double best, Trilateration& out) const {
    if (is_flat() && options_.above && !ranges_.empty() && out.p_map_m.z() < spread_.mean.z())
      out.p_map_m.z() = 2 * spread_.mean.z() - out.p_map_m.z();
    for_each_image(out.p_map_m, best, 10.0, [&](const Eigen::Vector3d& image, double cost) {
      if (cost >= best) return;
      out.p_map_m = image;
      best = cost;
    });
    out.cost = best;
    for (const RangeFrom& r : ranges_)
      if (std::abs((r.p_map_m - out.p_map_m).norm() - r.range_m) < 3 * options_.scale_m) ++out.agreeing;
    for (const RayFrom& ray : rays_)
      if (std::abs(misfit_of(ray, out.p_map_m, options_.scale_m).e) < 3) ++out.agreeing;
    out.ok = out.agreeing > static_cast<int>(free_.size());
  }

  const std::vector<RangeFrom>& ranges_;
  const std::vector<RayFrom>& rays_;
  const TrilaterationOptions& options_;
  Spread spread_;
  std::vector<int> free_;
};

}  // namespace

Trilateration trilaterate(const std::vector<RangeFrom>& ranges, const TrilaterationOptions& options,
                          const std::vector<RayFrom>& rays) {
  if (ranges.empty() && rays.empty()) return {};
  return Solver(ranges, rays, options).solve();
}

std::optional<Eigen::Vector3d> mirror_image_of(const Eigen::Vector3d& p_map_m,
                                               const std::vector<RangeFrom>& ranges,
                                               const TrilaterationOptions& options) {
  std::optional<Eigen::Vector3d> image;
  if (ranges.empty()) return image;
  const std::vector<RayFrom> none;
  const Solver solver(ranges, none, options);
  double best = INFINITY;
  solver.for_each_image(p_map_m, solver.cost_of(p_map_m), 2.0, [&](const Eigen::Vector3d& p, double cost) {
    if (cost >= best) return;
    best = cost;
    image = p;
  });
  return image;
}

}  // namespace octant::calib

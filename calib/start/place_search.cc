// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/place_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"
#include "calib/start/mirror_images.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Number of grid positions to either side, in each free coordinate. Depending on the geometry, the error of
/// a position exceeds that of its ranges.
constexpr int kToEitherSide = 3;
/// Spacing of the grid: the largest error of this fraction of the ranges.
constexpr double kSpacingQuantile = 0.9;
/// Scale of the loss: in the beginning of the spacing, and from one to the next. A coarser one would take the
/// direct and the late arrivals together.
constexpr double kCoarseShare = 1.0 / 3, kNarrower = 3.0;
constexpr int kStepsEachScale = 4;
constexpr double kEarlyScale = 3.0;   ///< sound is late sooner than early
constexpr std::size_t kEnough = 300;  ///< size of the even sample of ranges
/// Share of a beacon's arrivals, and how many times that of the beacon in the middle.
constexpr double kManyDoNotFit = 0.2, kMoreThanOthers = 1.5;
constexpr std::size_t kMostLost = 8;

class PlaceSearch {
 public:
  PlaceSearch(const std::vector<RangeFrom>& ranges, const PlacePrior& prior, double sigma_m,
              double rejection_sigmas)
      : ranges_(some_of(ranges, kEnough)),
        prior_(prior),
        sigma_m_(sigma_m),
        cap_(0.5 * rejection_sigmas * rejection_sigmas) {}

  [[nodiscard]] double cap() const { return cap_; }

  [[nodiscard]] double misfit_m(const RangeFrom& r, const PlaceAndDelay& x) const {
    return r.range_m - x[3] - (x.head<3>() - r.p_map_m).norm();
  }

  [[nodiscard]] double cost(const PlaceAndDelay& x) const {
    double sum = 0.0;
    for (const RangeFrom& r : ranges_) {
      const double off = misfit_m(r, x) / sigma_m_;
      sum += std::min(cap_ + (off < 0 ? kEarlyIsRarer : 0.0), 0.5 * off * off);
    }
    for (Eigen::Index i = 0; i < 4; ++i)
      if (has_prior(i)) sum += 0.5 * std::pow((x[i] - prior_.mean[i]) / prior_.sigma[i], 2);
    return sum;
  }

  [[nodiscard]] double spacing_m(const PlaceAndDelay& x) const {
    std::vector<double> off_m;
    for (const RangeFrom& r : ranges_) off_m.push_back(std::abs(misfit_m(r, x)));
    const auto at = static_cast<std::ptrdiff_t>(kSpacingQuantile * static_cast<double>(off_m.size() - 1));
    std::nth_element(off_m.begin(), off_m.begin() + at, off_m.end());
    return off_m[static_cast<std::size_t>(at)];
  }

  /// Gauss-Newton by iteratively reweighted squares, the scale of the loss from coarse to the noise.
  [[nodiscard]] PlaceAndDelay descend(PlaceAndDelay x, double coarse_m) const {
    const double fine_m = kCauchyScale * sigma_m_;
    for (double scale_m = std::max(coarse_m, fine_m);; scale_m = std::max(scale_m / kNarrower, fine_m)) {
      for (int k = 0; k < kStepsEachScale; ++k) x += step(x, scale_m);
      if (scale_m == fine_m || !x.allFinite()) return x;
    }
  }

  [[nodiscard]] bool is_held(Eigen::Index i) const { return prior_.sigma[i] == 0.0; }

 private:
  [[nodiscard]] bool has_prior(Eigen::Index i) const {
    return std::isfinite(prior_.sigma[i]) && prior_.sigma[i] > 0.0;
  }

  [[nodiscard]] PlaceAndDelay step(const PlaceAndDelay& x, double scale_m) const {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    PlaceAndDelay g = PlaceAndDelay::Zero();
    for (const RangeFrom& r : ranges_) {
      const Eigen::Vector3d v = x.head<3>() - r.p_map_m;
      PlaceAndDelay by;
      by << v / std::max(v.norm(), 1e-9), 1.0;
      const double off_m = misfit_m(r, x);
      const double share = off_m / (off_m > 0.0 ? scale_m : kEarlyScale * scale_m);
      const double weight = 1.0 / std::pow(sigma_m_ * (1.0 + share * share), 2);
      H.noalias() += weight * by * by.transpose();
      g += weight * off_m * by;
    }
    for (Eigen::Index i = 0; i < 4; ++i) {
      if (!has_prior(i)) continue;
      const double information = 1.0 / (prior_.sigma[i] * prior_.sigma[i]);
      H(i, i) += information;
      g[i] += information * (prior_.mean[i] - x[i]);
    }
    // Fixed coordinates have no step; unobservable ones, such as a height in the plane of the receivers, have
    // a short one.
    const double least = 1e-9 * H.diagonal().maxCoeff();
    for (Eigen::Index i = 0; i < 4; ++i) {
      H(i, i) += least;
      if (!is_held(i)) continue;
      H.row(i).setZero();
      H.col(i).setZero();
      H(i, i) = 1.0;
      g[i] = 0.0;
    }
    const PlaceAndDelay full = H.ldlt().solve(g);
    return full * std::min(1.0, 3.0 * scale_m / std::max(full.norm(), 1e-12));
  }

  std::vector<RangeFrom> ranges_;
  const PlacePrior& prior_;
  double sigma_m_, cap_;
};

}  // namespace

std::optional<PlaceAndDelay> place_of_largest_consensus(const std::vector<RangeFrom>& ranges,
                                                        const PlacePrior& prior, const PlaceAndDelay& start,
                                                        double sigma_m, double rejection_sigmas) {
  if (ranges.size() < 4) return std::nullopt;
  const PlaceSearch search(ranges, prior, sigma_m, rejection_sigmas);
  const double spacing_m = search.spacing_m(start);
  double best = search.cost(start) - search.cap();
  std::optional<PlaceAndDelay> place;
  std::array<int, 3> sides;
  for (std::size_t i = 0; i < 3; ++i)
    sides[i] = search.is_held(static_cast<Eigen::Index>(i)) ? 0 : kToEitherSide;
  for (int i = -sides[0]; i <= sides[0]; ++i)
    for (int j = -sides[1]; j <= sides[1]; ++j)
      for (int k = -sides[2]; k <= sides[2]; ++k) {
        PlaceAndDelay from = start;
        from.head<3>() += spacing_m * Eigen::Vector3d(i, j, k);
        if (std::isfinite(prior.sigma[3])) from[3] = prior.mean[3];
        const PlaceAndDelay found = search.descend(from, kCoarseShare * spacing_m);
        const double cost = search.cost(found);
        if (!(cost < best)) continue;
        best = cost;
        place = found;
      }
  return place;
}

std::vector<std::size_t> beacons_that_do_not_fit(const AdjustedLog& log, double rejection_sigmas) {
  const ParameterLayout& layout = log.estimate.layout;
  const SharedState state = log.estimate.state();
  std::vector<double> placed(layout.beacon.size(), 0.0), off(placed);
  for (const Trajectory& t : log.trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      if (!t.nodes[a.node].placed || a.rejection != Rejection::kUsed) continue;
      placed[a.beacon.index()] += 1.0;
      off[a.beacon.index()] += std::abs(arrival_residual(t, a, state)) > rejection_sigmas ? 1.0 : 0.0;
    }
  for (std::size_t b = 0; b < off.size(); ++b) off[b] /= std::max(placed[b], 1.0);
  const double many = std::max(kManyDoNotFit, kMoreThanOthers * median(off));
  std::vector<std::pair<double, std::size_t>> lost;
  for (std::size_t b = 0; b < off.size(); ++b) {
    const std::array<int, 3>& columns = layout.beacon[b];
    if (off[b] >= many && *std::ranges::max_element(columns) >= 0) lost.emplace_back(-off[b], b);
  }
  std::ranges::sort(lost);
  if (lost.size() > kMostLost) lost.resize(kMostLost);
  std::vector<std::size_t> beacons;
  beacons.reserve(lost.size());
  for (const auto& [share, b] : lost) beacons.push_back(b);
  return beacons;
}

std::optional<Eigen::VectorXd> with_beacon_of_larger_consensus(const Problem& problem, const AdjustedLog& log,
                                                               std::size_t beacon, double rejection_sigmas) {
  const ParameterLayout& layout = log.estimate.layout;
  const Eigen::VectorXd& x = log.estimate.x;
  const std::array<int, 4> columns = layout.columns_of_beacon(beacon);
  const SharedState state = log.estimate.state();
  PlaceAndDelay now = PlaceAndDelay::Zero();  // ranges are those at the delay as it is
  now.head<3>() = state.beacon_p_map_m[beacon];
  PlacePrior prior;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    prior.sigma[row] = 0.0;
    if (columns[i] < 0) continue;
    const Parameter& p = layout.parameter(columns[i]);
    prior.mean[row] = p.prior_mean - (i == 3 ? x[columns[i]] : 0.0);
    prior.sigma[row] = p.prior_sigma;
  }
  const auto place =
      place_of_largest_consensus(ranges_to(log.trajectories, state, BeaconId(beacon)), prior, now,
                                 problem.site.noise.tof_sigma_s * layout.nominal_speed_mps, rejection_sigmas);
  if (!place) return std::nullopt;
  Eigen::VectorXd moved = x;
  for (std::size_t i = 0; i < 4; ++i)
    if (columns[i] >= 0)
      moved[columns[i]] = (i == 3 ? x[columns[i]] : 0.0) + (*place)[static_cast<Eigen::Index>(i)];
  return moved;
}

}  // namespace octant::calib

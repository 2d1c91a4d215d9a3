// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/plane_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "models/physics/plane.h"

namespace octant {
namespace {

/// Thresholds of the log likelihood for changing sides. The one for the whole track is higher: its side was
/// assumed, and only the heights of the beacons determine it, as accurately as they are known.
constexpr double kClear = 0.5, kWholeTrack = 6.0;

bool goes_below_zero(const std::vector<SpaceStep>& steps) {
  return std::ranges::any_of(steps, [](const SpaceStep& s) { return s.smoothed.x[2] < 0.0; });
}

/// Steps at which the track may pass through the plane, the local minima of the distance, between the first
/// step and the end.
std::vector<std::size_t> pieces_of(const std::vector<SpaceStep>& steps, const BeaconPlane& plane,
                                   double gate_sigmas) {
  std::vector<std::size_t> at = {0};
  const auto off_m = [&](std::size_t j) { return std::abs(plane.height_m(steps[j].smoothed.x.head<3>())); };
  for (std::size_t j = 1; j + 1 < steps.size(); ++j)
    if (is_near(plane, steps[j].smoothed, gate_sigmas) && off_m(j) <= off_m(j - 1) && off_m(j) < off_m(j + 1))
      at.push_back(j);
  at.push_back(steps.size());
  return at;
}

class Sides {
 public:
  Sides(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first,
        const std::vector<SpaceStep>& steps, double density)
      : ranges_(ranges),
        setting_(setting),
        first_(first),
        density_(density),
        steps_(steps),
        at_(pieces_of(steps, setting.plane, setting.options.rejection_sigmas)) {}

  std::vector<SpaceStep> likeliest() {
    std::vector<bool> turned = likeliest_turns();
    if (turned.empty()) return {};
    std::vector<SpaceStep> out = steps_;
    for (std::size_t p = 0; p < turned.size(); ++p)
      if (turned[p]) reflect(std::span(out).subspan(at_[p], at_[p + 1] - at_[p]));
    if (goes_below_zero(out) && !goes_below_zero(steps_)) return {};
    return out;
  }

 private:
  /// Pieces to be reflected; empty if there are no such pieces.
  std::vector<bool> likeliest_turns() {
    const std::size_t pieces = at_.size() - 1;
    // most[s]: best value of the pieces so far with the last one unchanged (0) or reflected (1); from: the
    // corresponding side of the piece before.
    std::array<double, 2> most{};
    std::vector<std::array<std::size_t, 2>> from;
    if (pieces == 1)
      most = {likelihood(0, steps_.size(), 0, {0, 0}), likelihood(0, steps_.size(), 0, {1, 1})};
    double as_it_is = most[0];
    for (std::size_t p = 1; p < pieces; ++p) {
      const std::size_t begin = p == 1 ? 0 : (at_[p - 1] + at_[p]) / 2;
      const std::size_t end = p + 1 == pieces ? steps_.size() : (at_[p] + at_[p + 1]) / 2;
      std::array<double, 2> next{-INFINITY, -INFINITY};
      from.push_back({0, 0});
      for (std::size_t before = 0; before < 2; ++before)
        for (std::size_t after = 0; after < 2; ++after) {
          const double told = likelihood(begin, end, at_[p], {before, after});
          if (before == 0 && after == 0) as_it_is += told;
          if (!(most[before] + told > next[after])) continue;
          next[after] = most[before] + told;
          from.back()[after] = before;
        }
      most = next;
    }
    std::size_t side = most[1] > most[0] ? 1 : 0;
    const double gain = most[side] - as_it_is;
    if (!(gain > kClear)) return {};
    std::vector<bool> turned(pieces);
    std::size_t count = 0;
    for (std::size_t p = pieces; p-- > 0;) {
      turned[p] = side == 1;
      if (turned[p]) count += at_[p + 1] - at_[p];
      if (p > 0) side = from[p - 1][side];
    }
    // Motion determines which pieces are on the same side, but only the heights of the beacons determine that
    // side.
    const bool tells = heights_decide();
    if (count == steps_.size() && !(tells && gain > kWholeTrack)) return {};
    if (!tells && 2 * count > steps_.size()) turned.flip();
    return turned;
  }

  /// Returns true if the beacons deviate from their plane by more than the accuracy of their heights.
  [[nodiscard]] bool heights_decide() const {
    constexpr double kSigmas = 3.0;
    double sum_m2 = 0.0;
    for (const double variance_m2 : setting_.off_plane_m2) sum_m2 += variance_m2;
    return setting_.plane.off_m >
           kSigmas * std::sqrt(sum_m2 / static_cast<double>(setting_.off_plane_m2.size()));
  }

  void reflect(std::span<SpaceStep> steps) const {
    for (SpaceStep& s : steps)
      s.smoothed.x.head<3>() -= 2 * setting_.plane.height_m(s.smoothed.x.head<3>()) * setting_.plane.normal;
  }

  /// Log likelihood of the arrivals of steps [begin, end) with the parts before and after `passage` reflected
  /// or not.
  double likelihood(std::size_t begin, std::size_t end, std::size_t passage,
                    std::array<std::size_t, 2> reflected) {
    std::vector<SpaceStep> about(steps_.begin() + static_cast<std::ptrdiff_t>(begin),
                                 steps_.begin() + static_cast<std::ptrdiff_t>(end));
    const std::size_t before = passage > begin ? passage - begin : 0;
    if (reflected[0] == 1) reflect(std::span(about).first(before));
    if (reflected[1] == 1) reflect(std::span(about).subspan(before));
    // Starts in the plane, so that neither side is preferred.
    const Eigen::Vector3d place = steps_[begin].smoothed.x.head<3>();
    const Eigen::Vector3d start = place - setting_.plane.height_m(place) * setting_.plane.normal;
    SpaceFilter part(ranges_, setting_, first_ + begin, start_at(start, Eigen::Matrix3d::Zero(), setting_),
                     density_);
    part.linearise_at(about);
    return part.iterate(first_ + end);
  }

  SpaceRanges& ranges_;
  const SpaceSetting& setting_;
  std::size_t first_;
  double density_;
  const std::vector<SpaceStep>& steps_;
  std::vector<std::size_t> at_;  ///< beginnings of the pieces, and the end
};

}  // namespace

bool is_near(const BeaconPlane& plane, const SpaceBelief& belief, double sigmas) {
  const Eigen::Matrix3d P = belief.P.topLeftCorner<3, 3>();
  const double sigma_m = std::sqrt(std::max(0.0, plane.normal.dot(P * plane.normal)));
  return std::abs(plane.height_m(belief.x.head<3>())) < sigmas * sigma_m;
}

std::vector<SpaceStep> likeliest_sides(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first,
                                       const std::vector<SpaceStep>& steps, double density) {
  return Sides(ranges, setting, first, steps, density).likeliest();
}

}  // namespace octant

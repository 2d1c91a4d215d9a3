// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/plane_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "models/physics/plane.h"
#include "models/validity.h"

namespace octant {
namespace {

/// Thresholds of the log likelihood for changing sides. The one for the whole track is higher: its side was
/// assumed, and only the heights of the beacons determine it, as accurately as they are known.
constexpr double kClear = 0.5, kWholeTrack = 6.0;
/// Log prior of a track outside the space for which the deployment is calibrated, if its mirror image is
/// inside: it decides the side of a whole track, but does not outweigh a passage through the plane that is
/// observed well.
constexpr double kOutside = 2.0 * kWholeTrack;

bool goes_below_zero(const std::vector<SpaceStep>& steps) {
  return std::ranges::any_of(steps, [](const SpaceStep& s) { return s.smoothed.x[2] < 0.0; });
}

/// Returns true if a position is farther outside the calibrated space than its margin.
bool is_outside(const Eigen::Vector3d& p, const SpaceSetting& setting) {
  return distance_from_validity_m(setting.deployment, p) > kAreaMargin * setting.extent_m;
}

/// Returns true if the beacons deviate from their plane by more than the accuracy of their heights.
bool do_heights_decide(const SpaceSetting& setting) {
  constexpr double kSigmas = 3.0;
  double sum_m2 = 0.0;
  for (const double variance_m2 : setting.off_plane_m2) sum_m2 += variance_m2;
  return setting.plane.off_m > kSigmas * std::sqrt(sum_m2 / static_cast<double>(setting.off_plane_m2.size()));
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
    const std::vector<std::array<double, 2>> prior = log_priors();
    for (const std::size_t s : {0, 1})
      most[s] = prior[0][s] + (pieces == 1 ? likelihood(0, steps_.size(), 0, {s, s}) : 0.0);
    double as_it_is = most[0];
    for (std::size_t p = 1; p < pieces; ++p) {
      const std::size_t begin = p == 1 ? 0 : (at_[p - 1] + at_[p]) / 2;
      const std::size_t end = p + 1 == pieces ? steps_.size() : (at_[p] + at_[p + 1]) / 2;
      std::array<std::array<double, 2>, 2> likelihoods{};
      for (const std::size_t before : {0, 1})
        for (const std::size_t after : {0, 1})
          likelihoods[before][after] = likelihood(begin, end, at_[p], {before, after});
      // A part that is lost whatever the sides are does not distinguish them.
      if (std::max({likelihoods[0][0], likelihoods[0][1], likelihoods[1][0], likelihoods[1][1]}) == -INFINITY)
        likelihoods = {};
      as_it_is += likelihoods[0][0] + prior[p][0];
      std::array<double, 2> next{-INFINITY, -INFINITY};
      from.push_back({0, 0});
      for (const std::size_t after : {0, 1})
        for (const std::size_t before : {0, 1}) {
          const double value = most[before] + likelihoods[before][after] + prior[p][after];
          if (!(value > next[after])) continue;
          next[after] = value;
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
    double prior_gain = 0.0;  // of these sides, relative to the opposite ones
    for (std::size_t p = 0; p < pieces; ++p) prior_gain += prior[p][turned[p]] - prior[p][!turned[p]];
    const bool tells = do_heights_decide(setting_) || std::abs(prior_gain) > kWholeTrack;
    if (count == steps_.size() && !(tells && gain > kWholeTrack)) return {};
    if (!tells && 2 * count > steps_.size()) turned.flip();
    return turned;
  }

  /// Log prior of each piece, unchanged and reflected.
  [[nodiscard]] std::vector<std::array<double, 2>> log_priors() const {
    std::vector<std::array<double, 2>> prior(at_.size() - 1);
    const double each = kOutside / static_cast<double>(steps_.size());
    for (std::size_t p = 0; p + 1 < at_.size(); ++p)
      for (std::size_t j = at_[p]; j < at_[p + 1]; ++j) {
        const Eigen::Vector3d place = steps_[j].smoothed.x.head<3>();
        prior[p][0] -= each * is_outside(place, setting_);
        prior[p][1] -= each * is_outside(setting_.plane.mirrored(place), setting_);
      }
    return prior;
  }

  void reflect(std::span<SpaceStep> steps) const {
    for (SpaceStep& s : steps) s.smoothed.x.head<3>() = setting_.plane.mirrored(s.smoothed.x.head<3>());
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

bool is_mirror_image_possible(const Eigen::Vector3d& p, const SpaceSetting& setting) {
  return setting.plane.coplanar && setting.deployment.validity_heights_m && !do_heights_decide(setting) &&
         !is_outside(setting.plane.mirrored(p), setting);
}

bool is_near(const BeaconPlane& plane, const SpaceBelief& belief, double sigmas) {
  const Eigen::Matrix3d P = belief.P.topLeftCorner<3, 3>();
  const double sigma_m = std::sqrt(std::max(0.0, plane.normal.dot(P * plane.normal)));
  return std::abs(plane.height_m(belief.x.head<3>())) < sigmas * sigma_m;
}

double log_prior(const std::vector<SpaceStep>& steps, const SpaceSetting& setting) {
  const auto outside = std::ranges::count_if(
      steps, [&](const SpaceStep& s) { return is_outside(s.smoothed.x.head<3>(), setting); });
  return -kOutside * static_cast<double>(outside) / static_cast<double>(steps.size());
}

std::vector<SpaceStep> likeliest_sides(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first,
                                       const std::vector<SpaceStep>& steps, double density) {
  return Sides(ranges, setting, first, steps, density).likeliest();
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_track.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "models/localizers/common/open_attitude.h"
#include "models/localizers/common/separation.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/space/plane_sides.h"
#include "models/localizers/space/space_filter.h"
#include "models/localizers/space/space_ranges.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr std::size_t kPoseArrivals =
    7;  ///< number of arrivals at an instant for a checked pose with six degrees of freedom
constexpr std::ptrdiff_t kAttitudeReceivers = 3;  ///< receivers of a vehicle that determine its attitude
constexpr int kTailRounds = 6;             ///< most rounds in which sigmas of lasting errors are widened
constexpr std::size_t kMostRepeats = 5;    ///< of the number of instants; single fixes follow, in linear time
constexpr int kMostSides = 4;              ///< number of rounds in which the sides of a track are examined
constexpr std::size_t kFewestBeacons = 3;  ///< number of beacons that determine a position in space
/// Candidate densities of the white-noise acceleration [m^2/s^3]: from a carried tripod to a racing drone.
constexpr std::array kDensities = {0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0};

class SpaceTracker {
 public:
  SpaceTracker(const MeasurementLog& log, VehicleId vehicle, const Deployment& deployment,
               const SpaceTrackOptions& options)
      : setting_(deployment, options),
        vehicle_(vehicle),
        ranges_(ranges_in_space(log, vehicle, setting_)),
        alone_(deployment) {}

  void run(std::vector<Fix>& fixes) {
    std::size_t k = 0;
    while (k < ranges_.instants.size()) {
      if (setting_.in_line) {
        fixes.push_back(no_fix(k++, FixStatus::kPoorGeometry));
        continue;
      }
      Fix alone = fix_alone(k);
      std::optional<SpaceStart> start;
      const bool may_track = repeated_ <= kMostRepeats * ranges_.instants.size();
      if (may_track && alone.protection_level_m > 0.0)
        start = start_at(alone.T_map_vehicle.translation_m, alone.covariance.topLeftCorner<3, 3>().inverse(),
                         setting_);
      if (may_track && !start) start = place_in_space(ranges_, k, setting_);
      const std::size_t next = start ? follow(k, *start, fixes) : k;
      if (next <= k) fixes.push_back(std::move(alone));
      k = std::max(next, k + 1);
    }
  }

 private:
  /// @return one past the last tracked instant
  std::size_t follow(std::size_t k, const SpaceStart& start, std::vector<Fix>& fixes) {
    double most = -INFINITY, density = kDensities.front();
    std::size_t end = k;
    for (const double tried : kDensities) {
      SpaceFilter track(ranges_, setting_, k, start, tried);
      const std::size_t reached = track.filter(ranges_.instants.size());
      if (reached < end || (reached == end && !(track.likelihood() > most))) continue;
      end = reached;
      most = track.likelihood();
      density = tried;
    }
    std::optional<SpaceFilter> found;
    for (std::size_t agreed = end; end > k + 1; end = agreed) {
      found.emplace(track_until(end, k, start, density));
      agreed = contradicted_from(k, found->steps());
      if (agreed == k + found->steps().size()) break;
      repeated_ += end - agreed;
    }
    if (end <= k + 1) return k;
    // The arrivals that led to the loss belong to the next track.
    const bool lost = end < ranges_.instants.size();
    const std::vector<SpaceStep>& steps = found->steps();
    std::size_t kept = steps.size();
    while (lost && kept > 0 && !is_heard(k + kept - 1)) --kept;
    if (!is_supported(k, k + kept, lost)) return k;
    const bool side_is_open = comes_near_the_plane(steps);
    const std::size_t before = fixes.size();
    for (std::size_t j = 0; j < kept; ++j) fixes.push_back(fix_at(k + j, steps[j].smoothed, side_is_open));
    if (setting_.options.protect && kept > 0)
      protect(steps, k, start, density, std::span(fixes).subspan(before));
    return k + kept;
  }

  /// Track of instants [k, end), with the sides of the beacons' plane and the sigmas of lasting errors.
  [[nodiscard]] SpaceFilter track_until(std::size_t end, std::size_t k, const SpaceStart& start,
                                        double density) {
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.all.size(); ++i)
      ranges_.all[i].widening = 1.0;
    SpaceFilter track(ranges_, setting_, k, start, density);
    track.iterate(end);
    choose_sides(track, k, density, end);
    // Weights that decrease with the root of the error have a single solution, at which the others begin.
    for (const double power : {0.5, 1.0})
      for (int round = 0; round < kTailRounds && track.widen_tails(power); ++round) {
        track.filter(end);
        track.smooth();
      }
    return track;
  }

  /// First instant at which fixes of single instants contradict the track and agree with more arrivals; one
  /// past its last instant if there is none. A path that becomes late slowly can lead a track away from all
  /// other beacons.
  [[nodiscard]] std::size_t contradicted_from(std::size_t k, const std::vector<SpaceStep>& steps) {
    constexpr int kInARow = 3;
    int contradictions = 0;
    std::size_t first = k;
    for (std::size_t j = k; j < k + steps.size(); ++j) {
      const std::size_t agreeing = agreeing_at(j);
      if (agreeing == ranges_.instants[j].last - ranges_.instants[j].first) continue;
      const Fix alone = fix_alone(j);
      if (!(alone.protection_level_m > 0.0)) continue;
      const SpaceBelief& belief = steps[j - k].smoothed;
      const Eigen::Vector3d off = alone.T_map_vehicle.translation_m - belief.x.head<3>();
      const Eigen::Matrix3d P = alone.covariance.topLeftCorner<3, 3>() + belief.P.topLeftCorner<3, 3>();
      if (static_cast<std::size_t>(alone.arrivals_used) <= agreeing ||
          off.dot(P.ldlt().solve(off)) < square(kAtFaultSigmas)) {
        contradictions = 0;
        continue;
      }
      if (contradictions++ == 0) first = j;
      if (contradictions == kInARow) return first;
    }
    return k + steps.size();
  }

  /// Chooses sides of the beacons' plane, as long as others are more likely over the whole track.
  void choose_sides(SpaceFilter& track, std::size_t k, double density, std::size_t end) {
    if (!setting_.plane.coplanar) return;
    for (int round = 0; round < kMostSides; ++round) {
      const std::vector<SpaceStep> was = track.steps();
      const double before = track.likelihood() + log_prior(was, setting_);
      const std::vector<SpaceStep> about = likeliest_sides(ranges_, setting_, k, was, density);
      if (!about.empty()) {
        track.linearise_at(about);
        if (track.iterate(end) + log_prior(track.steps(), setting_) > before) continue;
      }
      track.linearise_at(was);
      track.iterate(end);  // marks the arrivals again
      return;
    }
  }

  /// Protection levels of the fixes along a track: each is compared with the track without one of the
  /// beacons, filtered and smoothed again from its start, with its outliers determined again (solution
  /// separation, separation.h). If a single beacon determines the side of the others' plane, the side is lost
  /// without it.
  void protect(const std::vector<SpaceStep>& steps, std::size_t k, const SpaceStart& start, double density,
               std::span<Fix> fixes) {
    const auto ranges = std::span(ranges_.all)
                            .subspan(ranges_.instants[k].first,
                                     ranges_.instants[k + fixes.size() - 1].last - ranges_.instants[k].first);
    const std::vector<SpaceRange> marked(ranges.begin(), ranges.end());
    std::set<BeaconId> beacons;
    double variance_m2 = 0.0;
    for (const SpaceRange& r : marked)
      if (r.rejection == Rejection::kUsed) {
        beacons.insert(r.arrival.beacon);
        variance_m2 = std::max(variance_m2, r.variance_m2);
      }
    const double range_sigma_m = std::sqrt(variance_m2 + square(setting_.bias_sigma_m));
    std::vector<double> levels_m(fixes.size(), 0.0);
    bool all_determined = beacons.size() > kFewestBeacons;
    for (auto beacon = beacons.begin(); beacon != beacons.end() && all_determined; ++beacon) {
      for (SpaceRange& r : ranges)
        if (r.arrival.beacon == *beacon) r.rejection = Rejection::kBeaconFault;
      SpaceFilter without(ranges_, setting_, k, start, density);
      without.linearise_at(steps);
      all_determined = without.filter(k + fixes.size()) == k + fixes.size();
      if (all_determined) {
        without.smooth();
        without.filter(k + fixes.size());  // linearised at the track without the beacon
        without.smooth();
        BeaconPlane plane = beacon_plane(setting_.deployment, setting_.extent_m, *beacon);
        plane.coplanar = plane.coplanar && plane.off_m < kAtFaultSigmas * range_sigma_m;
        for (std::size_t j = 0; j < fixes.size(); ++j)
          hold_against(without.steps()[j].smoothed, steps[j].smoothed, plane, fixes[j], levels_m[j]);
      }
      std::ranges::copy(marked, ranges.begin());
    }
    for (std::size_t j = 0; all_determined && j < fixes.size(); ++j)
      if (fixes[j].ok() && std::isfinite(levels_m[j]))
        fixes[j].protection_level_m =
            protection_level_m(horizontal_variance(fixes[j].covariance), levels_m[j]);
  }

  /// @param level_m  is increased; infinite if the fix without the beacon contradicts
  void hold_against(const SpaceBelief& without, const SpaceBelief& with, const BeaconPlane& plane,
                    const Fix& fix, double& level_m) const {
    const Eigen::Vector3d p = without.x.head<3>();
    double shift_m = (p - with.x.head<3>()).head<2>().norm();
    const double widened = std::max(1.0, horizontal_variance(fix.covariance) / horizontal_variance(with.P));
    const double sigma_m = std::sqrt(widened * horizontal_variance(without.P));
    if (!(shift_m <= kAtFaultSigmas * sigma_m)) level_m = INFINITY;
    if (plane.coplanar && !setting_.plane.coplanar)
      shift_m += 2 * std::abs(plane.height_m(p)) * plane.normal.head<2>().norm();
    level_m = std::max(level_m, shift_m + kFaultySigmas * sigma_m);
  }

  /// A track far from the plane of the beacons keeps its side; one that may have passed through it does not.
  [[nodiscard]] bool comes_near_the_plane(const std::vector<SpaceStep>& steps) const {
    if (!setting_.plane.coplanar) return false;
    return std::ranges::any_of(steps, [this](const SpaceStep& step) {
      return is_near(setting_.plane, step.smoothed, setting_.options.rejection_sigmas);
    });
  }

  /// Returns true if the arrivals of instants [first, last) support a track: most of them agree, and if it
  /// was lost afterwards, there are more than a filter accepts from a wrong position.
  [[nodiscard]] bool is_supported(std::size_t first, std::size_t last, bool lost) const {
    constexpr std::size_t kFewestBeforeLoss = 20;
    std::size_t used = 0, outliers = 0;
    for (std::size_t k = first; k < last; ++k)
      for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i) {
        used += ranges_.all[i].rejection == Rejection::kUsed;
        outliers += is_outlier(ranges_.all[i].rejection);
      }
    return used > outliers && (!lost || used >= kFewestBeforeLoss);
  }

  /// Number of arrivals of an instant that agree with the track without a wider sigma.
  [[nodiscard]] std::size_t agreeing_at(std::size_t k) const {
    std::size_t count = 0;
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
      count += ranges_.all[i].rejection == Rejection::kUsed && ranges_.all[i].widening <= 1.0;
    return count;
  }

  [[nodiscard]] bool is_heard(std::size_t k) const {
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
      if (ranges_.all[i].rejection == Rejection::kUsed) return true;
    return false;
  }

  [[nodiscard]] Fix no_fix(std::size_t k, FixStatus status) const {
    Fix fix;
    fix.status = status;
    fix.time_s = ranges_.instants[k].time_s;
    fix.epoch = ranges_.instants[k].epoch;
    fix.vehicle = vehicle_;
    fix.arrivals_rejected = static_cast<int>(ranges_.instants[k].last - ranges_.instants[k].first);
    return fix;
  }

  [[nodiscard]] Fix fix_alone(std::size_t k) {
    std::vector<Arrival> arrivals;
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
      arrivals.push_back(ranges_.all[i].arrival);
    Fix fix = alone_.locate(arrivals);
    fix.time_s = ranges_.instants[k].time_s;
    return fix;
  }

  /// Covariance of position (from state 0) or velocity (from state 3), with the part of the calibration.
  [[nodiscard]] Eigen::Matrix3d covariance_at(const SpaceBelief& belief, Eigen::Index state) const {
    const Eigen::MatrixXd M = belief.M.middleRows<3>(state);
    Eigen::Matrix3d P = belief.P.block<3, 3>(state, state);
    if (M.cols() > 0) P += M * setting_.calibration.covariance() * M.transpose();
    return P;
  }

  /// @param side_is_open  the mirror image is equally likely: half of the squared distance between both is
  /// added
  [[nodiscard]] Fix fix_at(std::size_t k, const SpaceBelief& belief, bool side_is_open) const {
    Fix fix = no_fix(k, FixStatus::kNoConsensus);
    fix.arrivals_rejected = 0;
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i) {
      fix.rejections.push_back(ranges_.all[i].rejection);
      ++(ranges_.all[i].rejection == Rejection::kUsed ? fix.arrivals_used : fix.arrivals_rejected);
    }
    fix.T_map_vehicle.translation_m = belief.x.head<3>();
    Eigen::Matrix3d P = covariance_at(belief, 0);
    fix.velocity.emplace();
    fix.velocity->mean.head<3>() = belief.x.segment<3>(3);
    fix.velocity->variance << covariance_at(belief, 3).diagonal(),
        Eigen::Vector3d::Constant(kUnknownRotationVariance);
    P.diagonal().array() += open_attitude_variance_m2(setting_.p_centre_vehicle_m);
    if (side_is_open || is_mirror_image_possible(belief.x.head<3>(), setting_))
      P += 2 * square(setting_.plane.height_m(belief.x.head<3>())) * setting_.plane.normal *
           setting_.plane.normal.transpose();
    fix.covariance = Eigen::MatrixXd::Zero(6, 6);
    fix.covariance.topLeftCorner<3, 3>() = 0.5 * (P + P.transpose());
    fix.covariance.diagonal().tail<3>().setConstant(kUnknownRotationVariance);
    const double largest = P.diagonal().maxCoeff();
    fix.status =
        largest < square(setting_.extent_m) && largest > 0 ? FixStatus::kOk : FixStatus::kPoorGeometry;
    return fix;
  }

  SpaceSetting setting_;
  VehicleId vehicle_;
  SpaceRanges ranges_;
  std::size_t repeated_ = 0;     ///< instants that were tracked and then left to another track
  LeastSquaresLocalizer alone_;  ///< for instants without a track
};

}  // namespace

bool may_track_in_space(const Deployment& deployment, const MeasurementLog& log) {
  return deployment.motion == Motion::kSpatial && log.odometry.empty() && !log.arrivals.empty() &&
         deployment.timing.clock == Clock::kSynchronised &&
         std::ranges::none_of(deployment.vehicles, [](const SiteVehicle& v) { return v.motion.has_value(); });
}

bool is_drive_in_space(const Deployment& deployment, const MeasurementLog& log) {
  if (!may_track_in_space(deployment, log)) return false;
  std::size_t poses = 0, rich = 0, steps = 0, gaps = 0;
  bool has_attitude = false;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v) {
    const RowsByPose<Arrival> rows(log.arrivals, VehicleId(v), log.has_epochs);
    poses += rows.count();
    for (std::size_t i = 0; i < rows.count(); ++i) {
      rich += rows.pose(i).size() >= kPoseArrivals;
      if (i == 0) continue;
      ++steps;
      gaps += middle_time_s(rows.pose(i)) - middle_time_s(rows.pose(i - 1)) > SpaceTrackOptions{}.max_gap_s;
    }
    const auto own = [v](const DeploymentReceiver& r) { return r.vehicle == VehicleId(v); };
    has_attitude = has_attitude || std::ranges::count_if(deployment.receivers, own) >= kAttitudeReceivers;
  }
  if (log.has_epochs && 2 * gaps >= steps) return false;
  return !has_attitude || 2 * rich < poses;
}

std::vector<Fix> track_in_space(const MeasurementLog& log, const Deployment& deployment,
                                const SpaceTrackOptions& options) {
  std::vector<Fix> fixes;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v)
    SpaceTracker(log, VehicleId(v), deployment, options).run(fixes);
  std::ranges::stable_sort(fixes, {}, &Fix::time_s);
  return fixes;
}

}  // namespace octant

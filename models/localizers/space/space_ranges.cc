// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_ranges.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include <Eigen/Cholesky>

#include "models/localizers/common/open_attitude.h"
#include "models/localizers/common/rows_by_pose.h"
#include "models/physics/plane.h"
#include "models/support/decompositions.h"
#include "models/validity.h"

namespace octant {
namespace {

constexpr std::size_t kMostBiases = 24;  ///< largest number of beacons with their own Gauss-Markov state
constexpr double kSearch_s = 2.0;        ///< longest time over which a position is searched
constexpr double kCoplanar =
    0.05;  ///< relative to the extent of the beacons: ranges do not distinguish the sides
constexpr double kAlike = 6.0;  ///< in half squares: two positions explain the arrivals equally well

/// Position of a nearly stationary vehicle: robust Gauss-Newton from points around the beacons.
class PlaceSearch {
 public:
  PlaceSearch(const SpaceRanges& ranges, std::size_t first, std::size_t last, const SpaceSetting& setting)
      : ranges_(ranges), first_(first), last_(last), setting_(setting) {}

  [[nodiscard]] std::optional<SpaceStart> best() const {
    std::set<std::size_t> beacons;
    for (std::size_t i = first_; i < last_; ++i)
      if (ranges_.all[i].rejection == Rejection::kUsed) beacons.insert(ranges_.all[i].arrival.beacon.index());
    if (beacons.size() < 3) return std::nullopt;
    std::vector<std::pair<double, Eigen::Vector3d>> found;
    const double e = 0.4 * setting_.extent_m;
    for (const Eigen::Vector3d& step :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, -1, 0),
          Eigen::Vector3d(-1, 1, 0), Eigen::Vector3d(-1, -1, 0)})
      for (const double up : {-0.5, 0.5}) {
        Eigen::Vector3d p = setting_.plane.centre_m + e * (step + Eigen::Vector3d(0, 0, up));
        found.emplace_back(descend(p), p);
      }
    std::ranges::sort(found, [](const auto& a, const auto& b) { return a.first < b.first; });
    if (!std::isfinite(found.front().first)) return std::nullopt;
    Eigen::Vector3d place = found.front().second;
    for (const auto& [cost, p] : found)
      if (cost < found.front().first + kAlike && is_likelier(p, place)) place = p;
    // The arrivals of a beacon share its lasting error.
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    accumulate(place, &H, &g);
    return start_at(place, H * (static_cast<double>(beacons.size()) / static_cast<double>(last_ - first_)),
                    setting_);
  }

 private:
  /// Prefers, of two mirror images, the one nearer to the calibrated poses. If that does not decide, prefers
  /// the one above the floor and below the beacons.
  [[nodiscard]] bool is_likelier(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    const double nearer_m =
        distance_from_validity_m(setting_.deployment, b) - distance_from_validity_m(setting_.deployment, a);
    if (std::abs(nearer_m) > kAreaMargin * setting_.extent_m) return nearer_m > 0;
    if ((a.z() >= 0) != (b.z() >= 0)) return a.z() >= 0;
    return a.z() >= 0 && a.z() < b.z() - 0.01 * setting_.extent_m;
  }

  /// @return half the robust sum of squares at the position that p converges to
  double descend(Eigen::Vector3d& p) const {
    double cost = INFINITY, damping = 1e-3;
    for (int round = 0; round < 60; ++round) {
      Eigen::Matrix3d H = 1e-6 * Eigen::Matrix3d::Identity();
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      accumulate(p, &H, &g);
      Eigen::Matrix3d D = H;
      D.diagonal() *= 1 + damping;
      const Eigen::Vector3d step = -D.ldlt().solve(g);
      const Eigen::Vector3d q = p + step;
      const double there = accumulate(q, nullptr, nullptr), here = accumulate(p, nullptr, nullptr);
      cost = here;
      if (there < here) {
        p = q;
        cost = there;
        damping = std::max(1e-9, damping / 5);
        if (step.norm() < 1e-4 * setting_.extent_m * 1e-2) break;
      } else if ((damping *= 8) > 1e8) {
        break;
      }
    }
    return cost;
  }

  double accumulate(const Eigen::Vector3d& p, Eigen::Matrix3d* H, Eigen::Vector3d* g) const {
    double cost = 0.0;
    for (std::size_t i = first_; i < last_; ++i) {
      const SpaceRange& r = ranges_.all[i];
      if (r.rejection != Rejection::kUsed) continue;
      const Eigen::Vector3d d = p - r.p_beacon_m;
      const double length = std::max(1e-9, d.norm()), residual = length - r.distance.range_m;
      // The vehicle may move by a share of the speed's sigma in this time; lasting errors do not average out.
      const double moved = 0.1 * setting_.options.speed_sigma_mps *
                           (ranges_.all[last_ - 1].arrival.time_s - ranges_.all[first_].arrival.time_s);
      const Eigen::Vector3d u = d / length;
      // The deviation of a beacon from the plane distinguishes mirror images, within its accuracy.
      const double off_plane =
          square(u.dot(setting_.plane.normal)) * setting_.off_plane_m2[r.arrival.beacon.index()];
      const double variance = r.variance_m2 + square(setting_.bias_sigma_m) + square(moved) + off_plane;
      const double s = square(residual) / variance, weight = 1 / (1 + s / 5.7);
      cost += 0.5 * 5.7 * std::log1p(s / 5.7);
      if (H == nullptr) continue;
      *H += weight / variance * u * u.transpose();
      *g += weight / variance * residual * u;
    }
    return cost;
  }

  const SpaceRanges& ranges_;
  std::size_t first_, last_;
  const SpaceSetting& setting_;
};

/// A linear function of the calibrated parameters: columns of their covariance with factors.
using LinearForm = std::vector<std::pair<int, double>>;

/// Adds the position of a beacon along a direction, times the direction's length.
void add_place(const CalibrationPart& calibration, BeaconId beacon, const Eigen::Vector3d& along,
               LinearForm& form) {
  ObservationRow row;
  row.has_shared = true;
  row.beacon = beacon;
  row.by_beacon = along.transpose();
  calibration.for_each_coupling(row, [&](int at, double by) { form.emplace_back(at, by); });
}

double variance_of_form(const LinearForm& form, const Eigen::MatrixXd& covariance) {
  double variance = 0.0;
  for (const auto& [i, by_i] : form)
    for (const auto& [j, by_j] : form) variance += by_i * by_j * covariance(i, j);
  return variance;
}

/// Returns true if the root-mean-square distance of the beacons from their best-fitting line is within two
/// sigmas of its calibration, or of a range.
bool are_in_line(const SpaceSetting& s) {
  constexpr double kSigmas = 2.0;
  std::vector<BeaconId> beacons;
  for (std::size_t b = 0; b < s.deployment.beacons.size(); ++b)
    if (s.deployment.beacons[b].status != BeaconStatus::kUndetermined) beacons.emplace_back(b);
  if (beacons.size() < 3) return false;  // too few for a start
  const auto n = static_cast<double>(beacons.size());
  double off_m2 = 0.0, sigma_m2 = square(s.range_sigma_m);
  for (const BeaconId beacon : beacons)
    for (const Eigen::Vector3d& axis : {s.plane.normal, s.plane.across}) {
      off_m2 += square(axis.dot(s.deployment.beacons[beacon.index()].position_m - s.plane.centre_m)) / n;
      LinearForm form;  // relative to the centre of all
      for (const BeaconId other : beacons)
        add_place(s.calibration, other, ((other == beacon ? 1.0 : 0.0) - 1.0 / n) * axis, form);
      sigma_m2 += variance_of_form(form, s.calibration.covariance()) / n;
    }
  return off_m2 < square(kSigmas) * sigma_m2;
}

}  // namespace

SpaceSetting::SpaceSetting(const Deployment& d, const SpaceTrackOptions& o)
    : deployment(d), options(o), calibration(d) {
  const double c = d.speed_mps(d.medium.temperature_degC);
  const CorrelatedNoise& errors = d.correlated_noise;
  bias_sigma_m = c * std::hypot(errors.sigma_s, errors.pair_sigma_s);
  range_sigma_m = std::hypot(c * d.noise.tof_sigma_s, bias_sigma_m);
  // One state for both parts, with the correlation time of the larger one.
  const double lasting =
      square(errors.pair_sigma_s) / std::max(1e-300, square(errors.pair_sigma_s) + square(errors.sigma_s));
  bias_time_s = std::max(1e-3, errors.time_s) / std::max(1e-3, 1.0 - lasting);
  std::size_t usable = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const DeploymentBeacon& b : d.beacons) {
    const bool has_state = errors.any() && usable < kMostBiases && b.status != BeaconStatus::kUndetermined;
    bias.push_back(has_state ? static_cast<int>(size++) : -1);
    if (b.status == BeaconStatus::kUndetermined) continue;
    ++usable;
    low = low.cwiseMin(b.position_m);
    high = high.cwiseMax(b.position_m);
  }
  if (usable > 1) extent_m = std::max(1e-3, (high - low).norm());
  plane = beacon_plane(d, extent_m);
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    LinearForm form;
    add_place(calibration, BeaconId(b), plane.normal, form);
    off_plane_m2.push_back(variance_of_form(form, calibration.covariance()));
  }
  in_line = are_in_line(*this);
}

BeaconPlane beacon_plane(const Deployment& deployment, double extent_m, BeaconId without) {
  BeaconPlane plane;
  std::vector<Eigen::Vector3d> places;
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b)
    if (deployment.beacons[b].status != BeaconStatus::kUndetermined && BeaconId(b) != without)
      places.push_back(deployment.beacons[b].position_m);
  const auto count = static_cast<double>(places.size());
  for (const Eigen::Vector3d& p : places) plane.centre_m += p;
  if (!places.empty()) plane.centre_m /= count;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : places) spread += (p - plane.centre_m) * (p - plane.centre_m).transpose();
  const SymmetricEigen<Eigen::Matrix3d> axes(spread);
  plane.coplanar = places.size() < 4 || axes.eigenvalues()[0] < square(kCoplanar * extent_m) * count;
  plane.off_m = std::sqrt(std::max(0.0, axes.eigenvalues()[0]) / std::max(1.0, count));
  plane.normal = axes.eigenvectors().col(0);
  plane.across = axes.eigenvectors().col(1);
  return plane;
}

namespace {

SpaceRange range_of(const Arrival& a, const SpaceSetting& setting) {
  const Deployment& d = setting.deployment;
  SpaceRange r{a, arrival_range(a, d), d.beacons[a.beacon.index()].position_m};
  if (d.beacons[a.beacon.index()].status == BeaconStatus::kUndetermined)
    r.rejection = Rejection::kBeaconUnusable;
  if (!std::isfinite(r.distance.range_m)) r.rejection = Rejection::kOutOfRange;
  // A receiver off the centre lies on a sphere around it.
  r.variance_m2 =
      square(r.distance.sigma_m) +
      open_attitude_variance_m2(d.receivers[a.receiver.index()].position_m - setting.p_centre_vehicle_m);
  if (setting.bias[a.beacon.index()] < 0) r.variance_m2 += square(setting.bias_sigma_m);
  return r;
}

double median_range_m(const SpaceRanges& ranges) {
  std::vector<double> ranges_m;
  for (const SpaceRange& r : ranges.all)
    if (r.rejection == Rejection::kUsed) ranges_m.push_back(r.distance.range_m);
  if (ranges_m.empty()) return 0.0;
  const auto middle = ranges_m.begin() + static_cast<std::ptrdiff_t>(ranges_m.size() / 2);
  std::ranges::nth_element(ranges_m, middle);
  return *middle;
}

}  // namespace

SpaceRanges ranges_in_space(const MeasurementLog& log, VehicleId vehicle, SpaceSetting& setting) {
  const Deployment& d = setting.deployment;
  setting.p_centre_vehicle_m = receiver_centre_m(d, vehicle);
  SpaceRanges ranges;
  const RowsByPose<Arrival> rows(log.arrivals, vehicle, log.has_epochs);
  for (std::size_t pose = 0; pose < rows.count(); ++pose) {
    const std::span<const Arrival> together = rows.pose(pose);
    const std::size_t first = ranges.all.size();
    for (const Arrival& a : together)
      if (a.beacon.valid() && a.receiver.valid() && a.receiver.index() < d.receivers.size() &&
          a.beacon.index() < d.beacons.size())
        ranges.all.push_back(range_of(a, setting));
    if (ranges.all.size() == first) continue;
    const double time_s = log.has_epochs ? middle_time_s(together) : ranges.all.back().arrival.time_s;
    ranges.instants.push_back({time_s, together.front().epoch, first, ranges.all.size()});
  }
  setting.reach_m = std::max(setting.extent_m, median_range_m(ranges));
  return ranges;
}

SpaceStart start_at(const Eigen::Vector3d& p_map_m, const Eigen::Matrix3d& information_per_m2,
                    const SpaceSetting& setting) {
  constexpr double kWider = 3.0;  ///< in sigmas, for the motion within the arrivals of the start
  const Eigen::Matrix3d information =
      information_per_m2 / square(kWider) + Eigen::Matrix3d::Identity() / square(setting.extent_m);
  return {p_map_m, information.inverse()};
}

std::optional<SpaceStart> place_in_space(const SpaceRanges& ranges, std::size_t k,
                                         const SpaceSetting& setting) {
  const std::size_t first = ranges.instants[k].first;
  std::optional<SpaceStart> place;
  for (const double span_s : {0.1, 0.3, 1.0, kSearch_s}) {
    std::size_t last = ranges.instants[k].last, count = 0;
    std::set<std::size_t> beacons;
    for (std::size_t j = k;
         j < ranges.instants.size() && ranges.instants[j].time_s <= ranges.instants[k].time_s + span_s; ++j)
      last = ranges.instants[j].last;
    for (std::size_t i = first; i < last; ++i) {
      beacons.insert(ranges.all[i].arrival.beacon.index());
      ++count;
    }
    if (beacons.size() < 3 || count < 6) continue;
    place = PlaceSearch(ranges, first, last, setting).best();
    if (place && beacons.size() >= 4) break;
  }
  return place;
}

}  // namespace octant

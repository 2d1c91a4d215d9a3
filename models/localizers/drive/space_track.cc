// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/space_track.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "models/localizers/drive/space_ranges.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr std::size_t kPoseArrivals = 7;  ///< of an instant, with which six degrees of freedom are checked
constexpr Eigen::Index kMostCalibrated = 200;  ///< parameters that are followed through the smoother
constexpr int kRelinearisations = 2;
constexpr std::size_t kRecent = 20,
                      kLost = 14;  ///< so many of the latest arrivals rejected: the place is lost
/// Densities of the white-noise acceleration that are tried [m^2/s^3]: from a tripod that is carried to a
/// racing drone.
constexpr std::array kDensities = {0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0};

/// Mean and covariance of position, velocity and biases, and how the mean follows the calibrated parameters.
struct Belief {
  Eigen::VectorXd x;
  Eigen::MatrixXd P, M;
};
struct Step {
  Belief predicted, updated, smoothed;
  Eigen::MatrixXd F;
};

/// Filter and smoother over consecutive instants.
class Track {
 public:
  Track(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first, const Eigen::Vector3d& start,
        double density)
      : ranges_(ranges), setting_(setting), first_(first), density_(density) {
    const Eigen::Index n = setting.size;
    const Eigen::Index p = setting.calibration.covariance().rows();
    now_.x = Eigen::VectorXd::Zero(n);
    now_.x.head<3>() = start;
    now_.P = Eigen::MatrixXd::Zero(n, n);
    now_.P.diagonal().head<3>().setConstant(square(setting.extent_m));
    now_.P.diagonal().segment<3>(3).setConstant(square(setting.options.speed_sigma_mps));
    now_.P.diagonal().tail(n - 6).setConstant(square(setting.bias_sigma_m));
    now_.M = Eigen::MatrixXd::Zero(n, p <= kMostCalibrated ? p : 0);
    start_ = now_;
    height_m_ = start.z();
  }

  /// Filters on to the instant `end`, or until the place is lost.
  /// @return the instant behind the last one
  std::size_t filter(std::size_t end) {
    steps_.clear();
    now_ = start_;
    likelihood_ = 0.0;
    since_held_s_ = INFINITY;
    std::vector<bool> recent;
    for (std::size_t k = first_; k < end; ++k) {
      const double dt = k == first_ ? 0.0 : ranges_.instants[k].time_s - ranges_.instants[k - 1].time_s;
      if (dt > setting_.options.max_gap_s) return k;
      Step step;
      step.F = predict(dt);
      step.predicted = now_;
      hold_within_site(dt);
      for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
        if (is_candidate(ranges_.all[i])) recent.push_back(!update(ranges_.all[i], k - first_));
      step.updated = now_;
      steps_.push_back(std::move(step));
      if (recent.size() > kRecent)
        recent.erase(recent.begin(), recent.end() - static_cast<std::ptrdiff_t>(kRecent));
      if (static_cast<std::size_t>(std::count(recent.begin(), recent.end(), true)) >= kLost) return k + 1;
    }
    return end;
  }

  void smooth() {
    if (steps_.empty()) return;
    steps_.back().smoothed = steps_.back().updated;
    for (std::size_t k = steps_.size() - 1; k-- > 0;) {
      const Belief &here = steps_[k].updated, &ahead = steps_[k + 1].predicted,
                   &told = steps_[k + 1].smoothed;
      const Eigen::MatrixXd G = ahead.P.ldlt().solve(steps_[k + 1].F * here.P).transpose();
      Belief& out = steps_[k].smoothed;
      out.x = here.x + G * (told.x - ahead.x);
      out.P = here.P + G * (told.P - ahead.P) * G.transpose();
      out.M = here.M + G * (told.M - ahead.M);
    }
    about_.clear();
    for (const Step& s : steps_) about_.push_back(s.smoothed.x);
  }

  [[nodiscard]] double likelihood() const { return likelihood_; }
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }

 private:
  static bool is_candidate(const SpaceRange& r) {
    return r.mark == Rejection::kUsed || r.mark == Rejection::kLate || r.mark == Rejection::kEarly;
  }

  Eigen::MatrixXd predict(double dt) {
    const Eigen::Index n = setting_.size;
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(n, n);
    F.topLeftCorner<3, 3>().setIdentity();
    F.block<3, 3>(0, 3) = dt * Eigen::Matrix3d::Identity();
    const double kept = std::exp(-dt / setting_.bias_time_s);
    F.diagonal().tail(n - 6).setConstant(kept);
    now_.x = F * now_.x;
    now_.P = F * now_.P * F.transpose();
    now_.M = F * now_.M;
    for (Eigen::Index i = 0; i < 3; ++i) {
      now_.P(i, i) += density_ * dt * dt * dt / 3;
      now_.P(i, i + 3) += density_ * dt * dt / 2;
      now_.P(i + 3, i) += density_ * dt * dt / 2;
      now_.P(i + 3, i + 3) += density_ * dt;
    }
    now_.P.diagonal().tail(n - 6).array() += square(setting_.bias_sigma_m) * (1 - kept * kept);
    return F;
  }

  /// The vehicle does not leave the site: without this a height that coplanar beacons hardly tell would drift
  /// away with the velocity.
  void hold_within_site(double dt) {
    since_held_s_ += dt;
    if (dt > 0 && since_held_s_ < 1.0) return;
    since_held_s_ = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double mean = i == 2 ? height_m_ : setting_.centre_m[i];
      const double sigma = i == 2 ? 0.25 * setting_.extent_m : setting_.extent_m;
      Eigen::VectorXd H = Eigen::VectorXd::Unit(setting_.size, i);
      correct(H, mean - now_.x[i], square(sigma), Eigen::VectorXd::Zero(now_.M.cols()));
    }
  }

  void correct(const Eigen::VectorXd& H, double innovation, double variance,
               const Eigen::VectorXd& by_calibration) {
    const Eigen::VectorXd PH = now_.P * H;
    const double S = H.dot(PH) + variance;
    const Eigen::VectorXd K = PH / S;
    now_.x += K * innovation;
    now_.P -= K * PH.transpose();
    now_.P = (0.5 * (now_.P + now_.P.transpose())).eval();
    now_.M += K * (by_calibration.transpose() - H.transpose() * now_.M);
  }

  /// @return whether the arrival agrees
  bool update(SpaceRange& r, std::size_t k) {
    const bool again = k < about_.size();
    const Eigen::Vector3d p =
        again ? Eigen::Vector3d(about_[k].head<3>()) : Eigen::Vector3d(now_.x.head<3>());
    const Eigen::Vector3d d = p - r.p_beacon_m;
    const double length = std::max(1e-9, d.norm());
    const Eigen::Vector3d u = d / length;
    Eigen::VectorXd H = Eigen::VectorXd::Zero(setting_.size);
    H.head<3>() = u;
    const int bias = setting_.bias[r.arrival.beacon.index()];
    if (bias >= 0) H[bias] = 1.0;
    const double innovation = r.distance.range_m - length - H.dot(now_.x) + u.dot(p);
    const double S = H.dot(now_.P * H) + r.variance_m2, squares = square(innovation) / S;
    const double limit = square(setting_.options.rejection_sigmas);
    likelihood_ -= 0.5 * (std::min(squares, limit) + std::log(S));
    r.mark = squares <= limit ? Rejection::kUsed : innovation > 0 ? Rejection::kLate : Rejection::kEarly;
    if (r.mark != Rejection::kUsed) return false;
    correct(H, innovation, r.variance_m2, by_calibration(r, u));
    return true;
  }

  /// Derivative of range less distance by the calibrated parameters.
  [[nodiscard]] Eigen::VectorXd by_calibration(const SpaceRange& r, const Eigen::Vector3d& u) const {
    Eigen::VectorXd by = Eigen::VectorXd::Zero(now_.M.cols());
    if (by.size() == 0) return by;
    ObservationRow row;
    row.has_shared = true;
    row.beacon = r.arrival.beacon;
    row.receiver = r.arrival.receiver;
    row.by_beacon = u.transpose();
    row.by_receiver.setZero();
    row.by_attenuation.setZero();
    row.by_delay = -r.distance.gain_mps;
    row.by_speed = r.distance.by_speed_s();
    setting_.calibration.for_each_coupling(row, [&](int at, double derivative) { by[at] += derivative; });
    return by;
  }

  SpaceRanges& ranges_;
  const SpaceSetting& setting_;
  std::size_t first_;
  double density_, height_m_ = 0.0, likelihood_ = 0.0, since_held_s_ = INFINITY;
  Belief start_, now_;
  std::vector<Step> steps_;
  std::vector<Eigen::VectorXd> about_;  ///< smoothed states to linearise at
};

class SpaceTracker {
 public:
  SpaceTracker(const MeasurementLog& log, VehicleId vehicle, const Deployment& deployment,
               const SpaceTrackOptions& options)
      : setting_(deployment, options), vehicle_(vehicle), ranges_(ranges_in_space(log, vehicle, setting_)) {}

  void run(std::vector<Fix>& fixes) {
    std::size_t k = 0;
    while (k < ranges_.instants.size()) {
      const auto start = place_in_space(ranges_, k, setting_);
      const std::size_t next = start ? follow(k, *start, fixes) : k;
      if (next <= k) fixes.push_back(no_fix(k));
      k = std::max(next, k + 1);
    }
  }

 private:
  /// @return the instant behind the last one that was tracked
  std::size_t follow(std::size_t k, const Eigen::Vector3d& start, std::vector<Fix>& fixes) {
    double most = -INFINITY, density = kDensities.front();
    std::size_t end = k;
    for (const double tried : kDensities) {
      Track track(ranges_, setting_, k, start, tried);
      const std::size_t reached = track.filter(ranges_.instants.size());
      if (reached < end || (reached == end && !(track.likelihood() > most))) continue;
      end = reached;
      most = track.likelihood();
      density = tried;
    }
    // What led to the loss belongs to what comes.
    const bool lost = end < ranges_.instants.size();
    if (end <= k + 1) return k;
    Track track(ranges_, setting_, k, start, density);
    track.filter(end);
    for (int round = 0; round < kRelinearisations; ++round) {
      track.smooth();
      track.filter(end);
    }
    track.smooth();
    std::size_t kept = track.steps().size();
    while (lost && kept > 0 && !is_heard(k + kept - 1)) --kept;
    const bool side_is_open = comes_near_the_plane(track.steps());
    for (std::size_t j = 0; j < kept; ++j)
      fixes.push_back(fix_at(k + j, track.steps()[j].smoothed, side_is_open));
    return k + kept;
  }

  [[nodiscard]] double height_over_plane_m(const Belief& belief) const {
    return setting_.normal.dot(Eigen::Vector3d(belief.x.head<3>()) - setting_.centre_m);
  }

  /// A track that stays clear of the plane of the beacons keeps its side; one that may have gone through it
  /// does not.
  [[nodiscard]] bool comes_near_the_plane(const std::vector<Step>& steps) const {
    if (!setting_.coplanar) return false;
    return std::any_of(steps.begin(), steps.end(), [this](const Step& step) {
      const Eigen::Matrix3d P = step.smoothed.P.topLeftCorner<3, 3>();
      const double sigma = std::sqrt(std::max(0.0, setting_.normal.dot(P * setting_.normal)));
      return std::abs(height_over_plane_m(step.smoothed)) < setting_.options.rejection_sigmas * sigma;
    });
  }

  [[nodiscard]] bool is_heard(std::size_t k) const {
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
      if (ranges_.all[i].mark == Rejection::kUsed) return true;
    return false;
  }

  [[nodiscard]] Fix no_fix(std::size_t k) const {
    Fix fix;
    fix.status = FixStatus::kNoConsensus;
    fix.time_s = ranges_.instants[k].time_s;
    fix.vehicle = vehicle_;
    fix.arrivals_rejected = static_cast<int>(ranges_.instants[k].last - ranges_.instants[k].first);
    return fix;
  }

  /// @param side_is_open  it may as well be at the mirror image: half of the squares between both counts
  [[nodiscard]] Fix fix_at(std::size_t k, const Belief& belief, bool side_is_open) const {
    Fix fix = no_fix(k);
    fix.arrivals_rejected = 0;
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i) {
      fix.rejections.push_back(ranges_.all[i].mark);
      ++(ranges_.all[i].mark == Rejection::kUsed ? fix.arrivals_used : fix.arrivals_rejected);
    }
    fix.T_map_vehicle.translation_m = belief.x.head<3>();
    const Eigen::MatrixXd M = belief.M.topRows<3>();
    Eigen::Matrix3d P = belief.P.topLeftCorner<3, 3>();
    if (M.cols() > 0) P += M * setting_.calibration.covariance() * M.transpose();
    P.diagonal().array() += setting_.lever_m2;
    if (side_is_open)
      P += 2 * square(height_over_plane_m(belief)) * setting_.normal * setting_.normal.transpose();
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
};

}  // namespace

bool is_drive_in_space(const Deployment& deployment, const MeasurementLog& log) {
  if (deployment.motion != Motion::kSpatial || log.has_epochs || !log.odometry.empty() ||
      log.arrivals.empty() || deployment.timing.clock != Clock::kSynchronised)
    return false;
  for (const SiteVehicle& v : deployment.vehicles)
    if (v.motion) return false;
  std::size_t instants = 0, rich = 0, size = 0;
  double last_s = -INFINITY;
  for (const Arrival& a : log.arrivals) {
    if (a.time_s - last_s > kSamePing_s) {
      rich += size >= kPoseArrivals;
      size = 0;
      ++instants;
    }
    last_s = a.time_s;
    ++size;
  }
  rich += size >= kPoseArrivals;
  const bool one_antenna = deployment.receivers.size() <= deployment.vehicles.size();
  return one_antenna || 2 * rich < instants;
}

std::vector<Fix> track_in_space(const MeasurementLog& log, const Deployment& deployment,
                                const SpaceTrackOptions& options) {
  std::vector<Fix> fixes;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v)
    SpaceTracker(log, VehicleId(v), deployment, options).run(fixes);
  std::stable_sort(fixes.begin(), fixes.end(),
                   [](const Fix& a, const Fix& b) { return a.time_s < b.time_s; });
  return fixes;
}

}  // namespace octant

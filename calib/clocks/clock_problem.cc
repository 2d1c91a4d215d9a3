// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/clock_problem.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Cholesky>

#include "calib/clocks/clock_lines.h"
#include "models/trajectory/odometry_path.h"

namespace octant::calib {
namespace {

/// Receptions of a moving transmitter within this time share a point [s].
constexpr double kSameInstant_s = 0.02;
/// Random walk of a clock between two knots, as a share of the noise of a reception.
constexpr double kWalkShare = 0.3;
constexpr std::size_t kMostKnots = 400;
/// Knots and packets between beacons that suffice for a start.
constexpr std::size_t kStartKnots = 6, kStartPackets = 80;
/// A beacon is known where its sigma is below this share of the extent of the site.
constexpr double kKnownShare = 0.25;

class ProblemMaker {
 public:
  ProblemMaker(const Site& site, const std::vector<MeasurementLog>& runs, const std::vector<ClockLog>& logs,
               const ClockModel& clocks, std::size_t most_points)
      : runs_(runs), logs_(logs), most_points_(most_points) {
    p_.site = site;
    p_.clocks = clocks;
    p_.speed_mps = speed_mps(site.medium);
    p_.sigma_m = p_.speed_mps * site.noise.tof_sigma_s;
    const double deviation = clocks.allan_deviation * p_.speed_mps;
    p_.phase_walk_m2 = deviation * deviation;
    p_.rate_walk_m2 = 3.0 * p_.phase_walk_m2 / (kFlicker_s * kFlicker_s);
  }

  ClockProblem make() {
    for (std::size_t run = 0; run < logs_.size(); ++run) add_run(run);
    choose_reference();
    spread_points();
    for (std::size_t run = 0; run < logs_.size(); ++run) {
      set_lines(run);
      set_knots(run);
    }
    set_extent();
    for (std::size_t run = 0; run < logs_.size(); ++run) add_motions(run);
    set_datum();
    return std::move(p_);
  }

 private:
  struct Raw {
    std::size_t run = 0;
    Transmission transmission;
    int point = -1;
  };

  void add_run(std::size_t run) {
    std::vector<Transmission> all = transmissions_of(logs_[run].differences, p_.site.beacons.size());
    all.insert(all.end(), logs_[run].transmissions.begin(), logs_[run].transmissions.end());
    std::ranges::stable_sort(all, {}, &Transmission::time_s);
    for (Transmission& t : all) {
      if (t.receptions.size() < 2) continue;
      Raw raw{run, std::move(t), -1};
      raw.point = point_of(run, raw.transmission);
      raw_.push_back(std::move(raw));
    }
  }

  /// Point of the vehicle that a transmission starts or ends at; -1 between beacons.
  int point_of(std::size_t run, const Transmission& t) {
    DeviceId device = t.source;
    for (const TimeStamp& r : t.receptions)
      if (p_.is_beacon(device)) device = r.device;
    if (p_.is_beacon(device)) return -1;
    const VehicleId vehicle = p_.site.receivers[device.index() - p_.site.beacons.size()].vehicle;
    const double window_s = t.is_difference ? kDifferenceWindow_s : kSameInstant_s;
    const auto [it, is_new] = open_.try_emplace({run, vehicle.index(), t.epoch}, p_.points.size());
    const bool is_later =
        !is_new && t.epoch == kNoEpoch && t.time_s - p_.points[it->second].time_s > window_s;
    if (!is_new && !is_later) return static_cast<int>(it->second);
    it->second = p_.points.size();
    ClockPoint point{run, vehicle, t.time_s, t.epoch, {}, 0.0, Eigen::Matrix3d::Identity()};
    const MeasurementLog& log = runs_[run];
    if (Pose T;
        log.vehicle == vehicle && interpolate_poses(log.poses, t.time_s, log.pose_accuracy.max_gap_s, T)) {
      point.measured_m = T.translation_m;
      point.measured_sigma_m = std::max(log.pose_accuracy.position_sigma_m, kExactPositionM);
      if (log.pose_accuracy.heading_known) point.R_map_vehicle = T.rotation.toRotationMatrix();
    }
    p_.points.push_back(point);
    return static_cast<int>(it->second);
  }

  /// Keeps evenly spread points and packets, if the problem is for a start.
  void spread_points() {
    if (most_points_ == 0) return;
    const std::size_t step = std::max<std::size_t>(1, (p_.points.size() + most_points_ - 1) / most_points_);
    std::vector<int> kept(p_.points.size(), -1);
    std::vector<ClockPoint> points;
    for (std::size_t i = 0; i < p_.points.size(); i += step) {
      kept[i] = static_cast<int>(points.size());
      points.push_back(p_.points[i]);
    }
    p_.points = std::move(points);
    std::size_t packets = 0, packet = 0;
    for (const Raw& r : raw_) packets += r.point < 0;
    const std::size_t packet_step = packets / kStartPackets + 1;
    std::erase_if(raw_, [&](Raw& r) {
      if (r.point < 0) return packet++ % packet_step != 0;
      r.point = kept[static_cast<std::size_t>(r.point)];
      return r.point < 0;
    });
  }

  void choose_reference() {
    std::vector<std::size_t> count(p_.clocks.names.size(), 0);
    for (const Raw& raw : raw_)
      for (const TimeStamp& r : raw.transmission.receptions)
        if (p_.is_beacon(r.device)) ++count[static_cast<std::size_t>(p_.clocks.of_device[r.device.index()])];
    p_.reference_clock = static_cast<int>(std::ranges::max_element(count) - count.begin());
  }

  /// Subtracts the lines of the clocks and an approximate time of transmission from the receptions of a run.
  void set_lines(std::size_t run) {
    std::vector<const Transmission*> of_run;
    for (const Raw& raw : raw_)
      if (raw.run == run) of_run.push_back(&raw.transmission);
    const ClockLines lines = clock_lines(of_run, p_.clocks, p_.reference_clock);
    p_.lines.push_back(lines.line);
    p_.middle_s.push_back(lines.middle_s);
    p_.base_s.push_back(of_run.empty() ? 0.0 : lines.time_s.front() - of_run.front()->time_s);
    std::size_t k = 0;
    for (const Raw& raw : raw_) {
      if (raw.run != run) continue;
      const double sent_s = lines.after_s[k], time_s = lines.time_s[k];
      ++k;
      for (const TimeStamp& r : raw.transmission.receptions)
        p_.receptions.push_back(
            {p_.transmissions, static_cast<int>(run), raw.point, raw.transmission.source, r.device, time_s,
             p_.speed_mps *
                 (r.after_s - sent_s - lines.offset_s(p_.clocks.of_device[r.device.index()], time_s))});
      ++p_.transmissions;
    }
  }

  /// Knots so close that a clock walks between them by a share of the noise, as far as there are
  /// transmissions.
  void set_knots(std::size_t run) {
    std::vector<double> times;
    for (const ClockReception& r : p_.receptions)
      if (r.run == static_cast<int>(run)) times.push_back(r.time_s);
    if (times.empty()) times.push_back(0.0);
    const auto [first, last] = std::ranges::minmax(times);
    std::ranges::sort(times);
    times.erase(std::ranges::unique(times).begin(), times.end());
    const double span_s = last - first;
    const double step_s =
        std::max(std::pow(kWalkShare * p_.sigma_m, 2) / p_.phase_walk_m2,
                 span_s / static_cast<double>(std::min(most_points_ > 0 ? kStartKnots : kMostKnots,
                                                       std::max<std::size_t>(times.size() / 3, 1))));
    std::vector<double> knots;
    if (span_s < 2 * step_s) {
      knots.push_back(0.5 * (first + last));
    } else {
      const auto steps = static_cast<std::size_t>(std::ceil(span_s / step_s));
      for (std::size_t k = 0; k <= steps; ++k)
        knots.push_back(first + span_s * static_cast<double>(k) / static_cast<double>(steps));
    }
    p_.knots_s.push_back(std::move(knots));
  }

  /// Centre and extent of the site: of the known beacons and measured points, else of the displacements, else
  /// of the scatter of the receptions.
  void set_extent() {
    Eigen::AlignedBox3d box;
    for (const SiteBeacon& b : p_.site.beacons)
      if (const auto place = b.place_m()) box.extend(*place);
    for (const ClockPoint& point : p_.points)
      if (point.measured_m) box.extend(*point.measured_m);
    if (!box.isEmpty()) p_.centre_m = box.center();
    p_.extent_m = box.isEmpty() ? 0.0 : box.diagonal().norm();
    Eigen::AlignedBox3d path;
    for (const ClockLog& log : logs_) {
      Eigen::Vector3d at = Eigen::Vector3d::Zero();
      for (const Displacement& d : log.displacements) path.extend(at += d.step_m);
    }
    if (!path.isEmpty()) p_.extent_m = std::max(p_.extent_m, path.diagonal().norm());
    if (p_.extent_m > 0.0) return;
    std::vector<double> ranges;
    for (const ClockReception& r : p_.receptions) ranges.push_back(std::abs(r.range_m));
    if (ranges.empty()) return;
    const auto far =
        ranges.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(ranges.size() - 1));
    std::ranges::nth_element(ranges, far);
    p_.extent_m = std::max(2.0 * *far, p_.sigma_m);
  }

  void add_motions(std::size_t run) {
    const MeasurementLog& log = runs_[run];
    const OdometryAccuracy& accuracy = log.odometry_accuracy;
    std::map<std::int64_t, std::size_t> of_epoch;
    std::vector<std::optional<std::size_t>> last(p_.site.vehicles.size());
    std::vector<OdometryPath> paths;
    for (std::size_t v = 0; v < p_.site.vehicles.size(); ++v)
      paths.push_back(odometry_path(log, VehicleId(v)));
    for (std::size_t i = 0; i < p_.points.size(); ++i) {
      const ClockPoint& point = p_.points[i];
      if (point.run != run) continue;
      of_epoch.emplace(point.epoch, i);
      auto& before = last[point.vehicle.index()];
      OdometryObservation o;
      if (before && !point.measured_m &&
          path_between(paths[point.vehicle.index()], p_.points[*before].time_s, point.time_s, o)) {
        p_.motions.push_back({*before, i, o.T_before_after.translation_m, o.T_before_after.heading_rad(),
                              o.distance_sigma_m, o.heading_sigma_rad, true});
        p_.heading_is_free = true;
      }
      before = i;
    }
    for (const Displacement& d : logs_[run].displacements) {
      const auto from = of_epoch.find(d.from), to = of_epoch.find(d.to);
      if (from == of_epoch.end() || to == of_epoch.end()) continue;
      const double sigma_m =
          std::hypot(accuracy.distance_sigma_m_per_sqrt_m * std::sqrt(d.step_m.norm()), accuracy.floor_m);
      p_.motions.push_back({from->second, to->second, d.step_m, 0.0, sigma_m, 0.0, false});
    }
  }

  /// The map is that of known beacons or measured poses, else that of the first point and its odometry.
  void set_datum() {
    std::size_t known = 0;
    bool has_prior = false;
    for (const SiteBeacon& b : p_.site.beacons) {
      const bool is_stated = b.place_m() && b.sigma_m[0] && b.sigma_m[1];
      has_prior = has_prior || is_stated;
      known += is_stated && std::max(*b.sigma_m[0], *b.sigma_m[1]) < kKnownShare * p_.extent_m;
    }
    const bool has_poses =
        std::ranges::any_of(p_.points, [](const ClockPoint& q) { return q.measured_m.has_value(); });
    const bool is_fixed = known >= 2 || has_poses;
    p_.frame_turns =
        is_fixed && std::ranges::any_of(p_.motions, [](const ClockMotion& m) { return !m.turns; });
    p_.frame_is_datum = !is_fixed && !has_prior;
    // Without headings the origin of a vehicle is its receiver.
    if (p_.heading_is_free || has_poses) return;
    for (SiteReceiver& r : p_.site.receivers) r.position_m.head<2>().setZero();
  }

  const std::vector<MeasurementLog>& runs_;
  const std::vector<ClockLog>& logs_;
  std::size_t most_points_;
  ClockProblem p_;
  std::vector<Raw> raw_;
  std::map<std::tuple<std::size_t, std::size_t, std::int64_t>, std::size_t> open_;
};

}  // namespace

ClockProblem make_clock_problem(const Site& site, const std::vector<MeasurementLog>& runs,
                                const std::vector<ClockLog>& logs, const ClockModel& clocks,
                                std::size_t most_points) {
  return ProblemMaker(site, runs, logs, clocks, most_points).make();
}

}  // namespace octant::calib

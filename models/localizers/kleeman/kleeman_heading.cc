// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_heading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/localizers/kleeman/kleeman_validation.h"
#include "models/physics/plane.h"
#include "models/physics/pose.h"

namespace octant {
namespace {

constexpr double kOverhead =
    0.05;  // cosine of the elevation below which a beacon has no horizontal direction
constexpr int kMaxSteps = 20;
constexpr double kSectorOdds = 30.0;  // odds of a sector that contains the heading
constexpr double kAlike_rad =
    0.02;  // tolerance of axes and sensitivities of receivers: bisectors are accurate to about a degree
constexpr double kLouder =
    3.0;  // number of sigmas above which a difference between amplitudes is significant
constexpr double kContradiction_rad = 1.0;  // spread of headings above which their mean is meaningless

/// Normal equation of the heading.
struct HeadingNormal {
  double information = 0.0, gradient = 0.0, chi2 = 0.0;
  Eigen::RowVector2d coupling = Eigen::RowVector2d::Zero();
};

/// Observations of one kind and one beacon with a common unknown, which is eliminated by subtracting their
/// mean.
class Differences {
 public:
  void add(double residual, double sigma, double by_heading, const Eigen::RowVector2d& by_position) {
    const Eigen::Vector4d row(residual, by_heading, by_position.x(), by_position.y());
    const double weight = 1 / (sigma * sigma);
    weights_ += weight;
    sum_ += weight * row;
    products_ += weight * row * row.transpose();
  }
  void add_to(HeadingNormal& normal) const {
    if (!(weights_ > 0)) return;
    const Eigen::Matrix4d centred = products_ - sum_ * sum_.transpose() / weights_;
    normal.chi2 += centred(0, 0);
    normal.gradient += centred(0, 1);
    normal.information += centred(1, 1);
    normal.coupling += centred.block<1, 2>(1, 2);
  }

 private:
  double weights_ = 0.0;
  Eigen::Vector4d sum_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d products_ = Eigen::Matrix4d::Zero();
};

HeadingNormal normal_equation(const HeadingInput& in, double heading_rad) {
  HeadingNormal sum;
  for (std::size_t b = 0; b < in.beacon_p_map_m.size(); ++b) {
    Differences distances, amplitudes;
    for (const HeardDistance& h : in.heard) {
      if (h.beacon != b || !h.kept) continue;
      const ArrayReceiver& receiver = in.receivers[h.receiver];
      const ReceiverPath path = receiver_path(in.beacon_p_map_m[b], receiver, in.p_map_m, heading_rad);
      distances.add(h.slant_m - path.slant_m, h.sigma_m, path.by_heading, path.by_position);
      if (in.directional == nullptr || !h.walk_known || receiver.direction.isZero()) continue;
      const ReceiverGain gain =
          receiver_gain(in.beacon_p_map_m[b], receiver, in.p_map_m, heading_rad, *in.directional);
      amplitudes.add(h.log_amplitude - gain.log, in.log_amplitude_sigma, gain.by_heading, gain.by_position);
    }
    distances.add_to(sum);
    amplitudes.add_to(sum);
  }
  return sum;
}

double best_of_grid(const HeadingInput& in) {
  constexpr int kHeadings = 36;
  double best_rad = 0.0, best_chi2 = normal_equation(in, 0.0).chi2;
  for (int i = 1; i < kHeadings; ++i) {
    const double heading_rad = 2 * std::numbers::pi * i / kHeadings;
    const double chi2 = normal_equation(in, heading_rad).chi2;
    if (chi2 < best_chi2) best_chi2 = chi2, best_rad = heading_rad;
  }
  return best_rad;
}

/// Bearing of a beacon in the map, and the mean axis of the receivers that observe it, in the vehicle frame.
struct HeardFrom {
  bool known = false;
  Eigen::Vector2d bearing, axis;                                // unit vectors
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  // derivative of the bearing, rad/m
};

HeardFrom heard_from(const HeadingInput& in, std::size_t beacon) {
  HeardFrom out;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const HeardDistance& h : in.heard) {
    if (h.beacon == beacon && h.kept && in.receivers[h.receiver].axis) sum += *in.receivers[h.receiver].axis;
  }
  const Eigen::Vector2d to = in.beacon_p_map_m[beacon].head<2>() - in.p_map_m;
  const double distance_m = to.norm(),
               height_m = in.beacon_p_map_m[beacon].z() - in.receivers.front().position_m.z();
  if (sum.norm() < 1e-3 || !(distance_m > kOverhead * std::hypot(distance_m, height_m))) return out;
  out.known = true;
  out.bearing = to / distance_m;
  out.axis = sum.normalized();
  out.by_position = Eigen::RowVector2d(out.bearing.y(), -out.bearing.x()) / distance_m;
  return out;
}

/// Interval of headings that one beacon allows.
struct Sector {
  double middle_rad = 0.0, half_rad = 0.0;
  Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();  // derivative of either end
};

/// Bounds on the direction of a beacon to the left of the mean axis.
struct OffAxisBounds {
  double least_rad = 0.0, most_rad = 0.0;
};

/// The louder of two receivers is closer to the bearing, so the beacon is on its side of their bisector.
/// Leaves the bounds unchanged if this is contradictory, as for a receiver with lower sensitivity than the
/// others.
void narrow_by_loudness(const HeadingInput& in, std::size_t beacon, const Eigen::Vector2d& mean_axis,
                        OffAxisBounds& bounds) {
  if (in.directional == nullptr) return;
  const double clear = kLouder * std::numbers::sqrt2 * in.log_amplitude_sigma;
  const auto counts = [&](const HeardDistance& h) {
    return h.beacon == beacon && h.kept && h.walk_known && in.receivers[h.receiver].axis;
  };
  OffAxisBounds narrow = bounds;
  for (const HeardDistance& a : in.heard) {
    if (!counts(a)) continue;
    const double off_a = angle_of(turn_between(mean_axis, *in.receivers[a.receiver].axis));
    for (const HeardDistance& b : in.heard) {
      if (!counts(b) || a.receiver == b.receiver || !(a.log_amplitude - b.log_amplitude > clear)) continue;
      const double off_b = angle_of(turn_between(mean_axis, *in.receivers[b.receiver].axis)),
                   middle = (off_a + off_b) / 2;
      if (off_a > off_b) {
        narrow.least_rad = std::max(narrow.least_rad, middle);
      } else {
        narrow.most_rad = std::min(narrow.most_rad, middle);
      }
    }
  }
  if (narrow.least_rad < narrow.most_rad) bounds = narrow;
}

std::optional<Sector> sector_of(const HeadingInput& in, std::size_t beacon) {
  const HeardFrom heard = heard_from(in, beacon);
  if (!heard.known) return std::nullopt;
  enum class Ear { kDeaf, kUnclear, kHears };
  const auto ear_of = [&](std::size_t receiver) {
    Ear ear = Ear::kDeaf;
    for (const HeardDistance& h : in.heard) {
      if (h.beacon == beacon && h.receiver == receiver)
        ear = std::max(ear, h.kept ? Ear::kHears : Ear::kUnclear);
    }
    return ear;
  };
  // Axes to the right and left of the mean one: the outermost that observe the beacon, and the nearest beyond
  // them that do not. A receiver without reception between two with reception has missed the pulse, and its
  // axis is moved by a full turn.
  constexpr double kTurn_rad = 2 * std::numbers::pi, kNone = std::numeric_limits<double>::infinity();
  double hears_right = 0.0, hears_left = 0.0, deaf_right = -kNone, deaf_left = kNone;
  for (const bool hearing : {true, false}) {
    for (std::size_t r = 0; r < in.receivers.size(); ++r) {
      if (!in.receivers[r].axis || ear_of(r) != (hearing ? Ear::kHears : Ear::kDeaf)) continue;
      const double off = angle_of(turn_between(heard.axis, *in.receivers[r].axis));
      if (hearing) {
        hears_right = std::min(hears_right, off);
        hears_left = std::max(hears_left, off);
      } else {
        deaf_right = std::max(deaf_right, off < hears_right ? off : off - kTurn_rad);
        deaf_left = std::min(deaf_left, off > hears_left ? off : off + kTurn_rad);
      }
    }
  }
  if (!std::isfinite(deaf_left)) return std::nullopt;  // all receivers observe it
  const double mean_rad = angle_of(turn_between(heard.axis, heard.bearing));
  // Bounds of the bearing relative to the mean axis: bisectors of the last axis on one side with reception
  // and the first on the other without.
  OffAxisBounds off{(hears_left + deaf_right) / 2, (hears_right + deaf_left) / 2};
  narrow_by_loudness(in, beacon, heard.axis, off);
  return Sector{mean_rad - (off.most_rad + off.least_rad) / 2, (off.most_rad - off.least_rad) / 2,
                heard.by_position};
}

/// Sectors on a line of headings that begins and ends opposite to the largest overlap.
class SectorOverlap {
 public:
  /// Ignores sectors beyond kKleemanBeacons, the largest number of beacons.
  void add(const Sector& sector) {
    if (count_ < sectors_.size()) sectors_[count_++] = sector;
  }
  [[nodiscard]] Heading heading();

 private:
  struct End {
    double rad;
    int opens;  // 1: opens a sector, -1: closes one
    Eigen::RowVector2d by_position;
  };
  void lay_out(double about_rad);
  [[nodiscard]] double deepest_rad() const;

  std::array<Sector, kKleemanBeacons> sectors_{};
  std::array<End, std::size_t{2} * kKleemanBeacons> ends_{};
  std::size_t count_ = 0;
};

double SectorOverlap::deepest_rad() const {
  int most = 0;
  double deepest_rad = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double at_rad = sectors_[i].middle_rad - sectors_[i].half_rad;
    const auto holds = [at_rad](const Sector& s) {
      return std::abs(wrap_angle(at_rad - s.middle_rad)) <= s.half_rad + 1e-12;
    };
    const auto depth = static_cast<int>(
        std::count_if(sectors_.begin(), sectors_.begin() + static_cast<long>(count_), holds));
    if (depth > most) most = depth, deepest_rad = at_rad;
  }
  return deepest_rad;
}

void SectorOverlap::lay_out(double about_rad) {
  for (std::size_t i = 0; i < count_; ++i) {
    const Sector& s = sectors_[i];
    const double middle_rad = wrap_angle(s.middle_rad - about_rad);
    ends_[2 * i] = {middle_rad - s.half_rad, 1, s.by_position};
    ends_[2 * i + 1] = {middle_rad + s.half_rad, -1, s.by_position};
  }
  std::sort(ends_.begin(), ends_.begin() + static_cast<long>(2 * count_),
            [](const End& a, const End& b) { return a.rad < b.rad; });
}

Heading SectorOverlap::heading() {
  if (count_ == 0) return {};
  const double about_rad = deepest_rad();
  lay_out(about_rad);
  const std::span<const End> ends(ends_.data(), 2 * count_);
  int depth = 0, most = 0;
  for (const End& end : ends) most = std::max(most, depth += end.opens);
  const auto density = [&](int beacons) {
    if (beacons == most) return 1.0;
    return beacons == most - 1 && beacons > 0 ? 1 / kSectorOdds : 0.0;
  };
  double mass = 0.0, first = 0.0, second = 0.0;  // moments
  depth = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double rho = density(depth += ends[i].opens), l = ends[i].rad, u = ends[i + 1].rad;
    mass += rho * (u - l);
    first += rho * (u * u - l * l) / 2;
    second += rho * (u * u * u - l * l * l) / 3;
  }
  Heading heading;
  const double mean_rad = first / mass, variance = second / mass - mean_rad * mean_rad;
  if (!(mass > 0) || !(variance < kContradiction_rad * kContradiction_rad)) return heading;
  heading.known = true;
  heading.rad = wrap_angle(about_rad + mean_rad);
  heading.sigma_rad = std::sqrt(std::max(variance, kAlike_rad * kAlike_rad));
  depth = 0;
  for (const End& end : ends) {  // effect of moving an end on the mass
    const double before = density(depth);
    heading.by_position +=
        (before - density(depth += end.opens)) * (end.rad - mean_rad) / mass * end.by_position;
  }
  return heading;
}

}  // namespace

ReceiverPath receiver_path(const Eigen::Vector3d& beacon, const ArrayReceiver& receiver,
                           const Eigen::Vector2d& p, double heading_rad) {
  const Eigen::Vector3d& o = receiver.position_m;
  const Eigen::Vector2d lever = Eigen::Rotation2Dd(heading_rad) * o.head<2>();
  const Eigen::Vector2d from = p + lever - beacon.head<2>();
  const double height_m = beacon.z() - o.z();
  ReceiverPath path;
  path.slant_m = std::sqrt(from.squaredNorm() + height_m * height_m);
  const Eigen::Vector2d e = path.slant_m > 0 ? Eigen::Vector2d(from / path.slant_m) : Eigen::Vector2d::Zero();
  path.by_position = e.transpose();
  path.by_heading = cross(lever, e);
  return path;
}

ReceiverGain receiver_gain(const Eigen::Vector3d& beacon, const ArrayReceiver& receiver,
                           const Eigen::Vector2d& p, double heading_rad, const AttenuationModel& model) {
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(heading_rad).toRotationMatrix();
  const Eigen::Vector3d &o = receiver.position_m, &a = receiver.direction;
  const Eigen::Vector2d lever = R * o.head<2>(), axis = R * a.head<2>();
  const Eigen::Vector3d to(beacon.x() - p.x() - lever.x(), beacon.y() - p.y() - lever.y(),
                           beacon.z() - o.z());
  const double distance_m = to.norm();
  ReceiverGain gain;
  if (!(distance_m > 0)) return gain;
  const Eigen::Vector3d e = to / distance_m;
  const double cosine = axis.dot(e.head<2>()) + a.z() * e.z();
  const LogDirectivity directivity = log_directivity(cosine, model.half_power_angle_rad);
  const double loss = 1 / distance_m + model.absorption_np_per_m;
  gain.log_directivity = directivity.value;
  gain.log = directivity.value - std::log(distance_m) - model.absorption_np_per_m * distance_m;
  // Derivative by the receiver's position: the distance grows along -e, and the direction rotates.
  gain.by_position =
      (loss * e.head<2>() - directivity.by_cosine / distance_m * (axis - cosine * e.head<2>())).transpose();
  gain.by_heading =
      gain.by_position.dot(left_of(lever)) + directivity.by_cosine * left_of(axis).dot(e.head<2>());
  return gain;
}

Heading heading_from_mean_axes(const HeadingInput& in) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int beacons = 0;
  Heading heading;
  for (std::size_t b = 0; b < in.beacon_p_map_m.size(); ++b) {
    const HeardFrom heard = heard_from(in, b);
    if (!heard.known) continue;
    sum += turn_between(heard.axis, heard.bearing);
    heading.by_position += heard.by_position;
    ++beacons;
  }
  if (beacons == 0 || sum.norm() < 1e-3 * beacons) return Heading{};
  const auto axes =
      std::ranges::count_if(in.receivers, [](const ArrayReceiver& r) { return r.axis.has_value(); });
  heading.known = true;
  heading.rad = angle_of(sum);
  heading.sigma_rad = 2 * std::numbers::pi / static_cast<double>(axes) / std::sqrt(12.0 * beacons);
  heading.by_position /= beacons;
  return heading;
}

Heading heading_from_hearing(const HeadingInput& in) {
  SectorOverlap overlap;
  for (std::size_t b = 0; b < in.beacon_p_map_m.size(); ++b) {
    if (const auto sector = sector_of(in, b)) overlap.add(*sector);
  }
  return overlap.heading();
}

Heading heading_from_differences(const HeadingInput& in, const Heading& start) {
  Heading heading;
  heading.rad = start.known ? start.rad : best_of_grid(in);
  HeadingNormal normal;
  for (int i = 0; i < kMaxSteps; ++i) {
    normal = normal_equation(in, heading.rad);
    if (!(normal.information * std::numbers::pi * std::numbers::pi > 1))
      return Heading{};  // no information about an angle
    const double step_rad = std::clamp(normal.gradient / normal.information, -0.5, 0.5);
    heading.rad = wrap_angle(heading.rad + step_rad);
    if (std::abs(step_rad) < 1e-10) break;
  }
  heading.known = true;
  heading.sigma_rad = 1 / std::sqrt(normal.information);
  heading.by_position = -normal.coupling / normal.information;
  return heading;
}

}  // namespace octant

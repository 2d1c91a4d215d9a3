// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/locate_points.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "calib/network/plane_loci.h"

namespace octant::calib {
namespace {

/// Local frames tried before points count as missing.
constexpr int kMostFrames = 50;

bool is_distance(const SurveyObservation& o) {
  return o.kind == SurveyKind::kHorizontalDistance || o.kind == SurveyKind::kSlopeDistance;
}

class PointSearch {
 public:
  explicit PointSearch(Network start) : network(std::move(start)), of_point_(network.points.size()) {
    for (std::size_t i = 0; i < network.observations.size(); ++i) {
      const SurveyObservation& o = network.observations[i];
      for (const int p : {o.from, o.to, o.second})
        if (p >= 0) of_point_[static_cast<std::size_t>(p)].push_back(i);
      if (o.kind == SurveyKind::kZenithAngle)
        zenith_[{o.from, o.to}] = zenith_[{o.to, o.from}] = std::sin(o.value);
    }
  }

  /// Locates points until no observation locates another one.
  void propagate() {
    for (bool progress = true; progress;) {
      progress = false;
      orient();
      for (std::size_t p = 0; p < network.points.size(); ++p)
        progress = (is_sought(p) && locate(static_cast<int>(p))) || progress;
      for (const SurveyObservation& o : network.observations) progress = height(o) || progress;
    }
  }

  /// Horizontal distance of an observation, from its slope distance as far as zenith angle or heights allow.
  [[nodiscard]] double horizontal_m(const SurveyObservation& o) const {
    if (o.kind == SurveyKind::kHorizontalDistance) return o.value;
    if (const auto at = zenith_.find({o.from, o.to}); at != zenith_.end()) return o.value * at->second;
    if (!known(o.from, 2) || !known(o.to, 2)) return o.value;
    const double rise_m = at(o.to).z() + o.target_height_m - at(o.from).z() - o.instrument_height_m;
    return std::sqrt(std::max(o.value * o.value - rise_m * rise_m, 0.0));
  }

  [[nodiscard]] bool in_plane(int p) const { return known(p, 0) && known(p, 1); }
  [[nodiscard]] Eigen::Vector2d plane(int p) const { return at(p).head<2>(); }
  void set_plane(int p, const Eigen::Vector2d& position) {
    for (int i = 0; i < 2; ++i) set(p, i, position[i]);
  }

  Network network;

 private:
  [[nodiscard]] bool is_sought(std::size_t p) const {
    return network.points[p].role[0] != CoordinateRole::kAbsent && !in_plane(static_cast<int>(p));
  }
  [[nodiscard]] const Eigen::Vector3d& at(int p) const {
    return network.points[static_cast<std::size_t>(p)].p_map_m;
  }
  [[nodiscard]] bool known(int p, std::size_t axis) const {
    return network.points[static_cast<std::size_t>(p)].known[axis];
  }
  bool set(int p, int axis, double value) {
    NetworkPoint& point = network.points[static_cast<std::size_t>(p)];
    if (point.known[static_cast<std::size_t>(axis)]) return false;
    point.p_map_m[axis] = value;
    return point.known[static_cast<std::size_t>(axis)] = true;
  }
  [[nodiscard]] double azimuth(int from, int to) const {
    const Eigen::Vector2d v = plane(to) - plane(from);
    return std::atan2(v.y(), v.x());
  }

  void orient() {
    for (const SurveyObservation& o : network.observations)
      if (o.kind == SurveyKind::kDirection && in_plane(o.from) && in_plane(o.to))
        orientation_.emplace(o.set, azimuth(o.from, o.to) - o.value);
  }

  /// Adds the locus of point p by one observation to known points.
  void add_locus(const SurveyObservation& o, int p, std::map<int, const SurveyObservation*>& first,
                 std::vector<Locus>& loci) const {
    const int other = o.from == p ? o.to : o.from;
    if (o.kind == SurveyKind::kAngle) {
      if (o.from == p && in_plane(o.to) && in_plane(o.second))
        loci.push_back({Locus::kAngle, plane(o.to), plane(o.second), o.value});
      if (!in_plane(o.from)) return;
      if (o.second == p && in_plane(o.to))
        loci.push_back({Locus::kRay, plane(o.from), {}, azimuth(o.from, o.to) + o.value});
      if (o.to == p && in_plane(o.second))
        loci.push_back({Locus::kRay, plane(o.from), {}, azimuth(o.from, o.second) - o.value});
      return;
    }
    if ((o.from != p && o.to != p) || !in_plane(other)) return;
    if (is_distance(o)) loci.push_back({Locus::kCircle, plane(other), {}, horizontal_m(o)});
    if (o.kind == SurveyKind::kAzimuth)
      loci.push_back({Locus::kRay, plane(other), {}, o.value + (o.from == p ? std::numbers::pi : 0.0)});
    if (o.kind != SurveyKind::kDirection) return;
    if (const auto at = orientation_.find(o.set); o.to == p && at != orientation_.end())
      loci.push_back({Locus::kRay, plane(other), {}, o.value + at->second});
    if (o.from != p) return;
    const SurveyObservation* start = first.emplace(o.set, &o).first->second;
    if (start->to != o.to)
      loci.push_back({Locus::kAngle, plane(start->to), plane(o.to), o.value - start->value});
  }

  bool locate(int p) {
    std::vector<Locus> loci;
    std::map<int, const SurveyObservation*> first;
    for (const std::size_t i : of_point_[static_cast<std::size_t>(p)]) {
      const SurveyObservation& o = network.observations[i];
      if (o.kind >= SurveyKind::kX)
        difference(o, p);
      else if (o.kind != SurveyKind::kZenithAngle && o.kind != SurveyKind::kHeightDifference)
        add_locus(o, p, first, loci);
    }
    if (in_plane(p)) return true;
    const std::optional<Eigen::Vector2d> position = intersection(std::move(loci));
    if (position) set_plane(p, *position);
    return position.has_value();
  }

  /// Coordinates and coordinate differences.
  bool difference(const SurveyObservation& o, int p) {
    if (o.kind <= SurveyKind::kZ)
      return o.from == p && set(p, static_cast<int>(o.kind) - static_cast<int>(SurveyKind::kX), o.value);
    const int axis = static_cast<int>(o.kind) - static_cast<int>(SurveyKind::kDx);
    const int other = o.from == p ? o.to : o.from;
    if ((o.from != p && o.to != p) || !known(other, static_cast<std::size_t>(axis))) return false;
    return set(p, axis, at(other)[axis] + (o.to == p ? o.value : -o.value));
  }

  /// Height of one end of an observation from the other end.
  bool height(const SurveyObservation& o) {
    if (o.kind == SurveyKind::kZ) return difference(o, o.from);
    if (o.kind == SurveyKind::kDz) return difference(o, o.from) || difference(o, o.to);
    double rise_m = o.value;
    if (o.kind == SurveyKind::kZenithAngle) {
      if (!in_plane(o.from) || !in_plane(o.to)) return false;
      rise_m = (plane(o.to) - plane(o.from)).norm() / std::tan(o.value) + o.instrument_height_m -
               o.target_height_m;
    } else if (o.kind != SurveyKind::kHeightDifference) {
      return false;
    }
    if (known(o.from, 2)) return set(o.to, 2, at(o.from).z() + rise_m);
    return known(o.to, 2) && set(o.from, 2, at(o.to).z() - rise_m);
  }

  std::vector<std::vector<std::size_t>> of_point_;  ///< indices of its observations
  std::map<std::pair<int, int>, double> zenith_;    ///< sine by points
  std::map<int, double> orientation_;               ///< by set
};

bool is_needed(const NetworkPoint& point, std::size_t axis) {
  return point.role[axis] != CoordinateRole::kAbsent && !point.known[axis];
}

/// Transforms points of a local frame to the network by at least two common points, or uses them as they are
/// in a network without coordinates.
bool join(const PointSearch& local, PointSearch& search) {
  using Complex = std::complex<double>;
  const auto complex = [](const Eigen::Vector2d& v) { return Complex(v.x(), v.y()); };
  std::vector<std::pair<Complex, Complex>> common;
  std::vector<int> rest;
  Complex from_mean = 0.0, to_mean = 0.0;
  bool any = false;
  for (int p = 0; p < static_cast<int>(search.network.points.size()); ++p) {
    any = any || search.in_plane(p);
    if (!local.in_plane(p)) continue;
    if (!search.in_plane(p)) {
      rest.push_back(p);
      continue;
    }
    common.emplace_back(complex(local.plane(p)), complex(search.plane(p)));
    from_mean += common.back().first;
    to_mean += common.back().second;
  }
  if (rest.size() < (any ? 1U : 2U) || (any && common.size() < 2)) return false;
  Complex factor = 1.0;
  if (any) {
    from_mean /= static_cast<double>(common.size());
    to_mean /= static_cast<double>(common.size());
    Complex product = 0.0;
    double square = 0.0;
    for (const auto& [from, to] : common) {
      product += std::conj(from - from_mean) * (to - to_mean);
      square += std::norm(from - from_mean);
    }
    if (!(square > 0.0) || !(std::abs(product) > 0.0)) return false;
    factor = product / square;
  }
  for (const int p : rest) {
    const Complex position = to_mean + factor * (complex(local.plane(p)) - from_mean);
    search.set_plane(p, {position.real(), position.imag()});
  }
  return true;
}

/// Locates points in a frame with its origin at one end of an observation and its x axis towards the other
/// end. The length of the base is observed, or one in a frame without distances.
bool locate_by_local_frame(PointSearch& search, bool by_distance) {
  int frames = 0;
  for (const SurveyObservation& o : search.network.observations) {
    const bool is_base = by_distance ? is_distance(o) : o.kind <= SurveyKind::kAngle;
    if (!is_base || (search.in_plane(o.from) && search.in_plane(o.to))) continue;
    if (++frames > kMostFrames) break;
    Network network = search.network;
    std::erase_if(network.observations, [&](const SurveyObservation& other) {
      return other.kind == SurveyKind::kAzimuth || other.kind >= SurveyKind::kX ||
             (!by_distance && is_distance(other));
    });
    for (NetworkPoint& point : network.points) point.known[0] = point.known[1] = false;
    PointSearch local(std::move(network));
    local.set_plane(o.from, Eigen::Vector2d::Zero());
    local.set_plane(o.to, {by_distance ? search.horizontal_m(o) : 1.0, 0.0});
    local.propagate();
    if (join(local, search)) return true;
  }
  return false;
}

}  // namespace

LocatedNetwork locate_points(Network network) {
  LocatedNetwork located;
  std::vector<std::size_t> open;
  for (std::size_t p = 0; p < network.points.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (is_needed(network.points[p], i) && (open.empty() || open.back() != p)) open.push_back(p);
  PointSearch search(std::move(network));
  if (!open.empty()) {
    do search.propagate();
    while (locate_by_local_frame(search, true) || locate_by_local_frame(search, false));
  }
  located.network = std::move(search.network);
  for (const std::size_t p : open) {
    const NetworkPoint& point = located.network.points[p];
    const bool missing = is_needed(point, 0) || is_needed(point, 1) || is_needed(point, 2);
    (missing ? located.missing : located.computed).push_back(point.id);
  }
  return located;
}

}  // namespace octant::calib

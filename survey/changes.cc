// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/changes.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "models/changes/chi_square.h"
#include "models/support/decompositions.h"

namespace octant::survey {
namespace {

/// Ratio of the largest shift that a knocked control point can explain to the shift that its own delay
/// indicates. The delay shows a part of the shift, and the other positions follow by at most that shift. A
/// beacon that moved further moved itself.
constexpr double kWaysOfDelay = 10.0;

/// Shift weighted by its covariance, in the directions that have one.
std::optional<double> chance_of(const Eigen::Vector3d& shift_m, const Eigen::Matrix3d& C) {
  const SymmetricEigen<Eigen::Matrix3d> eigen(C);
  double sum = 0.0;
  int dof = 0;
  for (int i = 0; i < 3; ++i) {
    const double variance = eigen.eigenvalues()[i];
    if (!(variance > 1e-6 * eigen.eigenvalues()[2]) || !(variance > 0.0))
      continue;  // held fixed, or rounding of that
    sum += std::pow(eigen.eigenvectors().col(i).dot(shift_m), 2) / variance;
    ++dof;
  }
  if (dof == 0) return {};
  return chi_square_tail(sum, dof);
}

const DeploymentBeacon* find(const Deployment& d, const std::string& name) {
  const auto at = std::ranges::find(d.beacons, name, &DeploymentBeacon::name);
  return at == d.beacons.end() ? nullptr : &*at;
}

/// Removes odometry from a list such as "control points, medium, odometry", because it defines neither a
/// frame nor a datum.
std::string without_odometry(const std::string& words) {
  std::string kept;
  for (std::size_t from = 0; from <= words.size();) {
    const std::size_t comma = std::min(words.find(", ", from), words.size());
    const std::string word = words.substr(from, comma - from);
    if (!word.empty() && word != "odometry") kept += (kept.empty() ? "" : ", ") + word;
    from = comma + 2;
  }
  return kept;
}

/// Returns true if the same points define the frame in both deployments; other observations of the scale do
/// not move it.
bool same_frame(const Datum& a, const Datum& b) {
  const std::set<std::string> points_a(a.control_points.begin(), a.control_points.end()),
      points_b(b.control_points.begin(), b.control_points.end());
  return points_a == points_b && without_odometry(a.position) == without_odometry(b.position) &&
         without_odometry(a.orientation) == without_odometry(b.orientation) &&
         without_odometry(a.scale) == without_odometry(b.scale);
}

/// Probability of a change of delay by chance, if both deployments have a delay for each beacon.
std::optional<double> chance_of_delay(const Deployment& before, const Deployment& now,
                                      const BeaconChange& c) {
  if (!before.timing.delay_per.beacon || !now.timing.delay_per.beacon || !(c.delay_sigma_s > 0)) return {};
  return std::erfc(std::abs(c.delay_change_s) / c.delay_sigma_s / std::sqrt(2.0));
}

/// Returns true if a change of that kind names the beacon.
bool names_beacon(const Changes& changes, ChangeKind kind, const std::string& name) {
  return std::ranges::any_of(changes.found, [&](const Change& c) {
    if (c.kind != kind) return false;
    return kind == ChangeKind::kExchanged
               ? c.subject.starts_with(name + ", ") || c.subject.ends_with(", " + name)
               : c.subject == name;
  });
}

/// Findings of the second visit, whose directions a deployment does not store.
std::vector<Change> found_by_visit(const Deployment& now, const std::vector<Change>& compared,
                                   const std::vector<BeaconChange>& beacons) {
  std::vector<Change> found = now.previous->changes;
  for (Change& c : found) {
    for (const BeaconChange& b : beacons)
      if (c.kind == ChangeKind::kBeaconMoved && b.name == c.subject) c.shift_m = b.shift_m;
    for (const Change& again : compared)
      if (again.kind == c.kind && again.subject == c.subject) c.shift_m = again.shift_m;
  }
  return found;
}

/// Removes shifts that the control points in doubt may explain. A beacon that is fixed in both deployments is
/// at its stated position for any datum.
void put_down_to_datum(const Deployment& now, Changes& changes) {
  double longest_s = 0.0;
  for (const BeaconChange& c : changes.beacons)
    if (std::count(changes.doubted_control_points.begin(), changes.doubted_control_points.end(), c.name) > 0)
      longest_s = std::max(longest_s, std::abs(c.delay_change_s));
  const double explained_m = kWaysOfDelay * longest_s * now.speed_mps(now.medium.temperature_degC);
  for (BeaconChange& c : changes.beacons)
    c.by_datum = c.significant && c.p.has_value() && c.shift_m.norm() <= explained_m;
  std::erase_if(changes.found, [&](const Change& found) {
    return found.kind == ChangeKind::kBeaconMoved &&
           std::any_of(changes.beacons.begin(), changes.beacons.end(),
                       [&](const BeaconChange& c) { return c.by_datum && c.name == found.subject; });
  });
}

/// Marks significant changes, and the changes that a knocked control point may explain. The control point is
/// fixed, so its own delay absorbs part of its shift, and the other positions absorb the rest.
void judge(const Deployment& before, const Deployment& now, const Drift& drift, Changes& changes) {
  Comparison comparison = compare(before, now, drift);
  changes.limit_p = kFalseAlarm / static_cast<double>(std::max<std::size_t>(comparison.hypotheses.size(), 1));
  const bool is_found = is_derived(now, before);
  changes.found =
      is_found ? found_by_visit(now, comparison.changes, changes.beacons) : std::move(comparison.changes);
  for (BeaconChange& c : changes.beacons) {
    c.significant = names_beacon(changes, ChangeKind::kBeaconMoved, c.name) ||
                    names_beacon(changes, ChangeKind::kExchanged, c.name);
    c.delay_significant = names_beacon(changes, ChangeKind::kDelay, c.name) ||
                          names_beacon(changes, ChangeKind::kDelay, kAllBeaconsSubject);
    if (is_found) continue;
    const DeploymentBeacon* a = find(before, c.name);
    const DeploymentBeacon* b = find(now, c.name);
    const bool held = a->status == BeaconStatus::kControlPoint && b->status == BeaconStatus::kControlPoint &&
                      !c.significant;
    if (held && c.delay_significant) changes.doubted_control_points.push_back(c.name);
  }
  if (!changes.doubted_control_points.empty()) put_down_to_datum(now, changes);
}

}  // namespace

Changes changes_between(const Deployment& before, const Deployment& now) {
  return changes_between(before, now, drift_between(before, now.created));
}

Changes changes_between(const Deployment& before, const Deployment& now, const Drift& drift) {
  Changes changes;
  changes.since = before.created;
  changes.same_datum = same_frame(before.datum, now.datum);
  for (const auto& b : now.beacons) {
    const DeploymentBeacon* old = find(before, b.name);
    if (old == nullptr) {
      changes.added.push_back(b.name);
      continue;
    }
    if (b.status == BeaconStatus::kUndetermined || old->status == BeaconStatus::kUndetermined) continue;
    BeaconChange c;
    c.name = b.name;
    c.shift_m = b.position_m - old->position_m;
    const Eigen::Matrix3d C = b.covariance_m2 + old->covariance_m2;
    c.sigma_m = C.diagonal().cwiseMax(0.0).cwiseSqrt();
    c.p = chance_of(c.shift_m, C);
    c.delay_change_s = b.delay_s - old->delay_s;
    c.delay_sigma_s = std::hypot(b.delay_sigma_s, old->delay_sigma_s);
    c.delay_p = chance_of_delay(before, now, c);
    changes.beacons.push_back(std::move(c));
  }
  judge(before, now, drift, changes);
  for (const auto& b : before.beacons)
    if (find(now, b.name) == nullptr) changes.gone.push_back(b.name);
  if (!now.beacons.empty()) {
    const double at_degC = now.medium.temperature_degC;
    changes.speed_change_mps = now.speed_mps(at_degC) - before.speed_mps(at_degC);
    changes.speed_sigma_mps = std::hypot(now.speed_sigma_mps, before.speed_sigma_mps);
  }
  return changes;
}

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman.h"

#include <stdexcept>

#include "models/localizers/common/pair_ranges.h"
#include "models/localizers/kleeman/kleeman_work.h"

namespace octant {
namespace {

constexpr double kConverged_m = 1e-5, kConverged_rad = 1e-5;  // well below the accuracy of any fix

}  // namespace

Result<void> kleeman_fits(const Deployment& d) {
  if (d.motion != Motion::kPlanar)
    return bad_input("kleeman: the deployment's motion is spatial", "planar motion");
  if (d.timing.ranging != Ranging::kOneWay)
    return bad_input("kleeman: the deployment's ranging is two_way", "one_way");
  const auto deployment_has = [](std::size_t count, const char* what) {
    return std::string("kleeman: the deployment has ").append(std::to_string(count)).append(what);
  };
  if (d.beacons.size() > kKleemanBeacons)
    return bad_input(deployment_has(d.beacons.size(), " beacons"), "16 at most");
  const std::size_t usable = usable_beacons(d);
  if (usable < 3) return bad_input(deployment_has(usable, " usable beacons"), "3 or more");
  if (d.receivers.empty() || d.vehicles.empty())
    return bad_input("kleeman: the deployment has no receiver", "a vehicle with one");
  return {};
}

Kleeman::Kleeman(const Deployment& deployment, const KleemanOptions& options)
    : Localizer(deployment), deployment_(deployment), options_(options) {
  if (auto fits = kleeman_fits(deployment); !fits) throw std::invalid_argument(fits.error().message());
  for (const DeploymentBeacon& b : deployment_.beacons) beacon_p_map_m_.push_back(b.position_m);
  work_ = std::make_unique<Work>();
  for (const SiteVehicle& v : deployment_.vehicles) {
    vehicles_.emplace_back(deployment_, v, options_.longsolve);
    work_->memory = vehicles_.back().memory;
    work_->heard.reserve(
        std::max(work_->heard.capacity(), 4 * deployment_.beacons.size() * v.receiver_count));
  }
}

Kleeman::~Kleeman() = default;

void Kleeman::reset() noexcept {
  for (Vehicle& v : vehicles_) v.memory.placed = v.memory.has_errors = false;
}

void Kleeman::locate_known(const Observations& observations, Fix& fix) noexcept {
  const std::span<const Arrival> arrivals = observations.arrivals;
  begin_fix(arrivals, fix);
  fix.covariance.setZero(3, 3);
  if (!arrivals.empty()) fix.time_s = (arrivals.front().time_s + arrivals.back().time_s) / 2;
  fix.status = place(arrivals);
  if (!fix.ok()) return;
  work_->vehicle->memory = work_->memory;
  fill(arrivals, fix);
  propagate(fix);
}

/// Computes position and heading in alternating passes.
FixStatus Kleeman::place(std::span<const Arrival> arrivals) noexcept {
  Work& w = *work_;
  gather(arrivals);
  if (w.vehicle == nullptr) return FixStatus::kTooFewArrivals;
  w.memory = w.vehicle->memory;
  w.heading = Heading{};
  w.heading_tried = false;
  FixStatus status = solve_pass(/*first=*/true);
  double moved_m = 0.0, turned_rad = 0.0;
  for (int pass = 1; pass < options_.max_passes && status == FixStatus::kOk; ++pass) {
    const Eigen::Vector2d before = w.solution.p_map_m;
    const Heading heading = w.heading;
    status = solve_pass(/*first=*/false);
    moved_m = (w.solution.p_map_m - before).norm();
    turned_rad = std::abs(wrap_angle(w.heading.rad - heading.rad));
    // A heading that was coarse until now has not converged merely because it did not change.
    const bool same_heading =
        heading.known == w.heading.known && std::abs(w.heading.sigma_rad - heading.sigma_rad) < 1e-3;
    if (moved_m < kConverged_m && turned_rad < kConverged_rad && same_heading) break;
  }
  // Arrivals at the edge of a gate may alternate forever with little effect. With a larger effect there is no
  // fix.
  if (status == FixStatus::kOk && (moved_m > 100 * kConverged_m || turned_rad > 1000 * kConverged_rad))
    status = FixStatus::kNotConverged;
  return status;
}

FixStatus Kleeman::solve_pass(bool first) noexcept {
  Work& w = *work_;
  const Vehicle& v = *w.vehicle;
  if (first) {
    earliest();
  } else {
    centre();
  }
  set_rough_aside();
  // While the array is treated as a point, the difference of two distances may exceed eq. 5-6 by its
  // diameter.
  const double slack_m = first ? 2 * v.radius_m : 0.0;
  w.impossible = triangle_violations(w.distances, beacon_p_map_m_, options_.triangle_sigmas, slack_m);
  const double scale_sigma = deployment_.speed_sigma_mps / w.speed_mps;
  w.solution = v.longsolve.solve(w.distances, w.distances.heard & ~w.impossible, scale_sigma, w.memory);
  if (w.solution.ok()) find_heading(first);
  return w.solution.status;
}

void Kleeman::find_heading(bool first) noexcept {
  Work& w = *work_;
  // Beacons rejected by longsolve are late and come from another direction, so they are not used for the
  // heading either.
  for (HeardDistance& h : w.heard) h.kept = h.kept && w.solution.agreeing[h.beacon];
  const auto& attenuation = deployment_.attenuation;
  const HeadingInput input{w.heard,
                           beacon_p_map_m_,
                           w.vehicle->receivers,
                           w.solution.p_map_m,
                           attenuation && attenuation->directional() ? &*attenuation : nullptr,
                           deployment_.noise.amplitude_relative_sigma};
  // In the first pass echoes at single receivers have not been rejected yet; the coarse heading tolerates
  // them.
  const bool coarse = first || options_.heading != KleemanHeading::kInterpolation;
  const bool published = options_.heading == KleemanHeading::kMeanAxes;
  Heading heading;
  if (coarse || !w.heading.known)
    heading = published ? heading_from_mean_axes(input) : heading_from_hearing(input);
  if (!heading.known || !coarse) {
    const Heading interpolated = heading_from_differences(input, w.heading.known ? w.heading : heading);
    if (interpolated.known) heading = interpolated;
  }
  w.heading = heading;
  w.heading_tried = true;
}

}  // namespace octant

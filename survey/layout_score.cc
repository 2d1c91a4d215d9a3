// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/layout_score.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "survey/polygon.h"

namespace octant::survey {
namespace {

constexpr double kP95 = 0.95;
constexpr double kVagueM = 20.0;     ///< sigma of the vague idea: position and clock
constexpr double kVagueRad = 1.0;
constexpr double kSoftPower = 8.0;  ///< soft() has it in multiplications

double quantile(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

LayoutScore::LayoutScore(SurveyModel model, PoseList poses, const PlacementOptions& options)
    : model_(std::move(model)), poses_(std::move(poses)), options_(options) {
  const Unknowns& u = model_.unknowns;
  // With an array one beacon gives range and bearing, without it each gives one number.
  required_ = std::max(options.coverage, u.rotation > 0 ? 1 : u.position + (u.clock ? 1 : 0));
  hopeless_m_ = std::sqrt(std::max(1.0, std::abs(signed_area_m2(model_.floor_m))));
  resize();
}

void LayoutScore::resize() {
  sigma_m_.resize(poses_.size());
  const Unknowns& u = model_.unknowns;
  vague_.assign(static_cast<std::size_t>(u.entries()), 0.0);
  for (int i = 0, entry = 0; i < u.count(); entry += u.count() - i, ++i) {
    const double sigma = i >= u.position && i < u.position + u.rotation ? kVagueRad : kVagueM;
    vague_[static_cast<std::size_t>(entry)] = 1 / (sigma * sigma);
  }
}

void LayoutScore::add_poses(const PoseList& more) {
  for (std::size_t i = 0; i < more.size(); ++i) poses_.add(more.x_m[i], more.y_m[i], more.z_m[i], more.heading_rad[i]);
  resize();
}

void LayoutScore::Sum::add(const BeaconLayer& layer, int sign) {
  for (std::size_t i = 0; i < information.size(); ++i) information[i] += sign * layer.information[i];
  for (std::size_t i = 0; i < heard.size(); ++i) heard[i] = static_cast<std::uint16_t>(heard[i] + sign * layer.heard[i]);
}

LayoutScore::Sum LayoutScore::no_beacons() const {
  return {std::vector<double>(vague_.size() * poses_.size(), 0.0), std::vector<std::uint16_t>(poses_.size(), 0)};
}

double LayoutScore::value_with(const Sum& sum, const BeaconLayer* layer, bool soft_one) {
  scratch_ = sum;
  if (layer != nullptr) scratch_.add(*layer);
  if (soft_one)
    for (std::size_t e = 0; e < vague_.size(); ++e)
      if (vague_[e] > 0)
        for (std::size_t i = 0; i < poses_.size(); ++i) scratch_.information[e * poses_.size() + i] += vague_[e];
  sigma_of_information(model_.unknowns, scratch_.information, sigma_m_);
  return soft_one ? soft(sigma_m_, scratch_.heard) : value(figures(sigma_m_, scratch_.heard));
}

double LayoutScore::soft_value(const std::vector<SurveyBeacon>& beacons) {
  Sum sum = no_beacons();
  for (const SurveyBeacon& b : beacons) sum.add(layer(b));
  return value_with(sum, nullptr, true);
}

double LayoutScore::soft(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) const {
  const bool mean = options_.goal == PlacementGoal::kMean;
  double sum = 0.0;
  for (std::size_t i = 0; i < sigma_m.size(); ++i) {
    const double e = std::min(sigma_m[i], hopeless_m_) * (1 + std::max(0, options_.coverage - static_cast<int>(heard[i])));
    const double e2 = e * e, e4 = e2 * e2;
    sum += mean ? e : e4 * e4;
  }
  sum /= static_cast<double>(sigma_m.size());
  return mean ? sum : std::pow(sum, 1 / kSoftPower);
}

LayoutFigures LayoutScore::of(const std::vector<SurveyBeacon>& beacons) {
  model_.beacons = beacons;
  const GeometryFigures geometry = evaluate_poses(model_, poses_, {.threads = options_.threads, .integrity = false});
  return figures(geometry.sigma_m, geometry.beacons);
}

LayoutFigures LayoutScore::figures(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) {
  LayoutFigures f;
  errors_.clear();
  covered_.clear();
  for (std::size_t i = 0; i < sigma_m.size(); ++i) {
    const int missing = std::max(0, required_ - static_cast<int>(heard[i]));
    if (missing == 0 && sigma_m[i] < hopeless_m_) {
      covered_.push_back(sigma_m[i]);
      errors_.push_back(sigma_m[i]);
    } else {
      errors_.push_back(hopeless_m_ * (1 + missing));
    }
  }
  const auto mean = [](const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size()); };
  f.covered_fraction = static_cast<double>(covered_.size()) / static_cast<double>(errors_.size());
  f.mean_with_uncovered_m = mean(errors_);
  if (!covered_.empty()) {
    f.mean_m = mean(covered_);
    f.worst_m = *std::max_element(covered_.begin(), covered_.end());
    f.p95_m = quantile(covered_, kP95);
  }
  switch (options_.goal) {
    case PlacementGoal::kWorst: f.objective_m = *std::max_element(errors_.begin(), errors_.end()); break;
    case PlacementGoal::kP95: f.objective_m = quantile(errors_, kP95); break;
    case PlacementGoal::kMean: f.objective_m = f.mean_with_uncovered_m; break;
  }
  return f;
}

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/layout_score.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "models/physics/polygon.h"

namespace octant::survey {
namespace {

constexpr double kP95 = 0.95;
constexpr double kVagueM = 20.0;  ///< sigma of the weak prior: position and clock
constexpr double kVagueRad = 1.0;
constexpr double kSoftPower = 8.0;  ///< soft() uses multiplications for it

double quantile_in_place(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
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
  for (std::size_t i = 0; i < more.size(); ++i)
    poses_.add(more.x_m[i], more.y_m[i], more.z_m[i], more.heading_rad[i]);
  resize();
}

void LayoutScore::Sum::add(const BeaconLayer& layer, int sign) {
  for (std::size_t i = 0; i < information.size(); ++i) information[i] += sign * layer.information[i];
  for (std::size_t i = 0; i < heard.size(); ++i)
    heard[i] = static_cast<std::uint16_t>(heard[i] + sign * layer.heard[i]);
}

LayoutScore::Sum LayoutScore::no_beacons() const {
  return {std::vector<double>(vague_.size() * poses_.size(), 0.0),
          std::vector<std::uint16_t>(poses_.size(), 0)};
}

double LayoutScore::value_with(const Sum& sum, const BeaconLayer* layer, bool soft_one) {
  const std::size_t n = poses_.size();
  sum_.resize(sum.information.size());
  heard_ = sum.heard;
  for (std::size_t e = 0; e < vague_.size(); ++e) {
    const double vague = soft_one ? vague_[e] : 0.0;
    const double* from = sum.information.data() + e * n;
    double* to = sum_.data() + e * n;
    if (layer != nullptr) {
      const double* more = layer->information.data() + e * n;
      for (std::size_t i = 0; i < n; ++i) to[i] = from[i] + more[i] + vague;
    } else {
      for (std::size_t i = 0; i < n; ++i) to[i] = from[i] + vague;
    }
  }
  if (layer != nullptr)
    for (std::size_t i = 0; i < n; ++i) heard_[i] = static_cast<std::uint16_t>(heard_[i] + layer->heard[i]);
  sigma_of_information(model_.unknowns, sum_, sigma_m_);
  return soft_one ? soft(sigma_m_, heard_) : hard(sigma_m_, heard_);
}

double LayoutScore::soft_value(const std::vector<SurveyBeacon>& beacons) {
  Sum sum = no_beacons();
  for (const SurveyBeacon& b : beacons) sum.add(layer(b));
  return value_with(sum, nullptr, true);
}

double LayoutScore::error(double sigma_m, int heard) const {
  const int missing = std::max(0, required_ - heard);
  return missing == 0 && sigma_m < hopeless_m_ ? sigma_m : hopeless_m_ * (1 + missing);
}

/// value() of figures() without the figures that it does not need.
double LayoutScore::hard(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) {
  double worst = 0.0, sum = 0.0;
  errors_.resize(sigma_m.size());
  for (std::size_t i = 0; i < sigma_m.size(); ++i) {
    errors_[i] = error(sigma_m[i], heard[i]);
    worst = std::max(worst, errors_[i]);
    sum += errors_[i];
  }
  const double mean = sum / static_cast<double>(errors_.size());
  switch (options_.goal) {
    case PlacementGoal::kWorst: return worst + kMeanShare * mean;
    case PlacementGoal::kP95: return quantile_in_place(errors_, kP95) + kMeanShare * mean;
    case PlacementGoal::kMean: return (1 + kMeanShare) * mean;
  }
  return worst;
}

double LayoutScore::soft(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) const {
  const bool mean = options_.goal == PlacementGoal::kMean;
  double sum = 0.0;
  for (std::size_t i = 0; i < sigma_m.size(); ++i) {
    const double e =
        std::min(sigma_m[i], hopeless_m_) * (1 + std::max(0, options_.coverage - static_cast<int>(heard[i])));
    const double e2 = e * e, e4 = e2 * e2;
    sum += mean ? e : e4 * e4;
  }
  sum /= static_cast<double>(sigma_m.size());
  return mean ? sum : std::pow(sum, 1 / kSoftPower);
}

LayoutFigures LayoutScore::of(const std::vector<SurveyBeacon>& beacons) {
  model_.beacons = beacons;
  const GeometryFigures geometry =
      evaluate_poses(model_, poses_, {.threads = options_.threads, .integrity = false});
  heard_.assign(geometry[kBeacons].begin(), geometry[kBeacons].end());
  return figures(geometry[kSigma], heard_);
}

LayoutFigures LayoutScore::figures(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) {
  LayoutFigures f;
  errors_.clear();
  covered_.clear();
  for (std::size_t i = 0; i < sigma_m.size(); ++i) {
    errors_.push_back(error(sigma_m[i], heard[i]));
    if (errors_.back() < hopeless_m_) covered_.push_back(errors_.back());
  }
  const auto mean = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  f.covered_fraction = static_cast<double>(covered_.size()) / static_cast<double>(errors_.size());
  f.mean_with_uncovered_m = mean(errors_);
  if (!covered_.empty()) {
    f.mean_m = mean(covered_);
    f.worst_m = *std::ranges::max_element(covered_);
    f.p95_m = quantile_in_place(covered_, kP95);
  }
  switch (options_.goal) {
    case PlacementGoal::kWorst: f.objective_m = *std::ranges::max_element(errors_); break;
    case PlacementGoal::kP95: {
      std::vector<double> sorted = errors_;
      f.objective_m = quantile_in_place(sorted, kP95);
      break;
    }
    case PlacementGoal::kMean: f.objective_m = f.mean_with_uncovered_m; break;
  }
  return f;
}

}  // namespace octant::survey

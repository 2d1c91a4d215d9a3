// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <utility>

#include "calib/stream/log_readings.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// Passes over one residual with a single parameter.
class OneResidual : public calib::LogReadings {
 public:
  /// @param residual  sets value and derivative
  explicit OneResidual(std::function<void(double x, double& r, double& J)> residual)
      : residual_(std::move(residual)) {}
  Result<Placed> place(const calib::Estimate&, double, bool) override { return Placed{}; }
  Result<calib::PassSum> pass(const calib::Estimate& estimate, calib::RejectionPolicy policy) override {
    double r = 0.0, J = 0.0;
    residual_(estimate.x[0], r, J);
    calib::PassSum sum;
    calib::SystemPart part = calib::empty_part({0});
    part.system.cost = sum.counts.cost_before = 0.5 * r * r;
    part.system.gradient[0] = J * r;
    part.system.H(0, 0) = J * J;
    sum.system.add(part);
    if (policy != calib::RejectionPolicy::kKept && changes_left > 0) sum.counts.changed = 1, --changes_left;
    latest_cost_ = part.system.cost;
    ++passes;
    return sum;
  }
  void accept() override {
    ++accepted;
    never_worse = never_worse && latest_cost_ <= accepted_cost_;
    accepted_cost_ = latest_cost_;
  }
  Result<void> gather(const calib::Estimate&, calib::FindingsGatherer&) override { return {}; }

  int passes = 0, accepted = 0, changes_left = 0;
  bool never_worse = true;  ///< than what was accepted before

 private:
  double latest_cost_ = 0.0, accepted_cost_ = INFINITY;
  std::function<void(double, double&, double&)> residual_;
};

/// An estimate of that parameter.
inline calib::Estimate at(double x, double prior_mean = 0.0, double prior_sigma = INFINITY) {
  calib::Estimate estimate;
  estimate.layout.parameters.push_back({.prior_mean = prior_mean, .prior_sigma = prior_sigma});
  estimate.layout.blocks.push_back({0, 1});
  estimate.layout.speed = {0};
  estimate.layout.fixed.speed_offset_mps = {0.0};
  estimate.x.setConstant(1, x);
  return estimate;
}

}  // namespace octant::test

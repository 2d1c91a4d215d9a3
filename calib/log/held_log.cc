// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/log/held_log.h"

#include <algorithm>
#include <utility>

#include "calib/adjust/adjust.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/problem/flips.h"
#include "calib/stream/long_log.h"
#include "calib/verdict/left_out.h"

namespace octant::calib {
namespace {

/// If a beacon is hardly determined, the last adjustment moves slowly along a curved valley, but converges.
constexpr int kIterationsToRest = 4;

}  // namespace

Result<CalibrationLog::Sample> HeldLog::next_sample() {
  if (is_complete_) return Sample{};
  if (!part_ && is_long(problem_))
    if (auto part = subsample_of(problem_, options_.threads)) return Sample{&part_.emplace(std::move(*part))};
  is_complete_ = true;
  return Sample{&problem_, true};
}

Result<double> HeldLog::place(Approach& start, double sigma) {
  part_.reset();
  if (is_complete_) {
    trajectories_ = std::move(start.trajectories);
    start_headings_rad_ = std::move(start.start_headings_rad);
    return sigma;
  }
  if (own_trajectories_ != nullptr) {
    trajectories_ = std::move(*own_trajectories_);
  } else {
    trajectories_ = problem_.trajectories;
  }
  const Estimate& estimate = start.estimate;
  const SharedState state = estimate.state();
  place_all(problem_, estimate.layout, state, estimate.beacon_usable,
            options_.rejection_sigmas * std::max(1.0, sigma), options_.workers(), trajectories_);
  start_headings_rad_ = epoch_headings_rad(trajectories_);
  return agreeing_sigma(trajectories_, state);
}

Result<DataSquares> HeldLog::adjust_inliers(Estimate& estimate) {
  for (int round = 0; round < kRejectionRounds; ++round) {
    if (!monitor_.report_inliers(round)) return interrupted();
    const std::size_t changed =
        reject_outliers(trajectories_, estimate.state(), options_.rejection_sigmas, options_.threads);
    if (round > 0 && changed == 0) break;
    estimate.last.data.reset();
    if (!adjust_to_rest(estimate)) return interrupted();
  }
  statistics_ = statistics(estimate);
  DataSquares squares{estimate.last.cost - prior_cost(problem_, estimate.layout, estimate.x),
                      statistics_->redundancy};
  for (const Trajectory& t : trajectories_) squares.poses.add(squares_of_poses(t, estimate.state()));
  return squares;
}

bool HeldLog::adjust_to_rest(Estimate& estimate) {
  AdjustOptions to_rest = monitor_.adjust_options(0.0, 1e-12);
  to_rest.max_iterations *= kIterationsToRest;
  estimate.last = adjust(problem_, estimate.layout, trajectories_, estimate.x, to_rest);
  return !estimate.last.interrupted;
}

CalibrationStatistics HeldLog::statistics(const Estimate& estimate) const {
  return statistics_of(problem_, estimate.layout, trajectories_, estimate.state(), estimate.last.cost,
                       options_.threads);
}

void HeldLog::scale_noise(Estimate& estimate, const NoiseFactors& factors) {
  const double before_s = problem_.site.noise.tof_sigma_s * estimate.noise_factor;
  estimate.noise_factor *= factors.arrivals;
  estimate.pose_factor *= factors.poses;
  rescale_noise(trajectories_, before_s, factors.arrivals * before_s);
  rescale_poses(trajectories_, factors.poses);
  estimate.last.data.reset();
  statistics_.reset();
}

Result<Findings> HeldLog::findings(const Estimate& estimate) {
  Findings f;
  const SharedState state = estimate.state();
  f.statistics = statistics_ ? *statistics_ : statistics(estimate);
  f.flips = report_flips(problem_.site, problem_.runs, trajectories_, start_headings_rad_);
  f.left_out = left_out_of(problem_, trajectories_, state);
  f.trajectories = std::move(trajectories_);
  return f;
}

void HeldLog::resume(const std::vector<Trajectory>& trajectories) {
  trajectories_ = trajectories;
  statistics_.reset();
}

}  // namespace octant::calib

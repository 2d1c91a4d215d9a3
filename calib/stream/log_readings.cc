// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_readings.h"

namespace octant::calib {

Result<LogReadings::Placed> JoinedReadings::place(const Estimate& estimate, double suspect_sigmas,
                                                  bool reject) {
  Placed all;
  for (const auto& some : all_) {
    auto placed = some->place(estimate, suspect_sigmas, reject && all_.size() == 1);
    if (!placed) return placed;
    all.residuals.insert(all.residuals.end(), placed->residuals.begin(), placed->residuals.end());
    all.ranges_m.insert(all.ranges_m.end(), placed->ranges_m.begin(), placed->ranges_m.end());
    all.states += placed->states;
    all.sum = std::move(placed->sum);
  }
  return all;
}

Result<PassSum> JoinedReadings::pass(const Estimate& estimate, RejectionPolicy policy) {
  std::optional<PassSum> sum;
  for (const auto& some : all_) {
    auto next = some->pass(estimate, policy);
    if (!next) return next;
    if (sum) {
      sum->add(*next);
    } else {
      sum = std::move(*next);
    }
  }
  return std::move(*sum);
}

void JoinedReadings::accept() {
  for (const auto& some : all_) some->accept();
}

Result<void> JoinedReadings::gather(const Estimate& estimate, FindingsGatherer& gatherer) {
  for (const auto& some : all_)
    if (auto ok = some->gather(estimate, gatherer); !ok) return ok;
  return {};
}

}  // namespace octant::calib

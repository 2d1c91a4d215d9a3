// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "apps/octant/steps/steps.h"
#include "io/site/batch_yaml.h"

// Calibration of many sites in one process, or in several that share a list.
namespace octant::app {

/// Every `count`-th site starting with number `index`, counted from 0, for a job of an array or a rank.
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;
  [[nodiscard]] bool has(std::size_t number) const { return number % count == index; }
};

/// Outcome of the calibration of one site.
struct SiteOutcome {
  std::size_t number = 0;  ///< number in the list, from 0
  Exit exit = kDone;       ///< exit code that `octant calibrate` would have returned
  std::string message;     ///< reason of the failure; empty for success
  Json object;             ///< object of `octant calibrate`, without the data of single arrivals
};

/// Calibrates the sites of a shard in parallel on the session's threads and writes their outputs. A failed
/// site does not stop the others. After an interruption the remaining sites are kInterrupted; completed
/// outputs are kept.
/// @param on_done  called after each site, by one thread at a time
/// @return outcomes in the order of the list
[[nodiscard]] std::vector<SiteOutcome> calibrate_sites(
    const io::Batch& batch, Shard shard, const CalibrateOptions& how, const Session& session,
    const std::function<void(const SiteOutcome&)>& on_done);

}  // namespace octant::app

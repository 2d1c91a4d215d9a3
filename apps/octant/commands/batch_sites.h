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

// Many sites in one process, or in one of several that share a list.
namespace octant::app {

/// Every `count`-th site, from the site of number `index` on, numbers counted from 0: a job of an array, a
/// rank.
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;
  [[nodiscard]] bool has(std::size_t number) const { return number % count == index; }
};

/// What has come of one site.
struct SiteOutcome {
  std::size_t number = 0;  ///< in the list, from 0
  Exit exit = kDone;       ///< as `octant calibrate` of it would have ended
  std::string message;     ///< why it failed; empty where it did not
  Json object;             ///< that of `octant calibrate`, less what belongs to single arrivals
};

/// Calibrates the sites of a shard side by side on the session's threads, and writes what each of them is to
/// write. One that fails does not stop the others. After an interruption the sites that are not done are
/// kInterrupted; those that are stay written.
/// @param on_done  called once a site is done, from one thread at a time
/// @return in the order of the list
[[nodiscard]] std::vector<SiteOutcome> calibrate_sites(
    const io::Batch& batch, Shard shard, const CalibrateOptions& how, const Session& session,
    const std::function<void(const SiteOutcome&)>& on_done);

}  // namespace octant::app

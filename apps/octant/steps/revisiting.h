// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "apps/octant/session.h"
#include "calib/revisit/revisit.h"
#include "models/deployment.h"

// What recalibrate and monitor share: both ask a second visit what changed.
namespace octant::app {

/// --drift-...: standard deviations since the earlier calibration, in the place of those of the site and the
/// time that passed.
struct DriftArgs {
  std::optional<double> beacon_m, delay_s, receiver_m, speed_mps;
};
void add_drift_options(CLI::App& command, DriftArgs& args);
/// @param now  ISO 8601
[[nodiscard]] Drift stated_drift(const Deployment& before, const std::string& now, const DriftArgs& args);

/// A visit and what it was held against.
struct SecondVisitFiles {
  Deployment before;
  std::vector<InputDigest> inputs;
  Json head;  ///< what `octant history` wants to know of the result
  calib::Revisit revisit;
};
/// Reads both and asks; progress and warnings go to the session. Failures of reading; numerical trouble is in
/// the revisit.
[[nodiscard]] SecondVisitFiles revisit_files(const std::string& deployment,
                                             const std::vector<std::string>& runs, const DriftArgs& drift,
                                             Session& session);
/// Why nothing can be said of it; none where something can.
[[nodiscard]] std::optional<Failure> failure_of(const calib::Revisit& revisit);

/// What was found, of both commands: changes, what was heard of each beacon and receiver, how each was
/// tested, the medium.
[[nodiscard]] Json revisit_json(const SecondVisitFiles& visit, const Session& session);
/// The same for people.
[[nodiscard]] std::string revisit_text(const SecondVisitFiles& visit);
/// Whether somebody has to do something: dirt and warmer air are none of that.
[[nodiscard]] bool needs_action(const Change& change, const calib::MediumFound& medium);

}  // namespace octant::app

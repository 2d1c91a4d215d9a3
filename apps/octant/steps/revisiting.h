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

// Common part of recalibrate and monitor, which both find changes from a second visit.
namespace octant::app {

/// --drift-...: standard deviations since the earlier calibration, in the place of those of the site and the
/// time that passed.
struct DriftArgs {
  std::optional<double> beacon_m, delay_s, receiver_m, speed_mps;
};
void add_drift_options(CLI::App& command, DriftArgs& args);
/// @param now  ISO 8601
[[nodiscard]] Drift stated_drift(const Deployment& before, const std::string& now, const DriftArgs& args);

/// A second visit and the deployment that it was compared with.
struct SecondVisitFiles {
  Deployment before;
  std::vector<InputDigest> inputs;
  Json head;  ///< information for `octant history`
  calib::Revisit revisit;
};
/// Reads both and runs the comparison; progress and warnings go to the session. Fails on read errors;
/// numerical failures are part of the revisit.
[[nodiscard]] SecondVisitFiles revisit_files(const std::string& deployment,
                                             const std::vector<std::string>& runs, const DriftArgs& drift,
                                             Session& session);
/// Reason for which a revisit gives no result; no value if it does.
[[nodiscard]] std::optional<Failure> failure_of(const calib::Revisit& revisit);

/// Results of both commands: changes, received arrivals of each beacon and receiver, significance tests, and
/// the medium.
[[nodiscard]] Json revisit_json(const SecondVisitFiles& visit, const Session& session);
/// The results as text for people.
[[nodiscard]] std::string revisit_text(const SecondVisitFiles& visit);
/// Returns true if a change requires action. Dirt and warmer air do not.
[[nodiscard]] bool needs_action(const Change& change, const calib::MediumFound& medium);

}  // namespace octant::app

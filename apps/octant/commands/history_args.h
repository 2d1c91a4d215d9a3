// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "io/history/history.h"

namespace octant::app {

/// What the user says to `octant history`; each of its commands takes its own part.
struct HistoryArgs {
  std::string database = "site.octant.db";
  std::vector<std::string> files;   ///< add
  std::string who, note;            ///< add
  std::string site, kind;           ///< list, trend, export: which visits
  std::int64_t id = 0;              ///< show
  std::string beacon;               ///< trend
  std::optional<double> limit_m{};  ///< trend
  std::string output;               ///< export
};

int history_trend(const HistoryArgs& args, Session& session);

/// A visit without its document and beacons.
[[nodiscard]] Json visit_json(const io::Visit& visit);
[[nodiscard]] Json visit_beacons_json(const io::Visit& visit);
/// The one site of a history, or the one that was named. Fails where there are several, or none of this name.
[[nodiscard]] std::string chosen_site(io::History& history, const HistoryArgs& args);

}  // namespace octant::app

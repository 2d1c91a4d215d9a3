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

/// Arguments of `octant history`; each of its commands uses some of them.
struct HistoryArgs {
  std::string database = "site.octant.db";
  std::vector<std::string> files;   ///< add
  std::string who, note;            ///< add
  std::string site, kind;           ///< list, trend and export: filter of the visits
  std::int64_t id = 0;              ///< show
  std::string beacon;               ///< trend
  std::optional<double> limit_m{};  ///< trend
  std::string output;               ///< export
};

int history_trend(const HistoryArgs& args, Session& session);

/// A visit without its document and its beacons.
[[nodiscard]] Json visit_json(const io::Visit& visit);
[[nodiscard]] Json visit_beacons_json(const io::Visit& visit);
/// Name of the only site of a history, or of the one that was chosen. Fails if there are several sites and no
/// choice, or no site of this name.
[[nodiscard]] std::string chosen_site(io::History& history, const HistoryArgs& args);

}  // namespace octant::app

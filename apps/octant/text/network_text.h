// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "calib/network/adjust_network.h"
#include "io/network/network_file.h"

namespace octant::app {

/// A survey network, its adjustment, and the points whose approximate coordinates were computed.
struct AdjustedNetwork {
  io::NetworkFile file;
  calib::NetworkSolution solution;
  std::vector<std::string> computed;
};

[[nodiscard]] std::string datum_in_words(const AdjustedNetwork& adjusted);
/// Points, covariance and observations; angles in the sense of the file.
[[nodiscard]] Json network_json(const AdjustedNetwork& adjusted);
[[nodiscard]] std::string network_text(const AdjustedNetwork& adjusted, bool all_observations);
/// Observations whose w exceeds the critical value of the test, the largest first.
[[nodiscard]] std::vector<std::string> suspicious_observations(const AdjustedNetwork& adjusted);

}  // namespace octant::app

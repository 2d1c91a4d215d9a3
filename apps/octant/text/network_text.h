// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "calib/network/solve_network.h"
#include "io/network/network_file.h"

namespace octant::app {

/// A survey network as its file describes it, and its adjustment.
struct AdjustedNetwork {
  io::NetworkFile file;
  calib::SolvedNetwork solved;
};

[[nodiscard]] std::string datum_in_words(const AdjustedNetwork& adjusted);
/// Points, covariance and observations; angles in the sense of the file.
[[nodiscard]] Json network_json(const AdjustedNetwork& adjusted);
[[nodiscard]] std::string network_text(const AdjustedNetwork& adjusted, bool all_observations);
/// Points and observations that were left out.
[[nodiscard]] std::vector<std::string> left_out_in_words(const AdjustedNetwork& adjusted);
/// Observations whose w exceeds the critical value of the test, the largest first.
[[nodiscard]] std::vector<std::string> suspicious_observations(const AdjustedNetwork& adjusted);

}  // namespace octant::app

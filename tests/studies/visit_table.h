// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/studies/changed_site.h"

namespace octant::study {

/// Result for one true change.
struct Told {
  double sigmas = 0.0;    ///< its size over the sigma of its size, as reports print it
  double distance = 0.0;  ///< Mahalanobis' distance in the covariance of its estimate
  double power = 0.0;     ///< probability that the test at its stated level finds it
  double at_best = 0.0;   ///< power of a test of that level that knows the direction beforehand
  bool found = false, right = false;
};
/// Result of recalibration or monitoring for a visit.
struct Answer {
  bool ok = false;
  std::string message;
  std::vector<Told> told;
  std::vector<std::string> innocent;  ///< accused subjects
  double seconds = 0.0;
};

/// One site.
struct Score {
  Event event = Event::kNothing;
  std::uint64_t seed = 0;
  bool drives = false;
  std::string fault;
  Answer recalibrated, monitored;
  double nees = 0.0, squares = 0.0, fresh_squares = 0.0;
  int coordinates = 0, compared = 0;
};

/// A line of what went wrong at a site; of any site if `verbose`.
void print_score(const Score& score, bool verbose);

/// The table of all sites, and whether they keep the marks, each within the binomial bound of 99 %.
/// @return marks that are not kept
[[nodiscard]] int print_table(const std::vector<Score>& scores);

}  // namespace octant::study

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace octant::survey {

/// Objective: the expected horizontal standard deviation of a fix over the floor.
enum class PlacementGoal {
  kWorst,  ///< its largest
  kP95,    ///< 95th percentile of the cells
  kMean
};
enum class GlobalAlgorithm { kNone, kCrs2, kDirect, kIsres, kEsch };
enum class LocalAlgorithm { kNone, kBobyqa, kCobyla, kSbplx };

/// By the names that the command line knows.
[[nodiscard]] std::optional<PlacementGoal> placement_goal(const std::string& name);
[[nodiscard]] std::optional<GlobalAlgorithm> global_algorithm(const std::string& name);
[[nodiscard]] std::optional<LocalAlgorithm> local_algorithm(const std::string& name);

struct PlacementOptions {
  PlacementGoal goal = PlacementGoal::kWorst;
  GlobalAlgorithm global = GlobalAlgorithm::kCrs2;
  LocalAlgorithm local = LocalAlgorithm::kSbplx;
  std::uint64_t seed = 1;
  bool keep = false;  ///< the model's beacons stay; others are added
  int coverage = 0;   ///< beacons that each cell must receive; 0: as many as a fix needs
  int restarts = 6;   ///< random layouts from which searches start, in addition to greedy and regular ones
  std::size_t evaluations = 0;     ///< evaluations by each algorithm; 0: by the number of beacons
  std::size_t cells = 300;         ///< approximate number of cells during the search
  std::size_t final_cells = 8000;  ///< approximate largest number of cells for the stated figures
  int threads = 1;
  std::function<bool(double fraction)> on_progress;  ///< false stops with what there is
};

/// Quality of a layout over the floor. Cells without a fix, or with fewer beacons than the coverage requires,
/// are not covered. They count as the size of the hall times one plus the missing number, so that fewer of
/// them are better.
struct LayoutFigures {
  double worst_m = 0.0, p95_m = 0.0,
         mean_m = 0.0;  ///< sigmas of the covered cells; 0 if there are no such cells
  double covered_fraction = 0.0;
  double objective_m = 0.0;  ///< the goal, uncovered cells included
  double mean_with_uncovered_m = 0.0;
  [[nodiscard]] bool covers_all() const { return covered_fraction >= 1.0; }
};

}  // namespace octant::survey

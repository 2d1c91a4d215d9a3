// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"
#include "survey/placement/mounts.h"

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

struct PlacedBeacon {
  SurveyBeacon beacon;
  std::string mount;  ///< name of the scene's mount; empty: it was there already
};

struct Placement {
  std::vector<PlacedBeacon> beacons;       ///< kept ones first
  LayoutFigures figures, greedy, regular;  ///< over the final cells; regular: the best of eight phases
  LayoutFigures random;                    ///< the median of 25 layouts by their objective
  std::size_t evaluations = 0, cells = 0;
  bool interrupted = false;
};

/// Places the given number of beacons (kept ones included) on the mounts of the scene: greedy choice from a
/// grid of positions, exchanges on that grid until none improves the layout, then NLopt's global and local
/// algorithms on the mounts (S. G. Johnson, The NLopt nonlinear-optimization package). The result is the best
/// of all, so it is never worse than the greedy one. Deterministic for a seed. Errors: a scene without
/// mounts, fewer beacons than are kept, a floor without cells.
[[nodiscard]] Result<Placement> place_beacons(const SurveyModel& model, const Scene& scene,
                                              std::size_t beacons, const PlacementOptions& options);

/// The smallest number of beacons whose goal is within the tolerance and that covers every cell.
struct SmallestPlacement {
  bool reached = false;
  std::vector<std::pair<std::size_t, LayoutFigures>> tried;
  Placement placement;  ///< placement with the smallest sufficient number, or with the last number tried
};
[[nodiscard]] Result<SmallestPlacement> smallest_placement(const SurveyModel& model, const Scene& scene,
                                                           double tolerance_m, std::size_t most_beacons,
                                                           const PlacementOptions& options);

/// Quality of an existing layout, on the cells for which a placement states its figures.
[[nodiscard]] Result<LayoutFigures> layout_figures(const SurveyModel& model, const Scene& scene,
                                                   const PlacementOptions& options);

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: score of a set of beacons over some poses, evaluated many thousand times.

#include <cstdint>
#include <span>
#include <vector>

#include "survey/geometry/geometry_map.h"
#include "survey/placement/placement_options.h"

namespace octant::survey {

inline constexpr double kMeanShare = 1e-3;  ///< weight of the mean in the ranking of layouts

class LayoutScore {
 public:
  LayoutScore(SurveyModel model, PoseList poses, const PlacementOptions& options);

  /// The beacons of the layout only.
  [[nodiscard]] LayoutFigures of(const std::vector<SurveyBeacon>& beacons);
  /// Information of a beacon at all poses; the sum of layers represents a layout.
  [[nodiscard]] BeaconLayer layer(const SurveyBeacon& beacon) const {
    return beacon_layer(model_, beacon, poses_, options_.threads);
  }
  /// The objective, and the mean if the objective does not distinguish two layouts.
  [[nodiscard]] static double value(const LayoutFigures& figures) {
    return figures.objective_m + kMeanShare * figures.mean_with_uncovered_m;
  }

  /// Objective of a search far from the best layout. It assumes a weak prior of the pose, so that each
  /// further beacon improves all cells a little, and a high power mean instead of the worst cell (the plain
  /// mean for the goal kMean).
  [[nodiscard]] double soft_value(const std::vector<SurveyBeacon>& beacons);

  /// Layers added up, for searches that change one beacon at a time.
  struct Sum {
    std::vector<double> information;
    std::vector<std::uint16_t> heard;
    void add(const BeaconLayer& layer, int sign = 1);
  };
  [[nodiscard]] Sum no_beacons() const;
  /// Score of a sum and one more layer (null: no further layer).
  [[nodiscard]] double value_with(const Sum& sum, const BeaconLayer* layer, bool soft);

  /// Looks at further poses too.
  void add_poses(const PoseList& poses);
  [[nodiscard]] const PoseList& poses() const { return poses_; }
  /// Error of each pose in the layout that the last call of of() evaluated.
  [[nodiscard]] const std::vector<double>& errors_m() const { return errors_; }

 private:
  LayoutFigures figures(std::span<const double> sigma_m, std::span<const std::uint16_t> heard);
  [[nodiscard]] double error(double sigma_m, int heard) const;
  [[nodiscard]] double hard(std::span<const double> sigma_m, std::span<const std::uint16_t> heard);
  [[nodiscard]] double soft(std::span<const double> sigma_m, std::span<const std::uint16_t> heard) const;
  void resize();

  SurveyModel model_;
  PoseList poses_;
  PlacementOptions options_;
  int required_ = 1;  ///< beacons below which there is no fix, or no coverage
  double hopeless_m_ = 1.0;
  std::vector<double> errors_, covered_;
  std::vector<double> sigma_m_;
  std::vector<double> vague_;  ///< information of the weak prior of the pose, entry by entry
  std::vector<double> sum_;    ///< scratch, as is heard_
  std::vector<std::uint16_t> heard_;
};

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: what a set of beacons is worth over some poses, many thousand times.

#include <cstdint>
#include <span>
#include <vector>

#include "survey/geometry/geometry_map.h"
#include "survey/placement/placement.h"

namespace octant::survey {

inline constexpr double kMeanShare = 1e-3;  ///< of the mean in what layouts are ranked by

class LayoutScore {
 public:
  LayoutScore(SurveyModel model, PoseList poses, const PlacementOptions& options);

  /// The layout's own beacons, and nothing else.
  [[nodiscard]] LayoutFigures of(const std::vector<SurveyBeacon>& beacons);
  /// What a beacon tells at all poses; sums of layers stand for layouts.
  [[nodiscard]] BeaconLayer layer(const SurveyBeacon& beacon) const {
    return beacon_layer(model_, beacon, poses_, options_.threads);
  }
  /// The objective, and the mean where that cannot tell two layouts apart.
  [[nodiscard]] static double value(const LayoutFigures& figures) {
    return figures.objective_m + kMeanShare * figures.mean_with_uncovered_m;
  }

  /// What a search goes down on far from the best layout: as if a vague idea of the pose were there already,
  /// so that each beacon more helps a little everywhere, and a high power mean for the worst cell (the plain
  /// mean for the goal kMean).
  [[nodiscard]] double soft_value(const std::vector<SurveyBeacon>& beacons);

  /// Layers added up, for searches that change one beacon at a time.
  struct Sum {
    std::vector<double> information;
    std::vector<std::uint16_t> heard;
    void add(const BeaconLayer& layer, int sign = 1);
  };
  [[nodiscard]] Sum no_beacons() const;
  /// Of a sum and one layer more (none: null).
  [[nodiscard]] double value_with(const Sum& sum, const BeaconLayer* layer, bool soft);

  /// Looks at further poses too.
  void add_poses(const PoseList& poses);
  [[nodiscard]] const PoseList& poses() const { return poses_; }
  /// Error that each pose counts with, of the layout that of() looked at last.
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
  std::vector<double> vague_;  ///< information of the vague idea of the pose, entry by entry
  std::vector<double> sum_;    ///< scratch, as is heard_
  std::vector<std::uint16_t> heard_;
};

}  // namespace octant::survey

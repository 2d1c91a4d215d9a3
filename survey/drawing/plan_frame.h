// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "survey/drawing/plan_input.h"

namespace octant::survey {

/// 1, 2 or 5 times a power of ten, not above x.
[[nodiscard]] double round_down(double x);

[[nodiscard]] bool is_drawn(const DeploymentBeacon& beacon);
/// The drawn beacon of that name; null if there is no such beacon or it is not drawn.
[[nodiscard]] const DeploymentBeacon* drawn_beacon(const Deployment& deployment, const std::string& name);

/// A plan shows no more marks of a kind than this; more would not be seen.
inline constexpr std::size_t kMaxMarks = 2000;
/// Thins a list of points evenly to at most kMaxMarks.
[[nodiscard]] std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points_m);

inline constexpr double kPlanWidth_px = 900.0, kPlanMargin_px = 46.0;

/// Map metres to pixels, y up.
struct PlanFrame {
  Eigen::Vector2d low_m{0, 0}, high_m{1, 1};
  double px_per_m = 1.0, height_px = 0.0;
  [[nodiscard]] double x(double x_m) const { return kPlanMargin_px + (x_m - low_m.x()) * px_per_m; }
  [[nodiscard]] double y(double y_m) const { return kPlanMargin_px + (high_m.y() - y_m) * px_per_m; }
  [[nodiscard]] double extent_m() const { return (high_m - low_m).maxCoeff(); }
};

/// Frame around all drawn objects.
[[nodiscard]] PlanFrame plan_frame(const PlanInput& input);

/// One map as a layer, with the legend of its classes at height y.
[[nodiscard]] std::string map_layer_svg(const NamedMap& map, std::size_t index, const PlanFrame& frame,
                                        double legend_y_px);

}  // namespace octant::survey

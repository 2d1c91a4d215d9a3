// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "survey/drawing/escape.h"
#include "survey/drawing/palette.h"
#include "survey/drawing/plan_frame.h"
#include "survey/drawing/site_plan.h"

namespace octant::survey {
namespace {

constexpr double kLeastRatio = 1.5;
constexpr const char* kNoFixColour = "#787878";

/// Cells of one class (behind them all: those without a fix) as one path, each run of neighbours in a row as
/// one rectangle.
std::string cells(const NamedMap& map, const std::vector<double>& limits, std::size_t wanted,
                  const PlanFrame& frame) {
  const auto class_of = [&](double v) {
    return std::isnan(v)   ? limits.size() + 2
           : std::isinf(v) ? limits.size() + 1
                           : static_cast<std::size_t>(std::ranges::upper_bound(limits, v) - limits.begin());
  };
  std::string path;
  const double side_px = map.cell_m * frame.px_per_m;
  for (std::size_t first = 0; first < map.values.size();) {
    const std::size_t row = first / map.columns, end = std::min((row + 1) * map.columns, map.values.size());
    if (class_of(map.values[first]) != wanted) {
      ++first;
      continue;
    }
    std::size_t last = first;
    while (last < end && class_of(map.values[last]) == wanted) ++last;
    const double x = frame.x(map.corner_m.x() + map.cell_m * static_cast<double>(first % map.columns));
    const double y = frame.y(map.corner_m.y() + map.cell_m * static_cast<double>(row + 1));
    path += fmt::format("M{:.1f} {:.1f}h{:.1f}v{:.1f}h-{:.1f}z", x, y,
                        side_px * static_cast<double>(last - first), side_px,
                        side_px * static_cast<double>(last - first));
    first = last;
  }
  return path;
}

}  // namespace

std::vector<double> map_classes(const NamedMap& map) {
  if (map.tolerance) {
    std::vector<double> limits;
    for (const double part : kToleranceParts) limits.push_back(part * *map.tolerance);
    return limits;
  }
  if (!map.limits.empty()) return map.limits;
  std::vector<double> values;
  std::ranges::copy_if(map.values, std::back_inserter(values), [](double v) { return std::isfinite(v); });
  if (values.empty()) return {};
  std::ranges::sort(values);
  // Extreme values would otherwise occupy all classes.
  const double low = values.front();
  double high = values[static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1))];
  if (!(high > low)) return {};
  // Irrelevant differences should not use the whole range of colours.
  if (low > 0) high = std::max(high, kLeastRatio * low);
  std::vector<double> limits;
  const double classes = static_cast<double>(kMapColours.size());
  for (double k = 1; k < classes; ++k)
    limits.push_back(low > 0 ? low * std::pow(high / low, k / classes) : low + (high - low) * k / classes);
  return limits;
}

std::string map_layer_svg(const NamedMap& map, std::size_t index, const PlanFrame& frame,
                          double legend_y_px) {
  const std::vector<double> limits = map_classes(map);
  std::string svg = fmt::format("<g class='layer layer-{}'>\n", index);
  if (map.columns == 0) return svg + "</g>\n";
  const std::string unit = map.unit.empty() ? "" : " [" + map.unit + "]";
  const auto& colours = map.tolerance ? kToleranceColours : kMapColours;
  // The chooser names the map, so the legend only refers to the tolerance.
  const std::string what = map.tolerance
                               ? fmt::format("against the tolerance of {:.3g} {}", *map.tolerance, map.unit)
                               : map.name + unit;
  std::string legend = fmt::format("<g class='legend'><text x='{:.1f}' y='{:.1f}'>{}</text>\n",
                                   kPlanMargin_px - 4, legend_y_px, escape_xml(what + ":"));
  double x = kPlanMargin_px + 6.6 * static_cast<double>(what.size() + 2);
  for (std::size_t k = 0; k <= limits.size() + 1; ++k) {
    const std::string path = cells(map, limits, k, frame);
    const bool no_fix = k > limits.size();
    if (no_fix && path.empty()) break;
    const char* colour = no_fix ? kNoFixColour : colours[k];
    if (!path.empty()) svg += fmt::format("<path class='cell' fill='{}' d='{}'/>\n", colour, path);
    const std::string label = no_fix               ? "no fix"
                              : limits.empty()     ? "all the same"
                              : k == 0             ? fmt::format("below {:.3g}", limits[0])
                              : k == limits.size() ? fmt::format("from {:.3g}", limits.back())
                              : map.tolerance && limits[k - 1] == *map.tolerance
                                  ? fmt::format("{:.3g}, beyond it", limits[k - 1])
                                  : fmt::format("{:.3g}", limits[k - 1]);
    legend += fmt::format(
        "<rect class='swatch' fill='{}' x='{:.1f}' y='{:.1f}' width='14' height='12'/><text x='{:.1f}' "
        "y='{:.1f}'>{}</text>\n",
        colour, x, legend_y_px - 10, x + 18, legend_y_px, label);
    x += 28 + 6.6 * static_cast<double>(label.size());
  }
  return svg + legend + "</g>\n</g>\n";
}

}  // namespace octant::survey

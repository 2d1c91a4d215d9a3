// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/map_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>

#include <fmt/format.h>

#include "survey/drawing/escape.h"
#include "survey/drawing/palette.h"
#include "survey/drawing/plan_frame.h"
#include "survey/geometry/quantity.h"

namespace octant::survey {
namespace {

constexpr double kMargin_px = 40.0, kScale_px = 64.0;

constexpr const char* kMapStyle = R"(<style>
.map text{font:11px system-ui,sans-serif;fill:#1b2733}.map .paper{fill:#fff}.map .grid{stroke:#d9dfe5}.map .floor{fill:none;stroke:#1b2733;stroke-width:1.5}
.map .wall{fill:none;stroke:#1b2733;stroke-width:2}.map .obstacle{fill:#8a97a3;stroke:#1b2733}.map .route{fill:none;stroke:#fff;stroke-width:2;stroke-dasharray:6 4}
.map .beacon{fill:#fff;stroke:#1b2733;stroke-width:1.5}.map .axis{stroke:#1b2733}
@media(prefers-color-scheme:dark){.map text{fill:#dfe6ec}.map .paper{fill:#12181e}.map .grid{stroke:#2b353f}.map .floor,.map .wall,.map .axis{stroke:#dfe6ec}}
</style>
)";

struct Frame {
  Eigen::Vector2d low_m, high_m;
  double px_per_m = 1.0;
  [[nodiscard]] double x(double x_m) const { return kMargin_px + (x_m - low_m.x()) * px_per_m; }
  [[nodiscard]] double y(double y_m) const { return 12 + (high_m.y() - y_m) * px_per_m; }
  [[nodiscard]] double bottom() const { return y(low_m.y()); }
};

Frame frame_of(const Survey& survey, const BinnedMap& map, double width_px) {
  Frame frame{map.origin_m, map.origin_m + map.bin_m * Eigen::Vector2d(static_cast<double>(map.columns),
                                                                       static_cast<double>(map.rows))};
  for (const SurveyBeacon& b : survey.model.beacons) {
    frame.low_m = frame.low_m.cwiseMin(b.p_map_m.head<2>());
    frame.high_m = frame.high_m.cwiseMax(b.p_map_m.head<2>());
  }
  const Eigen::Vector2d size = frame.high_m - frame.low_m;
  // A corridor on end is not drawn ten times as high as the page is wide.
  frame.px_per_m = std::min((width_px - kMargin_px - 14) / std::max(size.x(), 1e-6),
                            1.2 * width_px / std::max(size.y(), 1e-6));
  return frame;
}

/// Runs of bins with one colour in a row are one rectangle, and all rectangles of a colour one path: a third
/// of the bytes.
void draw_bins(std::string& svg, const BinnedMap& map, const Frame& frame) {
  std::map<std::array<std::uint8_t, 3>, std::string> paths;
  for (std::size_t row = 0; row < map.rows; ++row)
    for (std::size_t column = 0; column < map.columns;) {
      const std::size_t at = row * map.columns + column;
      if (map.bins[at] == BinnedMap::Bin::kOffFloor) {
        ++column;
        continue;
      }
      const auto colour = colour_of(map, at);
      std::size_t end = column + 1;
      while (end < map.columns && map.bins[row * map.columns + end] != BinnedMap::Bin::kOffFloor &&
             colour_of(map, row * map.columns + end) == colour)
        ++end;
      const double x0 = map.origin_m.x() + map.bin_m * static_cast<double>(column),
                   y1 = map.origin_m.y() + map.bin_m * static_cast<double>(row + 1);
      // A hair wider, so that no paper shines through between rows.
      const double width = map.bin_m * static_cast<double>(end - column) * frame.px_per_m + 0.3;
      fmt::format_to(std::back_inserter(paths[colour]), "M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}z", frame.x(x0),
                     frame.y(y1), width, map.bin_m * frame.px_per_m + 0.3, -width);
      column = end;
    }
  svg += "<g shape-rendering='crispEdges'>";
  for (const auto& [colour, path] : paths)
    svg += fmt::format("<path fill='#{:02x}{:02x}{:02x}' d='{}'/>", colour[0], colour[1], colour[2], path);
  svg += "</g>\n";
}

std::string points_of(const std::vector<Eigen::Vector2d>& points, const Frame& frame) {
  std::string text;
  for (const Eigen::Vector2d& p : points)
    text += fmt::format("{:.1f},{:.1f} ", frame.x(p.x()), frame.y(p.y()));
  return text;
}

void draw_place(std::string& svg, const Survey& survey, const Frame& frame, bool names) {
  for (const SceneWall& wall : survey.scene.walls)
    if (wall.blocks_sound)
      svg += fmt::format("<{} class='{}' points='{}'/>\n", wall.solid ? "polygon" : "polyline",
                         wall.solid ? "obstacle" : "wall", points_of(wall.points_m, frame));
  svg += fmt::format("<polygon class='floor' points='{}'/>\n", points_of(survey.model.floor_m, frame));
  for (const SceneRoute& route : survey.scene.routes)
    svg += fmt::format("<polyline class='route' points='{}'/>\n", points_of(route.points_m, frame));
  for (const SurveyBeacon& b : survey.model.beacons) {
    const double x = frame.x(b.p_map_m.x()), y = frame.y(b.p_map_m.y());
    svg += fmt::format("<circle class='beacon' cx='{:.1f}' cy='{:.1f}' r='4'/>", x, y);
    if (names)
      svg += fmt::format("<text x='{:.1f}' y='{:.1f}'>{}</text>\n", x + 6, y - 5, escape_xml(b.name));
  }
}

void draw_axes(std::string& svg, const Frame& frame) {
  const double step = round_down((frame.high_m - frame.low_m).maxCoeff() / 4);
  for (double k = std::ceil(frame.low_m.x() / step); k * step <= frame.high_m.x(); ++k)
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{:.10g}</text>", frame.x(k * step),
                       frame.bottom() + 14, k * step + 0.0);
  for (double k = std::ceil(frame.low_m.y() / step); k * step <= frame.high_m.y(); ++k)
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{:.10g}</text>", kMargin_px - 6,
                       frame.y(k * step) + 4, k * step + 0.0);
  svg += "\n";
}

/// The classes of a map that is held against a tolerance, each as wide: what they end at stands between them.
void draw_classes(std::string& svg, const BinnedMap& map, const Frame& frame, double width_px) {
  const double y = frame.bottom() + 28, left = kMargin_px;
  const double each = (width_px - kMargin_px - 14) / static_cast<double>(kToleranceColours.size());
  const auto end_of = [&](std::size_t k) { return left + each * static_cast<double>(k + 1); };
  for (std::size_t k = 0; k < kToleranceColours.size(); ++k)
    svg += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.2f}' height='8' fill='{}'/>",
                       left + each * static_cast<double>(k), y, each + 0.3, kToleranceColours[k]);
  // Room for three: half of it, the tolerance, twice that.
  for (const double part : {0.5, 1.0, 2.0}) {
    const auto at = std::ranges::find(kToleranceParts, part);
    const double x = end_of(static_cast<std::size_t>(at - kToleranceParts.begin()));
    svg += fmt::format("\n<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}{}</text>", x, y + 21,
                       part == 1.0 ? "tolerance " : "", figure_text(part * map.high, map.unit));
  }
  svg += fmt::format("\n<text x='{:.1f}' y='{:.1f}' text-anchor='end'>grey: no fix</text>\n", width_px - 14,
                     y + 34);
}

/// The range of a map that nothing is held against.
void draw_range(std::string& svg, const BinnedMap& map, const Frame& frame, double width_px) {
  const double y = frame.bottom() + 28, left = kMargin_px, width = width_px - kMargin_px - 14;
  BinnedMap scale = map;
  scale.columns = 32, scale.rows = 1;
  scale.bins.assign(32, BinnedMap::Bin::kValue);
  scale.values.resize(32);
  for (std::size_t i = 0; i < 32; ++i) {
    scale.values[i] = map.low + (map.high - map.low) * static_cast<double>(i) / 31;
    const auto c = colour_of(scale, i);
    svg += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.2f}' height='8' fill='#{:02x}{:02x}{:02x}'/>",
                       left + width * static_cast<double>(i) / 32, y, width / 32 + 0.3, c[0], c[1], c[2]);
  }
  svg += fmt::format(
      "\n<text x='{:.1f}' y='{:.1f}'>{}</text><text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}{}</text>\n",
      left, y + 21, figure_text(map.low, map.unit), left + width, y + 21, figure_text(map.high, map.unit),
      map.low_is_bad ? "; grey: no fix" : " and more; grey: no fix");
}

void draw_scale(std::string& svg, const BinnedMap& map, const Frame& frame, double width_px) {
  svg += "<g class='legend'>\n";
  (map.against_tolerance ? draw_classes : draw_range)(svg, map, frame, width_px);
  svg += "</g>\n";
}

}  // namespace

std::string figure_text(double value, const std::string& unit) {
  if (std::isinf(value)) return "no fix";
  if (unit == "m") return value < 0.0995 ? three_digits(1e3 * value) + " mm" : three_digits(value) + " m";
  return unit.empty() ? three_digits(value) : three_digits(value) + " " + unit;
}

std::string map_svg(const Survey& survey, const BinnedMap& map, const MapDrawing& drawing) {
  const Frame frame = frame_of(survey, map, drawing.width_px);
  const double height = frame.bottom() + kScale_px;
  std::string svg = fmt::format(
      "<svg class='map' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
      "height='{1:.0f}' role='img' "
      "aria-label='{2}'>\n<title>{2}</title>\n",
      drawing.width_px, height, escape_xml(map.title));
  svg += kMapStyle;
  svg += "<rect class='paper' width='100%' height='100%'/>\n";
  draw_bins(svg, map, frame);
  draw_place(svg, survey, frame, drawing.beacon_names);
  draw_axes(svg, frame);
  draw_scale(svg, map, frame, drawing.width_px);
  return svg + "</svg>\n";
}

}  // namespace octant::survey

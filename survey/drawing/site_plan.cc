// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/site_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "models/support/decompositions.h"
#include "survey/drawing/escape.h"
#include "survey/drawing/plan_frame.h"

namespace octant::survey {
namespace {

constexpr double kLegendRow_px = 24.0;

// Colours are written twice, because few programs except browsers support CSS variables. Marks differ in
// shape, not only in colour.
constexpr const char* kPlanStyle = R"(<style>
.plan text{font:12px system-ui,sans-serif;fill:#1b2733}.plan .name{font-weight:600;paint-order:stroke;stroke:#fff;stroke-width:3px}
.plan .paper{fill:#fff}.plan .grid{stroke:#d9dfe5}.plan .area{fill:#eef5ee;stroke:#5f7d69;stroke-dasharray:5 4}
.plan .track{fill:none;stroke:#5d6b78;stroke-width:1.2}.plan .stop{fill:none;stroke:#5d6b78;stroke-width:4;stroke-linecap:round}
.plan .fix{fill:none;stroke:#b3470b;stroke-width:1.3}.plan .beacon{fill:#1660a8}.plan .control{fill:#176b34}
.plan .beacon,.plan .control{stroke:#fff;stroke-width:1}.plan .dots{fill:none;stroke:#1660a8;stroke-width:5;stroke-linecap:round}.plan .ellipse{fill:#1660a8;fill-opacity:.15;stroke:#1660a8}
.plan .miss{fill:none;stroke:#b3261e;stroke-opacity:.45}.plan .early{stroke:#7a4a00;stroke-dasharray:6 4}.plan .other{stroke:#5d6b78;stroke-dasharray:2 4}.plan .missed{fill:#b3261e;fill-opacity:.3;stroke:#b3261e}
.plan .wall{fill:none;stroke:#1b2733;stroke-width:2}.plan .obstacle{fill:#8a97a3;stroke:#1b2733}.plan .route{fill:none;stroke:#1b2733;stroke-width:2;stroke-dasharray:6 4}
.plan .silent{stroke:#b3261e;stroke-width:3}.plan .move{fill:none;stroke:#b3261e;stroke-width:2}.plan .swatch{stroke:#1b2733;stroke-width:.5}.plan .layer~.layer{display:none}
@media(prefers-color-scheme:dark){.plan text{fill:#dfe6ec}.plan .name{stroke:#12181e}.plan .paper{fill:#12181e}.plan .grid{stroke:#2b353f}
.plan .area{fill:#18251d;stroke:#8fb09a}.plan .track,.plan .stop{stroke:#9aa7b3}.plan .fix{stroke:#f0945a}.plan .beacon{fill:#6db3f2}
.plan .control{fill:#67c587}.plan .beacon,.plan .control{stroke:#12181e}.plan .dots{stroke:#6db3f2}.plan .ellipse{fill:#6db3f2;stroke:#6db3f2}
.plan .wall,.plan .route{stroke:#dfe6ec}.plan .silent,.plan .move,.plan .miss,.plan .missed{stroke:#f2867e}.plan .missed{fill:#f2867e}.plan .early{stroke:#e6b35c}.plan .other{stroke:#9aa7b3}.plan .swatch{stroke:#dfe6ec}}
</style>
)";

void draw_grid(std::string& svg, const PlanFrame& frame, const char* axes) {
  const double step_m = round_down(frame.extent_m() / 6);
  const double right = frame.x(frame.high_m.x()), bottom = frame.y(frame.low_m.y()),
               left = frame.x(frame.low_m.x()), top = frame.y(frame.high_m.y());
  // Counted, not added up: a sum would drift and print 0.30000000000000004.
  for (double k = std::ceil(frame.low_m.x() / step_m); k * step_m <= frame.high_m.x(); ++k) {
    const double x = frame.x(k * step_m);
    svg += fmt::format(
        "<line class='grid' x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}'/>"
        "<text x='{0:.1f}' y='{3:.1f}' text-anchor='middle'>{4:.10g}</text>\n",
        x, top, bottom, bottom + 16, k * step_m + 0.0);
  }
  for (double k = std::ceil(frame.low_m.y() / step_m); k * step_m <= frame.high_m.y(); ++k) {
    const double y = frame.y(k * step_m);
    svg += fmt::format(
        "<line class='grid' x1='{1:.1f}' y1='{0:.1f}' x2='{2:.1f}' y2='{0:.1f}'/>"
        "<text x='{3:.1f}' y='{4:.1f}' text-anchor='end'>{5:.10g}</text>\n",
        y, left, right, left - 6, y + 4, k * step_m + 0.0);  // + 0.0: no "-0"
  }
  svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>\n", right, top - 10, axes);
}

std::string fix_mark(double x, double y) { return fmt::format("M{:.1f} {:.1f}l4 4l-4 4l-4 -4z", x, y - 4); }

/// @param project  of a point in the map to the drawing's plane
template <class Project>
void draw_tracks(std::string& svg, const PlanInput& input, const PlanFrame& frame, Project&& project) {
  for (const auto& track : input.tracks) {
    std::string path;
    for (const auto& p_m : thinned(track.points_m)) {
      const Eigen::Vector2d p = project(p_m);
      path += fmt::format("{}{:.1f} {:.1f}{}", !track.moving || path.empty() ? 'M' : 'L', frame.x(p.x()),
                          frame.y(p.y()), track.moving ? "" : "h0");
    }
    if (!path.empty())
      svg += fmt::format("<path class='{}' d='{}'/>\n", track.moving ? "track" : "stop", path);
  }
  std::string marks;
  for (const auto& p_m : thinned(input.fixes_m)) {
    const Eigen::Vector2d p = project(p_m);
    marks += fix_mark(frame.x(p.x()), frame.y(p.y()));
  }
  if (!marks.empty()) svg += "<path class='fix' d='" + marks + "'/>\n";
}

void draw_line(std::string& svg, const char* shape, const char* kind,
               const std::vector<Eigen::Vector2d>& points_m, const PlanFrame& frame) {
  svg += fmt::format("<{} class='{}' points='", shape, kind);
  for (const auto& p : points_m) svg += fmt::format("{:.1f},{:.1f} ", frame.x(p.x()), frame.y(p.y()));
  svg += "'/>\n";
}

void draw_place(std::string& svg, const PlanInput& input, const PlanFrame& frame) {
  for (const NamedLine& wall : input.walls)
    draw_line(svg, wall.closed ? "polygon" : "polyline", wall.closed ? "obstacle" : "wall", wall.points_m,
              frame);
  for (const NamedLine& route : input.routes) draw_line(svg, "polyline", "route", route.points_m, frame);
}

void draw_ellipse(std::string& svg, const DeploymentBeacon& beacon, const PlanFrame& frame,
                  double exaggeration) {
  const Eigen::Matrix2d C = beacon.covariance_m2.topLeftCorner<2, 2>();
  if (!C.allFinite()) return;
  const SymmetricEigen<Eigen::Matrix2d> eigen(C);
  const Eigen::Vector2d half_px =
      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt() * (kEllipse95 * exaggeration * frame.px_per_m);
  if (half_px.y() < 0.5) return;
  const Eigen::Vector2d major = eigen.eigenvectors().col(1);
  // SVG turns clockwise as y points down on the screen.
  const double turn_deg = -std::atan2(major.y(), major.x()) * 180 / M_PI;
  const double x = frame.x(beacon.position_m.x()), y = frame.y(beacon.position_m.y());
  svg += fmt::format(
      "<ellipse class='ellipse' cx='{0:.1f}' cy='{1:.1f}' rx='{2:.2f}' ry='{3:.2f}' "
      "transform='rotate({4:.1f} {0:.1f} {1:.1f})'/>\n",
      x, y, half_px.y(), half_px.x(), turn_deg);
}

std::string mark(BeaconStatus status, double x, double y) {
  if (status == BeaconStatus::kControlPoint)
    return fmt::format("<path class='control' d='M{:.1f} {:.1f}l7 12h-14z'/>", x, y - 8);
  return fmt::format("<circle class='beacon' cx='{:.1f}' cy='{:.1f}' r='5'/>", x, y);
}

/// Too many beacons to distinguish: draws their positions only.
template <class Project>
void draw_dots(std::string& svg, const Deployment& deployment, const PlanFrame& frame, Project&& project) {
  std::string path;
  for (const auto& beacon : deployment.beacons) {
    if (!is_drawn(beacon)) continue;
    const Eigen::Vector2d p = project(beacon.position_m);
    path += fmt::format("M{:.1f} {:.1f}h0", frame.x(p.x()), frame.y(p.y()));
  }
  svg += "<path class='dots' d='" + path + "'/>\n";
}

template <class Project>
void draw_beacons(std::string& svg, const Deployment& deployment, const PlanFrame& frame, Project&& project) {
  if (deployment.beacons.size() > kMostNamed) return draw_dots(svg, deployment, frame, project);
  for (const auto& beacon : deployment.beacons) {
    if (!is_drawn(beacon)) continue;
    const Eigen::Vector2d p = project(beacon.position_m);
    const double x = frame.x(p.x()), y = frame.y(p.y());
    // At the right edge, names are to the left of their marks.
    const bool left = x > kPlanWidth_px - 2.2 * kPlanMargin_px;
    svg += mark(beacon.status, x, y) + fmt::format("<text class='name' x='{:.1f}' y='{:.1f}'{}>{}</text>\n",
                                                   left ? x - 9 : x + 9, y - 7,
                                                   left ? " text-anchor='end'" : "", escape_xml(beacon.name));
  }
}

/// Arrows from the earlier to the present position of a beacon, magnified.
void draw_moves(std::string& svg, const PlanInput& input, const PlanFrame& frame) {
  const double scale_px = move_exaggeration(input, frame.extent_m()) * frame.px_per_m;
  for (const PlanMove& move : input.moves) {
    const DeploymentBeacon* beacon = drawn_beacon(input.deployment, move.beacon);
    if (beacon == nullptr) continue;
    const Eigen::Vector2d way_px = Eigen::Vector2d(move.shift_m.x(), -move.shift_m.y()) * scale_px;
    const double length_px = way_px.norm();
    if (!(length_px > 1.0)) continue;
    const Eigen::Vector2d to(frame.x(beacon->position_m.x()), frame.y(beacon->position_m.y()));
    const Eigen::Vector2d from = to - way_px, back = way_px / length_px * std::min(9.0, 0.4 * length_px),
                          aside(-0.5 * back.y(), 0.5 * back.x());
    const Eigen::Vector2d left = to - back + aside, right = to - back - aside;
    svg += fmt::format(
        "<path class='move' d='M{:.1f} {:.1f}L{:.1f} {:.1f}M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}'/>\n",
        from.x(), from.y(), to.x(), to.y(), left.x(), left.y(), to.x(), to.y(), right.x(), right.y());
  }
}

constexpr double kLargestMiss_px = 16.0;

const char* miss_class(const PlanMiss& miss) {
  return miss.late >= miss.early && miss.late >= miss.other ? "miss"
         : miss.early >= miss.other                         ? "miss early"
                                                            : "miss other";
}

/// Lines from the vehicle to the beacons whose arrivals were left out there, and a disc for each such
/// position with an area proportional to their number.
void draw_misses(std::string& svg, const PlanInput& input, const PlanFrame& frame) {
  struct MissPlace {
    Eigen::Vector2d at_m;
    std::size_t count = 0;
  };
  std::vector<MissPlace> places;
  std::size_t most = 1;
  for (const PlanMiss& miss : input.misses) {
    if (const DeploymentBeacon* beacon = drawn_beacon(input.deployment, miss.beacon))
      svg += fmt::format("<path class='{}' d='M{:.1f} {:.1f}L{:.1f} {:.1f}' stroke-width='{:.1f}'/>\n",
                         miss_class(miss), frame.x(miss.at_m.x()), frame.y(miss.at_m.y()),
                         frame.x(beacon->position_m.x()), frame.y(beacon->position_m.y()),
                         std::min(4.0, std::sqrt(static_cast<double>(miss.count()))));
    // Misses at one position are listed together.
    if (places.empty() || places.back().at_m != miss.at_m) places.push_back({miss.at_m});
    places.back().count += miss.count();
    most = std::max(most, places.back().count);
  }
  for (const MissPlace& place : places)
    svg += fmt::format(
        "<circle class='missed' cx='{:.1f}' cy='{:.1f}' r='{:.1f}'><title>{} left out at x {:.2f} m, y "
        "{:.2f} m</title></circle>\n",
        frame.x(place.at_m.x()), frame.y(place.at_m.y()),
        std::max(3.0,
                 kLargestMiss_px * std::sqrt(static_cast<double>(place.count) / static_cast<double>(most))),
        place.count, place.at_m.x(), place.at_m.y());
}

/// The beacon that fails in the map that is shown.
void draw_silent(std::string& svg, const PlanInput& input, const PlanFrame& frame) {
  for (std::size_t k = 0; k < input.maps.size(); ++k) {
    const DeploymentBeacon* beacon = drawn_beacon(input.deployment, input.maps[k].silent_beacon);
    if (beacon == nullptr) continue;
    const double x = frame.x(beacon->position_m.x()), y = frame.y(beacon->position_m.y());
    svg += fmt::format("<path class='silent layer layer-{}' d='M{:.1f} {:.1f}l18 18m0 -18l-18 18'/>\n", k,
                       x - 9, y - 9);
  }
}

/// @return  its height
double draw_legend(std::string& svg, const PlanInput& input, const PlanFrame& frame,
                   const std::string& last_line) {
  double x = kPlanMargin_px, y = frame.height_px + 4;
  const auto entry = [&](const std::string& symbol, const std::string& text) {
    svg += symbol + fmt::format("<text x='{:.1f}' y='{:.1f}'>{}</text>\n", x + 12, y + 4, text);
    x += 34 + 6.4 * static_cast<double>(text.size());
  };
  const auto any = [&](BeaconStatus status) {
    return std::ranges::any_of(input.deployment.beacons, [&](const auto& b) { return b.status == status; });
  };
  const auto tracked = [&](bool moving) {
    return std::ranges::any_of(input.tracks,
                               [&](const auto& t) { return t.moving == moving && !t.points_m.empty(); });
  };
  svg += "<g class='legend'>\n";
  if (any(BeaconStatus::kCalibrated)) entry(mark(BeaconStatus::kCalibrated, x, y), input.beacon_name);
  if (any(BeaconStatus::kControlPoint))
    entry(mark(BeaconStatus::kControlPoint, x, y), "control point, held fixed");
  if (tracked(false))
    entry(fmt::format("<path class='stop' d='M{:.1f} {:.1f}h0'/>", x, y), "station of the calibration");
  if (tracked(true))
    entry(fmt::format("<path class='track' d='M{:.1f} {:.1f}h14'/>", x - 7, y), "drive of the calibration");
  if (!input.fixes_m.empty())
    entry("<path class='fix' d='" + fix_mark(x, y) + "'/>", "fix of the localized run");
  if (!input.misses.empty()) {
    x = kPlanMargin_px;
    y += kLegendRow_px;
    entry(fmt::format("<path class='miss' stroke-width='2' d='M{:.1f} {:.1f}h14'/>", x - 7, y),
          "late (echo)");
    entry(fmt::format("<path class='miss early' stroke-width='2' d='M{:.1f} {:.1f}h14'/>", x - 7, y),
          "early (spurious)");
    entry(fmt::format("<path class='miss other' stroke-width='2' d='M{:.1f} {:.1f}h14'/>", x - 7, y),
          "another reason");
    entry(fmt::format("<circle class='missed' cx='{:.1f}' cy='{:.1f}' r='6'/>", x, y),
          "place, its area by how many");
  }
  if (!last_line.empty())
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}'>{}</text>\n", kPlanMargin_px - 4, y + 4 + kLegendRow_px,
                       last_line);
  svg += "</g>\n";
  return (input.misses.empty() ? 2 : 3) * kLegendRow_px;
}

/// Largest variance of the drawn beacons' positions in the plane; 0 if no variance is known.
double largest_variance_m2(const Deployment& deployment) {
  double largest_m2 = 0.0;
  for (const auto& beacon : deployment.beacons)
    if (is_drawn(beacon))
      largest_m2 = std::max(largest_m2, beacon.covariance_m2.topLeftCorner<2, 2>().trace());
  return largest_m2;
}

/// @param drawing  legend's height is known only when all is drawn
std::string framed(const std::string& label, double height_px, const std::string& drawing) {
  return fmt::format(
      "<svg class='plan' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
      "height='{1:.0f}' role='img' "
      "aria-label='{2}'>\n{3}<rect class='paper' width='100%' height='100%'/>\n{4}</svg>\n",
      kPlanWidth_px, height_px, escape_xml(label), kPlanStyle, drawing);
}

}  // namespace

double ellipse_exaggeration(const Deployment& deployment, double plan_extent_m) {
  const double largest_m2 = largest_variance_m2(deployment);
  if (!(largest_m2 > 0.0) || !std::isfinite(largest_m2) || !(plan_extent_m > 0.0)) return 1.0;
  return std::max(1.0, round_down(0.05 * plan_extent_m / (kEllipse95 * std::sqrt(largest_m2))));
}

double move_exaggeration(const PlanInput& input, double plan_extent_m) {
  constexpr double kLongest = 0.1;
  double longest_m = 0.0;
  for (const PlanMove& move : input.moves) longest_m = std::max(longest_m, move.shift_m.head<2>().norm());
  const double ellipses = ellipse_exaggeration(input.deployment, plan_extent_m);
  if (!(longest_m > 0.0) || !std::isfinite(longest_m) || !(plan_extent_m > 0.0)) return ellipses;
  return std::min(ellipses, std::max(1.0, round_down(kLongest * plan_extent_m / longest_m)));
}

std::string site_plan_svg(const PlanInput& input) {
  const PlanFrame frame = plan_frame(input);
  const double exaggeration = ellipse_exaggeration(input.deployment, frame.extent_m());
  const auto flat = [](const Eigen::Vector3d& p) -> Eigen::Vector2d { return p.head<2>(); };
  std::string svg;
  if (input.deployment.validity_area_m.size() > 2)
    draw_line(svg, "polygon", "area", input.deployment.validity_area_m, frame);
  for (std::size_t k = 0; k < input.maps.size(); ++k)
    svg += map_layer_svg(input.maps[k], k, frame, frame.height_px + 8 + 2 * kLegendRow_px);
  draw_grid(svg, frame, "x, y in metres");
  draw_place(svg, input, frame);
  draw_tracks(svg, input, frame, flat);
  draw_misses(svg, input, frame);
  const bool named = input.deployment.beacons.size() <= kMostNamed;
  for (const auto& beacon : input.deployment.beacons)
    if (named && is_drawn(beacon)) draw_ellipse(svg, beacon, frame, exaggeration);
  draw_beacons(svg, input.deployment, frame, flat);
  draw_moves(svg, input, frame);
  draw_silent(svg, input, frame);
  double height = frame.height_px;
  height += draw_legend(
      svg, input, frame,
      !named ? "Names and error ellipses are left out: there are too many beacons."
      : largest_variance_m2(input.deployment) == 0.0
          ? ""
          : fmt::format(
                "Error ellipses: 95 % (2.45 sigma), drawn {:g} times as large as they are.{}", exaggeration,
                input.moves.empty() ? ""
                                    : fmt::format(" Arrows: moves since the earlier calibration, {:g} times.",
                                                  move_exaggeration(input, frame.extent_m()))));
  if (!input.maps.empty()) height += kLegendRow_px;
  const std::string of_map = input.maps.size() == 1 ? ": " + input.maps.front().name : "";
  return framed("Plan of " + input.deployment.site + of_map, height, svg);
}

std::string elevation_svg(const PlanInput& input) {
  // The side view shows the longer side of the site.
  const PlanFrame plan = plan_frame(input);
  const Eigen::Vector2d size = plan.high_m - plan.low_m;
  const int along = size.y() > size.x() ? 1 : 0;
  const auto side = [along](const Eigen::Vector3d& p) { return Eigen::Vector2d(p[along], p.z()); };
  PlanInput turned;
  for (const auto& beacon : input.deployment.beacons) {
    if (!is_drawn(beacon)) continue;
    turned.deployment.beacons.push_back(beacon);
    turned.deployment.beacons.back().position_m = {beacon.position_m[along], beacon.position_m.z(), 0.0};
  }
  for (const auto& track : input.tracks) {
    turned.tracks.push_back({track.moving, thinned(track.points_m)});
    for (auto& p : turned.tracks.back().points_m) p = {p[along], p.z(), 0.0};
  }
  for (const auto& p : thinned(input.fixes_m)) turned.fixes_m.emplace_back(p[along], p.z(), 0.0);
  const PlanFrame frame = plan_frame(turned);
  std::string svg;
  draw_grid(svg, frame, along == 0 ? "x, z in metres" : "y, z in metres");
  draw_tracks(svg, input, frame, side);
  draw_beacons(svg, input.deployment, frame, side);
  const double legend = draw_legend(svg, input, frame, "Heights at the scale of the lengths.");
  return framed("Side view of " + input.deployment.site, frame.height_px + legend, svg);
}

}  // namespace octant::survey

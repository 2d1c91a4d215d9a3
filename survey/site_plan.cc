// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/site_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

namespace octant::survey {
namespace {

constexpr double kWidth_px = 900.0, kMargin_px = 46.0, kLegend_px = 54.0;
constexpr std::size_t kMaxMarks = 2000;  // a drive has many thousands of states; a plan of 900 pixels does not show more

// Colours are spelled out twice, as few programs but browsers know CSS variables.
constexpr const char* kStyle = R"(<style>
.plan text{font:12px system-ui,sans-serif;fill:#1b2733}.plan .name{font-weight:600}.plan .paper{fill:#fff}.plan .grid{stroke:#d9dfe5}
.plan .area{fill:#eef5ee}.plan .track{fill:none;stroke:#8a97a3}.plan .stop{fill:#8a97a3}.plan .fix{fill:none;stroke:#c2571a}
.plan .beacon{fill:#1660a8}.plan .control{fill:#1d7a3c}.plan .ellipse{fill:#1660a8;fill-opacity:.15;stroke:#1660a8}
@media(prefers-color-scheme:dark){.plan text{fill:#dfe6ec}.plan .paper{fill:#12181e}.plan .grid{stroke:#2b353f}.plan .area{fill:#18251d}
.plan .track{stroke:#6f7d8a}.plan .stop{fill:#6f7d8a}.plan .fix{stroke:#f0945a}.plan .beacon{fill:#6db3f2}.plan .control{fill:#67c587}
.plan .ellipse{fill:#6db3f2;stroke:#6db3f2}}
</style>
)";

bool drawn(const DeploymentBeacon& beacon) {
  return beacon.status != BeaconStatus::kUndetermined && beacon.position_m.allFinite();
}

/// 1, 2 or 5 times a power of ten, not above x.
double round_down(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  const double lead = x / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

/// Map metres to pixels, y up.
struct Frame {
  Eigen::Vector2d low_m{0, 0}, high_m{1, 1};
  double px_per_m = 1.0, height_px = 0.0;
  [[nodiscard]] double x(double x_m) const { return kMargin_px + (x_m - low_m.x()) * px_per_m; }
  [[nodiscard]] double y(double y_m) const { return kMargin_px + (high_m.y() - y_m) * px_per_m; }
};

Frame make_frame(const PlanInput& input) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& beacon : input.deployment.beacons)
    if (drawn(beacon)) points.emplace_back(beacon.position_m.head<2>());
  for (const auto& track : input.tracks) points.insert(points.end(), track.points_m.begin(), track.points_m.end());
  for (const auto& fix : input.fixes)
    if (fix.ok()) points.emplace_back(fix.T_map_vehicle.translation_m.head<2>());
  Frame frame;
  if (!points.empty()) frame.low_m = frame.high_m = points.front();
  for (const auto& p : points) {
    frame.low_m = frame.low_m.cwiseMin(p);
    frame.high_m = frame.high_m.cwiseMax(p);
  }
  // Room around it, and a shape that neither a corridor nor a mast makes absurd.
  const Eigen::Vector2d middle = (frame.low_m + frame.high_m) / 2;
  Eigen::Vector2d size = (frame.high_m - frame.low_m) * 1.12;
  size = size.cwiseMax(Eigen::Vector2d::Constant(std::max(1.0e-3, 0.3 * size.maxCoeff())));
  if (size.y() > size.x()) size.x() = size.y();
  frame.low_m = middle - size / 2;
  frame.high_m = middle + size / 2;
  frame.px_per_m = (kWidth_px - 2 * kMargin_px) / size.x();
  frame.height_px = 2 * kMargin_px + size.y() * frame.px_per_m;
  return frame;
}

void draw_grid(std::string& svg, const Frame& frame) {
  const double step_m = round_down((frame.high_m - frame.low_m).maxCoeff() / 6);
  const double right = frame.x(frame.high_m.x()), bottom = frame.y(frame.low_m.y()), left = frame.x(frame.low_m.x()), top = frame.y(frame.high_m.y());
  // Counted, not added up: a sum would drift and print 0.30000000000000004.
  for (double k = std::ceil(frame.low_m.x() / step_m); k * step_m <= frame.high_m.x(); ++k) {
    const double x = frame.x(k * step_m);
    svg += fmt::format("<line class='grid' x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}'/>"
                       "<text x='{0:.1f}' y='{3:.1f}' text-anchor='middle'>{4:.6g}</text>\n", x, top, bottom, bottom + 16, k * step_m + 0.0);
  }
  for (double k = std::ceil(frame.low_m.y() / step_m); k * step_m <= frame.high_m.y(); ++k) {
    const double y = frame.y(k * step_m);
    svg += fmt::format("<line class='grid' x1='{1:.1f}' y1='{0:.1f}' x2='{2:.1f}' y2='{0:.1f}'/>"
                       "<text x='{3:.1f}' y='{4:.1f}' text-anchor='end'>{5:.6g}</text>\n", y, left, right, left - 6, y + 4, k * step_m + 0.0);  // + 0.0: no "-0"
  }
  svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>x, y in metres</text>\n", right, top - 10);
}

void draw_tracks(std::string& svg, const PlanInput& input, const Frame& frame) {
  const auto& area = input.deployment.validity_area_m;
  if (area.size() > 2) {
    svg += "<polygon class='area' points='";
    for (const auto& p : area) svg += fmt::format("{:.1f},{:.1f} ", frame.x(p.x()), frame.y(p.y()));
    svg += "'/>\n";
  }
  for (const auto& track : input.tracks) {
    const std::size_t stride = track.points_m.size() / kMaxMarks + 1;
    if (track.moving) svg += "<polyline class='track' points='";
    for (std::size_t i = 0; i < track.points_m.size(); i += stride) {
      const double x = frame.x(track.points_m[i].x()), y = frame.y(track.points_m[i].y());
      svg += track.moving ? fmt::format("{:.1f},{:.1f} ", x, y) : fmt::format("<circle class='stop' cx='{:.1f}' cy='{:.1f}' r='2'/>\n", x, y);
    }
    if (track.moving) svg += "'/>\n";
  }
  const std::size_t stride = input.fixes.size() / kMaxMarks + 1;
  for (std::size_t i = 0; i < input.fixes.size(); i += stride) {
    if (!input.fixes[i].ok()) continue;
    const Eigen::Vector3d& p = input.fixes[i].T_map_vehicle.translation_m;
    svg += fmt::format("<circle class='fix' cx='{:.1f}' cy='{:.1f}' r='3'/>\n", frame.x(p.x()), frame.y(p.y()));
  }
}

void draw_ellipse(std::string& svg, const DeploymentBeacon& beacon, const Frame& frame, double exaggeration) {
  const Eigen::Matrix2d C = beacon.covariance_m2.topLeftCorner<2, 2>();
  if (!C.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(C);
  const Eigen::Vector2d half_px = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt() * (kEllipse95 * exaggeration * frame.px_per_m);
  if (half_px.y() < 0.5) return;
  const Eigen::Vector2d major = eigen.eigenvectors().col(1);
  // SVG turns clockwise as y points down on the screen.
  const double turn_deg = -std::atan2(major.y(), major.x()) * 180 / M_PI;
  const double x = frame.x(beacon.position_m.x()), y = frame.y(beacon.position_m.y());
  svg += fmt::format("<ellipse class='ellipse' cx='{0:.1f}' cy='{1:.1f}' rx='{2:.2f}' ry='{3:.2f}' transform='rotate({4:.1f} {0:.1f} {1:.1f})'/>\n",
                     x, y, half_px.y(), half_px.x(), turn_deg);
}

std::string mark(const char* what, double x, double y) {
  if (std::string_view(what) == "control")
    return fmt::format("<path class='control' d='M{:.1f} {:.1f}l6.5 11h-13z'/>", x, y - 7);
  return fmt::format("<circle class='beacon' cx='{:.1f}' cy='{:.1f}' r='4.5'/>", x, y);
}

void draw_beacons(std::string& svg, const Deployment& deployment, const Frame& frame, double exaggeration) {
  for (const auto& beacon : deployment.beacons)
    if (drawn(beacon)) draw_ellipse(svg, beacon, frame, exaggeration);
  for (const auto& beacon : deployment.beacons) {
    if (!drawn(beacon)) continue;
    const double x = frame.x(beacon.position_m.x()), y = frame.y(beacon.position_m.y());
    svg += mark(beacon.status == BeaconStatus::kControlPoint ? "control" : "beacon", x, y);
    svg += fmt::format("<text class='name' x='{:.1f}' y='{:.1f}'>{}</text>\n", x + 9, y - 7, escape_xml(beacon.name));
  }
}

void draw_legend(std::string& svg, const PlanInput& input, const Frame& frame, double exaggeration) {
  const double y = frame.height_px + 4;
  double x = kMargin_px;
  const auto entry = [&](const std::string& symbol, const std::string& text) {
    svg += symbol + fmt::format("<text x='{:.1f}' y='{:.1f}'>{}</text>\n", x + 12, y + 4, text);
    x += 34 + 6.4 * static_cast<double>(text.size());
  };
  const auto any = [&](BeaconStatus status) {
    return std::any_of(input.deployment.beacons.begin(), input.deployment.beacons.end(), [&](const auto& b) { return b.status == status; });
  };
  if (any(BeaconStatus::kCalibrated)) entry(mark("beacon", x, y), "calibrated beacon");
  if (any(BeaconStatus::kControlPoint)) entry(mark("control", x, y), "control point, held fixed");
  if (!input.tracks.empty()) entry(fmt::format("<circle class='stop' cx='{:.1f}' cy='{:.1f}' r='2.5'/>", x, y), "vehicle during calibration");
  if (!input.fixes.empty()) entry(fmt::format("<circle class='fix' cx='{:.1f}' cy='{:.1f}' r='3'/>", x, y), "fix of the localized run");
  svg += fmt::format("<text x='{:.1f}' y='{:.1f}'>Error ellipses: 95 %, drawn {:g} times as large as they are.</text>\n", kMargin_px - 4, y + 30,
                     exaggeration);
}

}  // namespace

std::string escape_xml(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default:
        // Control characters are not allowed in XML at all, not even escaped.
        safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return safe;
}

double ellipse_exaggeration(const Deployment& deployment, double plan_extent_m) {
  double largest_m2 = 0.0;
  for (const auto& beacon : deployment.beacons)
    if (drawn(beacon)) largest_m2 = std::max(largest_m2, beacon.covariance_m2.topLeftCorner<2, 2>().trace());
  if (!(largest_m2 > 0.0) || !std::isfinite(largest_m2) || !(plan_extent_m > 0.0)) return 1.0;
  return std::max(1.0, round_down(0.05 * plan_extent_m / (kEllipse95 * std::sqrt(largest_m2))));
}

std::string site_plan_svg(const PlanInput& input) {
  const Frame frame = make_frame(input);
  const double exaggeration = ellipse_exaggeration(input.deployment, (frame.high_m - frame.low_m).maxCoeff());
  std::string svg = fmt::format("<svg class='plan' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
                                "height='{1:.0f}' role='img' aria-label='Plan of {2}'>\n",
                                kWidth_px, frame.height_px + kLegend_px, escape_xml(input.deployment.site));
  svg += kStyle;
  svg += "<rect class='paper' width='100%' height='100%'/>\n";
  draw_grid(svg, frame);
  draw_tracks(svg, input, frame);
  draw_beacons(svg, input.deployment, frame, exaggeration);
  draw_legend(svg, input, frame, exaggeration);
  return svg + "</svg>\n";
}

}  // namespace octant::survey

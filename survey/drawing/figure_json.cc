// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/figure_json.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "models/support/decompositions.h"
#include "survey/drawing/escape.h"
#include "survey/drawing/palette.h"
#include "survey/drawing/plan_frame.h"
#include "survey/drawing/site_plan.h"
#include "survey/drawing/svg_chart.h"
#include "survey/geometry/quantity.h"

namespace octant::survey {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kEllipsoid95 = 2.7955;  // square root of chi-square's 0.95 quantile, 3 degrees of freedom
constexpr int kCircle = 28;              // points of one
constexpr std::size_t kMostLineNames =
    40;  // of more walls or routes the names would hide the map; the pointer still tells them

/// plotly.js interprets labels as a subset of HTML that supports few entities.
std::string label(const std::string& text) { return escape_markup(text); }

/// Rounded to a hundred thousandth of the figure's size: more digits only make the page longer.
double rounded(double value, double size) {
  const double step = std::pow(10.0, std::floor(std::log10(std::max(size, 1e-12))) - 5);
  const double digits = std::round(1 / step);
  return step >= 1 ? std::round(value) : std::round(value * digits) / digits;
}

std::string finished(const Json& data, const Json& layout) {
  const Json figure = {{"data", data}, {"layout", layout}};
  return escape_script_json(figure.dump(-1, ' ', true, Json::error_handler_t::replace));
}

Json axis(const std::string& title) { return {{"title", {{"text", title}}}, {"zeroline", false}}; }

Json line_trace(const char* name, const char* colour, const char* dash) {
  return {{"type", "scatter"},  {"mode", "lines"},
          {"name", name},       {"line", {{"color", colour}, {"dash", dash}, {"width", 1.5}}},
          {"x", Json::array()}, {"y", Json::array()}};
}

Json marker_trace(const std::string& name, const char* colour, const char* symbol, double size) {
  return {{"type", "scatter"},  {"mode", "markers"},
          {"name", name},       {"marker", {{"color", colour}, {"symbol", symbol}, {"size", size}}},
          {"x", Json::array()}, {"y", Json::array()}};
}

void put(Json& trace, const Eigen::Vector3d& p, double size, bool space) {
  trace["x"].push_back(rounded(p.x(), size));
  trace["y"].push_back(rounded(p.y(), size));
  if (space) trace["z"].push_back(rounded(p.z(), size));
}

void put_gap(Json& trace, bool space) {
  for (const char* axis_name : {"x", "y", "z"})
    if (space || *axis_name != 'z') trace[axis_name].push_back(nullptr);
}

/// The classes of map_classes() as plotly's scale from 0 to a class beyond the last limit.
Json tolerance_scale() {
  const double end = kToleranceParts.back() + kToleranceParts.front();
  Json scale = Json::array();
  for (std::size_t k = 0; k < kToleranceColours.size(); ++k) {
    const double from = k == 0 ? 0.0 : kToleranceParts[k - 1] / end;
    const double to = k == kToleranceParts.size() ? 1.0 : kToleranceParts[k] / end;
    scale.push_back({from, kToleranceColours[k]});
    scale.push_back({to, kToleranceColours[k]});
  }
  return scale;
}

Json map_trace(const NamedMap& map, std::size_t layer) {
  Json rows = Json::array();
  for (std::size_t first = 0; map.columns > 0 && first + map.columns <= map.values.size();
       first += map.columns) {
    Json row = Json::array();
    for (std::size_t i = first; i < first + map.columns; ++i)
      row.push_back(std::isfinite(map.values[i]) ? Json(rounded(map.values[i], std::abs(map.values[i]) * 100))
                                                 : Json(nullptr));
    rows.push_back(std::move(row));
  }
  const std::vector<double> limits = map_classes(map);
  Json trace = {
      {"type", "heatmap"},
      {"name", label(map.name)},
      {"layer", layer},
      {"visible", layer == 0},
      {"colorscale", "Cividis"},
      {"opacity", 0.85},
      {"x0", map.corner_m.x() + map.cell_m / 2},
      {"dx", map.cell_m},
      {"y0", map.corner_m.y() + map.cell_m / 2},
      {"dy", map.cell_m},
      {"z", rows},
      {"hovertemplate", "%{z:.3g}" + (map.unit.empty() ? "" : " " + label(map.unit)) +
                            "<br>x %{x:.2f} m, y %{y:.2f} m<extra></extra>"},
      {"colorbar",
       {{"title",
         {{"text", label(map.tolerance      ? fmt::format("{}, tolerance {:.3g}", map.unit, *map.tolerance)
                         : map.unit.empty() ? map.name
                                            : map.unit)},
          {"side", "right"}}},
        {"thickness", 14}}}};
  if (map.tolerance) {
    trace["zmin"] = 0.0;
    trace["zmax"] = limits.back() + limits.front();
    trace["colorscale"] = tolerance_scale();
  } else if (!limits.empty()) {
    // The last class has no end.
    trace["zmin"] = 2 * limits[0] - limits[1];
    trace["zmax"] = 2 * limits.back() - limits[limits.size() - 2];
  }
  return trace;
}

/// Beacons of a status, with their details when the reader points at them.
Json beacon_trace(const Deployment& d, BeaconStatus status, const std::string& name, double size,
                  bool space) {
  const bool control = status == BeaconStatus::kControlPoint;
  Json trace = marker_trace(name, control ? "var(--control)" : "var(--beacon)",
                            space ? (control ? "diamond" : "circle") : (control ? "triangle-up" : "circle"),
                            space ? 6 : 11);
  trace["mode"] = space ? "markers" : "markers+text";
  trace["textposition"] = "top center";
  if (space) trace["type"] = "scatter3d";
  trace["hovertemplate"] = "%{hovertext}<extra></extra>";
  const bool named = d.beacons.size() <= kMostNamed;
  if (!named) {
    trace["mode"] = "markers";
    trace["marker"]["size"] = space ? 3 : 5;
    trace["hovertemplate"] = "%{hovertext}<br>x %{x} m, y %{y} m<extra></extra>";
  }
  for (const auto& b : d.beacons) {
    if (b.status != status || !is_drawn(b)) continue;
    put(trace, b.position_m, size, space);
    if (!named) {
      trace["hovertext"].push_back(label(b.name));
      continue;
    }
    const Eigen::Vector3d U = 2 * b.covariance_m2.diagonal().cwiseMax(0.0).cwiseSqrt();
    if (!space) trace["text"].push_back(label(b.name));
    trace["hovertext"].push_back(
        fmt::format("{}<br>x {:.4f}, y {:.4f}, z {:.4f} m<br>U (k = 2) {}, {}, {}<br>delay {}", label(b.name),
                    b.position_m.x(), b.position_m.y(), b.position_m.z(), length_text(U.x()),
                    length_text(U.y()), length_text(U.z()), time_symbol_text(b.delay_s)));
  }
  return trace;
}

/// Ellipses of the plan, or three great circles of each ellipsoid.
Json ellipse_trace(const Deployment& d, double exaggeration, double size, bool space) {
  Json trace = line_trace(space ? "95 % ellipsoid" : "95 % ellipse", "var(--beacon)", "solid");
  trace["name"] =
      fmt::format("95 % {}, drawn {:g} times as large", space ? "ellipsoid" : "ellipse", exaggeration);
  trace["hoverinfo"] = "skip";
  if (space) trace["type"] = "scatter3d";
  if (d.beacons.size() > kMostNamed) return trace;
  for (const auto& b : d.beacons) {
    if (b.status != BeaconStatus::kCalibrated || !is_drawn(b) || !b.covariance_m2.allFinite() ||
        b.covariance_m2.isZero(0.0))
      continue;
    const Eigen::Matrix3d C = space ? b.covariance_m2 : [&b] {
      Eigen::Matrix3d flat = Eigen::Matrix3d::Zero();
      flat.topLeftCorner<2, 2>() = b.covariance_m2.topLeftCorner<2, 2>();
      return flat;
    }();
    const SymmetricEigen<Eigen::Matrix3d> eigen(C);
    const Eigen::Matrix3d axes = eigen.eigenvectors() * (eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt() *
                                                         exaggeration * (space ? kEllipsoid95 : kEllipse95))
                                                            .asDiagonal();
    // Eigenvalues ascend, so the flat one's plane is that of the last two.
    for (int normal = 0; normal < (space ? 3 : 1); ++normal) {
      for (int k = 0; k <= kCircle; ++k) {
        const double turn = 2 * M_PI * k / kCircle;
        put(trace,
            b.position_m + axes.col((normal + 1) % 3) * std::cos(turn) +
                axes.col((normal + 2) % 3) * std::sin(turn),
            size, space);
      }
      put_gap(trace, space);
    }
  }
  return trace;
}

void add_tracks(Json& data, const PlanInput& input, double size, bool space) {
  for (const bool moving : {false, true}) {
    Json trace = moving ? line_trace("drive of the calibration", "var(--track)", "solid")
                        : marker_trace("station of the calibration", "var(--track)", "circle", space ? 2 : 4);
    if (space) trace["type"] = "scatter3d";
    trace["hoverinfo"] = "skip";
    for (const auto& track : input.tracks) {
      if (track.moving != moving) continue;
      for (const auto& p : thinned(track.points_m)) put(trace, p, size, space);
      if (moving) put_gap(trace, space);
    }
    if (!trace["x"].empty()) data.push_back(std::move(trace));
  }
  Json fixes = marker_trace("fix of the localized run", "var(--fix)", "diamond-open", space ? 3 : 7);
  if (space) fixes["type"] = "scatter3d";
  for (const auto& p : thinned(input.fixes_m)) put(fixes, p, size, space);
  if (!fixes["x"].empty()) data.push_back(std::move(fixes));
}

void add_beacon_traces(Json& data, const Deployment& d, double exaggeration, double size, bool space,
                       const std::string& name = "calibrated beacon") {
  for (auto trace : {ellipse_trace(d, exaggeration, size, space),
                     beacon_trace(d, BeaconStatus::kCalibrated, name, size, space),
                     beacon_trace(d, BeaconStatus::kControlPoint, "control point", size, space)})
    if (!trace["x"].empty()) data.push_back(std::move(trace));
}

/// All lines of a kind in one trace, separated by gaps. Each line shows its name at its corners; the first
/// one also as a label.
Json lines_trace(const std::vector<NamedLine>& lines, const char* kind, const char* dash, double size) {
  Json trace = line_trace(kind, "var(--ink)", dash);
  const bool named = lines.size() <= kMostLineNames;
  if (named) trace.update({{"mode", "lines+text"}, {"textposition", "top right"}, {"text", Json::array()}});
  trace["hovertext"] = Json::array();
  trace["hovertemplate"] = "%{hovertext}<br>x %{x} m, y %{y} m<extra></extra>";
  const auto tell = [&](const std::string& text, const std::string& hover) {
    if (named) trace["text"].push_back(text);
    trace["hovertext"].push_back(hover);
  };
  for (const NamedLine& line : lines) {
    const std::size_t n = line.points_m.size(), corners = n + (line.closed && n > 0 ? 1 : 0);
    const std::string name = label(line.name), hover = name.empty() ? kind : kind + (" " + name);
    for (std::size_t i = 0; i < corners; ++i) {
      const Eigen::Vector2d& p = line.points_m[i % n];
      put(trace, {p.x(), p.y(), 0}, size, false);
      tell(i == 0 ? name : "", hover);
    }
    put_gap(trace, false);
    tell("", "");
  }
  return trace;
}

/// Shifts as on the plan: from the earlier position of the beacon, with the same magnification.
std::vector<NamedLine> move_lines(const PlanInput& plan, double size) {
  std::vector<NamedLine> lines;
  const double factor = move_exaggeration(plan, size);
  for (const PlanMove& move : plan.moves)
    if (const DeploymentBeacon* b = drawn_beacon(plan.deployment, move.beacon)) {
      const Eigen::Vector2d to = b->position_m.head<2>();
      lines.push_back(
          {fmt::format("of {}, {:g} times", b->name, factor), {to - factor * move.shift_m.head<2>(), to}});
    }
  return lines;
}

}  // namespace

std::string plan_figure_json(const PlanInput& input) {
  const PlanFrame frame = plan_frame(input);
  const double size = frame.extent_m();
  Json data = Json::array();
  for (std::size_t k = 0; k < input.maps.size(); ++k) data.push_back(map_trace(input.maps[k], k));
  if (input.deployment.validity_area_m.size() > 2) {
    Json area = line_trace(input.area_name.c_str(), "var(--control)", "dash");
    area["hoverinfo"] = "skip";
    for (const auto& p : input.deployment.validity_area_m) put(area, {p.x(), p.y(), 0}, size, false);
    put(area, {input.deployment.validity_area_m[0].x(), input.deployment.validity_area_m[0].y(), 0}, size,
        false);
    data.push_back(std::move(area));
  }
  if (!input.walls.empty()) data.push_back(lines_trace(input.walls, "wall", "solid", size));
  if (!input.routes.empty()) data.push_back(lines_trace(input.routes, "route", "dash", size));
  if (const auto moves = move_lines(input, size); !moves.empty())
    data.push_back(lines_trace(moves, "move", "solid", size));
  add_tracks(data, input, size, false);
  add_beacon_traces(data, input.deployment, ellipse_exaggeration(input.deployment, size), size, false,
                    input.beacon_name);
  for (std::size_t k = 0; k < input.maps.size(); ++k) {
    const DeploymentBeacon* silent = drawn_beacon(input.deployment, input.maps[k].silent_beacon);
    if (silent == nullptr) continue;
    Json cross = marker_trace("silent", "var(--bad)", "x-thin-open", 18);
    cross.update({{"layer", k}, {"visible", k == 0}, {"showlegend", false}});
    put(cross, silent->position_m, size, false);
    data.push_back(std::move(cross));
  }
  Json y = axis("y [m]");
  y.update({{"scaleanchor", "x"}, {"scaleratio", 1}});
  return finished(data, {{"xaxis", axis("x [m]")},
                         {"yaxis", y},
                         {"height", 620},
                         {"legend", {{"orientation", "h"}, {"y", -0.14}}}});
}

std::string space_figure_json(const PlanInput& input) {
  const double size = plan_frame(input).extent_m();
  Json data = Json::array(), names = Json::array();
  add_tracks(data, input, size, true);
  add_beacon_traces(data, input.deployment, ellipse_exaggeration(input.deployment, size), size, true);
  for (const auto& b : input.deployment.beacons) {
    if (!is_drawn(b) || input.deployment.beacons.size() > kMostNamed) continue;
    names.push_back({{"x", b.position_m.x()},
                     {"y", b.position_m.y()},
                     {"z", b.position_m.z()},
                     {"text", label(b.name)},
                     {"showarrow", false},
                     {"yshift", 14}});
  }
  return finished(data, {{"scene",
                          {{"xaxis", axis("x [m]")},
                           {"yaxis", axis("y [m]")},
                           {"zaxis", axis("z [m]")},
                           {"aspectmode", "data"},
                           {"annotations", names},
                           {"camera", {{"eye", {{"x", 0.5}, {"y", -1.9}, {"z", 1.3}}}}}}},
                         {"height", 560},
                         {"legend", {{"orientation", "h"}}}});
}

std::string residual_chart_json(const ResidualChart& chart) {
  const Unit time = chart.time();
  const bool names = chart.unit.empty();
  Json trace = marker_trace("mean, plus and minus the RMS", "var(--fix)", "circle", 9);
  Json error = Json::array(), wide = Json::array(), text = Json::array();
  for (const auto& bin : chart.bins) {
    trace["x"].push_back(names ? Json(label(bin.name)) : Json((bin.from + bin.to) / 2));
    trace["y"].push_back(0.0);
    trace["y"].back() = rounded(time.per_si * bin.mean_s, 100);
    error.push_back(rounded(time.per_si * bin.rms_s, 100));
    wide.push_back((bin.to - bin.from) / 2);
    text.push_back(fmt::format(
        "{}<br>{} arrivals<br>mean {:.2f} {}, RMS {:.2f} {}",
        names ? label(bin.name) : fmt::format("{:.4g} to {:.4g} {}", bin.from, bin.to, chart.unit), bin.count,
        time.per_si * bin.mean_s, time.symbol, time.per_si * bin.rms_s, time.symbol));
  }
  trace["error_y"] = {{"type", "data"}, {"array", error}, {"color", "var(--beacon)"}};
  if (!names)
    trace["error_x"] = {{"type", "data"}, {"array", wide}, {"color", "var(--beacon)"}, {"width", 0}};
  trace["hovertext"] = text;
  trace["hovertemplate"] = "%{hovertext}<extra></extra>";
  Json x = axis(names ? chart.by : fmt::format("{} [{}]", chart.by, chart.unit)),
       y = axis(fmt::format("residual [{}]", time.symbol));
  if (names) x["type"] = "category";
  y["zeroline"] = true;
  return finished(Json::array({trace}), {{"xaxis", x},
                                         {"yaxis", y},
                                         {"height", 340},
                                         {"showlegend", true},
                                         {"legend", {{"orientation", "h"}, {"y", 1.15}}}});
}

std::string histogram_json(const Histogram& histogram) {
  Json bars = {{"type", "bar"},      {"name", "counted"},  {"marker", {{"color", "var(--beacon)"}}},
               {"x", Json::array()}, {"y", Json::array()}, {"width", histogram.width}};
  Json curve = line_trace("standard normal", "var(--fix)", "dash");
  const auto expected = normal_counts(histogram);
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double middle = rounded(histogram.from + histogram.width * (static_cast<double>(i) + 0.5), 1);
    bars["x"].push_back(middle);
    bars["y"].push_back(histogram.counts[i]);
    curve["x"].push_back(middle);
    curve["y"].push_back(rounded(expected[i], 1000));
  }
  return finished(Json::array({bars, curve}), {{"xaxis", axis("residual over its sigma")},
                                               {"yaxis", axis("arrivals in a bin")},
                                               {"height", 340},
                                               {"bargap", 0.05},
                                               {"legend", {{"orientation", "h"}, {"y", 1.15}}}});
}

std::string error_curve_json(const std::vector<double>& quantiles_m, const std::optional<double>& limit_m) {
  if (quantiles_m.empty()) return {};
  const Unit length = length_unit(std::max(quantiles_m.back(), limit_m.value_or(0.0)));
  Json curve = line_trace("fixes of the held-out run", "var(--beacon)", "solid");
  for (std::size_t i = 0; i < quantiles_m.size(); ++i) {
    curve["x"].push_back(rounded(length.per_si * quantiles_m[i], 100));
    curve["y"].push_back(rounded(100.0 * static_cast<double>(i) /
                                     static_cast<double>(std::max<std::size_t>(1, quantiles_m.size() - 1)),
                                 100));
  }
  Json data = Json::array({curve});
  if (limit_m) {
    Json limit = line_trace("tolerance (of the RMSE)", "var(--fix)", "dash");
    limit["x"] = {length.per_si * *limit_m, length.per_si * *limit_m};
    limit["y"] = {0, 100};
    data.push_back(std::move(limit));
  }
  return finished(data, {{"xaxis", axis(fmt::format("position error below [{}]", length.symbol))},
                         {"yaxis", axis("share of the fixes [%]")},
                         {"height", 340},
                         {"legend", {{"orientation", "h"}, {"y", 1.15}}}});
}

}  // namespace octant::survey

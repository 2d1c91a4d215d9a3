// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/proof_sheet.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "models/physics/polygon.h"
#include "survey/drawing/escape.h"
#include "survey/geometry/quantity.h"
#include "survey/page/report_html.h"

namespace octant::survey {
namespace {

struct ProofLine {
  const char* name;
  LayoutFigures ProofRow::*figures;
  const char* colour;
  const char* dash;
};
// Colours of Okabe and Ito, distinguishable with colour blindness; the dashes are distinguishable without
// colour.
constexpr ProofLine kLines[] = {{"plan", &ProofRow::plan, "#0072b2", ""},
                                {"greedy", &ProofRow::greedy, "#009e73", "6 3"},
                                {"regular", &ProofRow::regular, "#d55e00", "2 3"},
                                {"random (median)", &ProofRow::random, "#999999", "8 3 2 3"}};

constexpr double kProofLeft = 70, kProofTop = 20, kWide = 520, kHigh = 300;

/// Converts numbers of beacons and errors to positions on the chart.
class Chart {
 public:
  explicit Chart(const std::vector<ProofRow>& rows) {
    for (const ProofRow& row : rows) {
      first_ = std::min(first_, static_cast<double>(row.beacons)),
      last_ = std::max(last_, static_cast<double>(row.beacons));
      for (const ProofLine& line : kLines)
        if (const LayoutFigures& f = row.*line.figures; f.covers_all())
          low_ = std::min(low_, f.objective_m), high_ = std::max(high_, f.objective_m);
    }
    if (!(high_ > 0)) low_ = 1e-2, high_ = 1.0;
    low_ = std::pow(10.0, std::floor(std::log10(low_))),
    high_ = std::pow(10.0, std::ceil(std::log10(high_) + 1e-9));
  }
  [[nodiscard]] double x(double beacons) const {
    return kProofLeft + (last_ > first_ ? (beacons - first_) / (last_ - first_) : 0.5) * kWide;
  }
  [[nodiscard]] double y(double error_m) const {
    return kProofTop + kHigh * (1 - std::log10(error_m / low_) / std::log10(high_ / low_));
  }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }

 private:
  double first_ = 1e9, last_ = 0.0, low_ = 1e9, high_ = 0.0;
};

std::string line_svg(const ProofLine& line, const std::vector<ProofRow>& rows, const Chart& chart) {
  std::string points, dots;
  for (const ProofRow& row : rows) {
    const LayoutFigures& f = row.*line.figures;
    if (!f.covers_all()) continue;
    const double x = chart.x(static_cast<double>(row.beacons)), y = chart.y(f.objective_m);
    points += fmt::format("{:.1f},{:.1f} ", x, y);
    dots += fmt::format(
        "<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'><title>{}, {} beacons: {}</title></circle>", x, y,
        line.colour, line.name, row.beacons, figure_text(f.objective_m, "m"));
  }
  return fmt::format(
      "<polyline points='{}' fill='none' stroke='{}' stroke-width='2' stroke-dasharray='{}'/>{}\n", points,
      line.colour, line.dash, dots);
}

std::string cell(const LayoutFigures& f) {
  return f.covers_all() ? figure_text(f.objective_m, "m")
                        : fmt::format("{:.1f} % covered", 100 * f.covered_fraction);
}

ReportTable rows_table(const ProofSheetInput& input) {
  ReportTable table{"proof-table",
                    "The goal by the number of beacons",
                    {{"beacons"}, {"plan"}, {"greedy"}, {"regular"}, {"random"}, {"against regular"}}};
  for (const ProofRow& row : input.rows) {
    const bool both = row.plan.covers_all() && row.regular.covers_all();
    table.rows.push_back(
        {{std::to_string(row.beacons)},
         {cell(row.plan)},
         {cell(row.greedy)},
         {cell(row.regular)},
         {cell(row.random)},
         {both ? fmt::format("{:+.0f} %", 100 * (row.plan.objective_m / row.regular.objective_m - 1))
               : "-"}});
  }
  return table;
}

ReportTable beacons_table(const Placement& placement) {
  ReportTable table{"beacons-table",
                    "Where the beacons are to hang",
                    {{"beacon", true}, {"x [m]"}, {"y [m]"}, {"z [m]"}, {"mount", true}}};
  for (const PlacedBeacon& b : placement.beacons) {
    std::vector<ReportText>& row = table.rows.emplace_back();
    row.push_back({b.beacon.name});
    for (const double coordinate_m : b.beacon.p_map_m) row.push_back({fmt::format("{:.2f}", coordinate_m)});
    row.push_back({b.mount.empty() ? "kept" : b.mount});
  }
  return table;
}

}  // namespace

std::string proof_svg(const ProofSheetInput& input) {
  const Chart chart(input.rows);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {} {}' width='{}' font-family='sans-serif' "
      "font-size='12' fill='currentColor'>\n",
      kProofLeft + kWide + 150, kProofTop + kHigh + 50, kProofLeft + kWide + 150);
  for (double decade = chart.low(); decade < chart.high() * 1.001; decade *= 10)
    for (const double mark : {1.0, 2.0, 5.0}) {
      const double error = mark * decade;
      if (error > chart.high() * 1.001) continue;
      svg += fmt::format(
          "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#8884'/><text x='{3}' y='{4:.1f}' "
          "text-anchor='end'>{5}</text>\n",
          kProofLeft, kProofLeft + kWide, chart.y(error), kProofLeft - 6, chart.y(error) + 4,
          figure_text(error, "m"));
    }
  for (const ProofRow& row : input.rows)
    svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{}</text>\n",
                       chart.x(static_cast<double>(row.beacons)), kProofTop + kHigh + 18, row.beacons);
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>number of beacons</text>\n",
                     kProofLeft + kWide / 2, kProofTop + kHigh + 38);
  if (input.tolerance_m && *input.tolerance_m >= chart.low() && *input.tolerance_m <= chart.high())
    svg += fmt::format(
        "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='currentColor'/><text x='{3}' "
        "y='{4:.1f}'>tolerance</text>\n",
        kProofLeft, kProofLeft + kWide, chart.y(*input.tolerance_m), kProofLeft + kWide + 6,
        chart.y(*input.tolerance_m) + 4);
  double y = kProofTop + 10;
  for (const ProofLine& line : kLines) {
    svg += line_svg(line, input.rows, chart);
    svg += fmt::format(
        "<line x1='{0}' x2='{1}' y1='{2}' y2='{2}' stroke='{3}' stroke-width='2' "
        "stroke-dasharray='{4}'/><text x='{5}' y='{6}'>{7}</text>\n",
        kProofLeft + kWide + 10, kProofLeft + kWide + 40, y, line.colour, line.dash, kProofLeft + kWide + 46,
        y + 4, line.name);
    y += 20;
  }
  return svg + "</svg>\n";
}

std::string placement_svg(const ProofSheetInput& input) {
  Eigen::AlignedBox2d box = bounds_of(input.floor_m);
  for (const PlacedBeacon& b : input.placement.beacons) box.extend(b.beacon.p_map_m.head<2>());
  const Eigen::Vector2d low = box.min(), high = box.max();
  const double margin = 0.06 * (high - low).maxCoeff() + 0.1, scale = 620 / ((high - low).x() + 2 * margin);
  const auto x = [&](double v) { return scale * (v - low.x() + margin); };
  const auto y = [&](double v) { return scale * (high.y() + margin - v); };
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 620 {0:.0f}' width='620' "
      "font-family='sans-serif' font-size='12' fill='currentColor'>\n",
      scale * ((high - low).y() + 2 * margin));
  std::string outline;
  for (const Eigen::Vector2d& p : input.floor_m) outline += fmt::format("{:.1f},{:.1f} ", x(p.x()), y(p.y()));
  svg += fmt::format("<polygon points='{}' fill='#8882' stroke='#888'/>\n", outline);
  for (const WallPiece& w : input.walls)
    svg += fmt::format(
        "<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='currentColor' stroke-width='2'/>\n",
        x(w.from_m.x()), y(w.from_m.y()), x(w.to_m.x()), y(w.to_m.y()));
  for (const PlacedBeacon& b : input.placement.beacons) {
    const Eigen::Vector3d& p = b.beacon.p_map_m;
    const Eigen::Vector2d to = p.head<2>() + 0.6 * margin * b.beacon.axis.head<2>();
    svg += fmt::format(
        "<line x1='{0:.1f}' y1='{1:.1f}' x2='{2:.1f}' y2='{3:.1f}' stroke='#0072b2'/><circle cx='{0:.1f}' "
        "cy='{1:.1f}' r='5' fill='{4}' stroke='#0072b2' stroke-width='2'/>"
        "<text x='{5:.1f}' y='{6:.1f}'>{7}</text>\n",
        x(p.x()), y(p.y()), x(to.x()), y(to.y()), b.mount.empty() ? "none" : "#0072b2", x(p.x()) + 7,
        y(p.y()) - 7, escape_xml(b.beacon.name));
  }
  return svg + "</svg>\n";
}

std::string proof_sheet_html(const ProofSheetInput& input) {
  const Placement& p = input.placement;
  ReportDocument document;
  document.title = input.name + ": where to put the beacons";
  document.subtitle = input.program + ", " + input.created;
  document.grade = fmt::format("{} beacons", p.beacons.size());
  document.sentence = fmt::format("{}; over {} poses: worst {}, 95 % {}, mean {}.", input.settings, p.cells,
                                  figure_text(p.figures.worst_m, "m"), figure_text(p.figures.p95_m, "m"),
                                  figure_text(p.figures.mean_m, "m"));
  document.sections.push_back(
      {"placement",
       "Placement",
       {ReportFigure{"figure-placement", "The floor, the beacons and where they look.", placement_svg(input)},
        beacons_table(p)}});
  document.sections.push_back(
      {"proof",
       "Proof",
       {ReportFigure{
            "figure-proof",
            "The goal by the number of beacons: as planned, chosen greedily, evenly spaced (the best "
            "of eight phases), and the median of 25 random layouts.",
            proof_svg(input)},
        rows_table(input)}});
  return to_html(document, {});
}

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/svg_chart.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

constexpr std::size_t kLeastBins = 2;

/// Stops whose residuals are of another size than all; few arrivals may do so by chance.
constexpr double kSticksOut = 2.0;
constexpr std::size_t kEnoughOfAStop = 5, kMostStops = 8;

std::string stops_that_stick_out(const ReportInput& input) {
  const double all_s = input.plan.deployment.statistics.rms_s;
  std::vector<const StopNote*> out;
  for (const StopNote& stop : input.stops)
    if (stop.looked_at >= kEnoughOfAStop && all_s > 0 && stop.rms_s > kSticksOut * all_s)
      out.push_back(&stop);
  if (out.empty()) return "";
  std::ranges::stable_sort(out, [](const StopNote* a, const StopNote* b) { return a->rms_s > b->rms_s; });
  std::string text = "Residuals stick out at";
  for (std::size_t i = 0; i < std::min(out.size(), kMostStops); ++i)
    text += fmt::format("{} {} ({:.1f} times the RMS of all)", i == 0 ? "" : ",",
                        (out[i]->moving ? "" : "stop ") + out[i]->name, out[i]->rms_s / all_s);
  if (out.size() > kMostStops) text += fmt::format(" and {} more", out.size() - kMostStops);
  return text + ": did the vehicle move there, or did something stand in the way?";
}

/// If there are very many names, only those with the largest residuals.
ResidualChart worst_of(const ResidualChart& chart) {
  ResidualChart worst = chart;
  if (worst.bins.size() <= kMaxRows) return worst;
  std::ranges::stable_sort(worst.bins, [](const auto& a, const auto& b) { return a.rms_s > b.rms_s; });
  worst.bins.resize(kMaxRows);
  return worst;
}

ReportTable residual_table_of(const ResidualChart& chart) {
  const Unit time = chart.time();
  const bool names = chart.unit.empty();
  ReportTable table{"residuals-by-" + chart.by,
                    "Residuals by " + chart.by,
                    {{names ? chart.by : fmt::format("{} [{}]", chart.by, chart.unit), true},
                     {"arrivals"},
                     {fmt::format("mean [{}]", time.symbol)},
                     {fmt::format("RMS [{}]", time.symbol)}},
                    {},
                    true};
  for (const auto& bin : chart.bins) {
    table.rows.push_back({{names ? bin.name : fmt::format("{:.4g} to {:.4g}", bin.from, bin.to)},
                          {std::to_string(bin.count)},
                          {fmt::format("{:.2f}", time.per_si * bin.mean_s)},
                          {fmt::format("{:.2f}", time.per_si * bin.rms_s)}});
  }
  return table;
}

}  // namespace

std::optional<ReportSection> residuals_section(const ReportInput& input) {
  if (input.residuals.empty()) return {};
  ReportSection section{"residuals", "Residuals"};
  const std::size_t used = input.plan.deployment.statistics.arrivals;
  std::string what =
      "Observed less adjusted times of flight; positive: late. Each mark is a bin of many arrivals; a trend "
      "that leaves the band of the others is "
      "something that the model does not know.";
  if (input.looked_at > 0 && input.looked_at < used)
    what += fmt::format(" Of {} of the {} arrivals, at even distances; the adjustment used all.",
                        input.looked_at, used);
  section.blocks.emplace_back(ReportText{what});
  if (std::string stops = stops_that_stick_out(input); !stops.empty())
    section.blocks.emplace_back(ReportText{std::move(stops), Tone::kAttention});
  for (const auto& whole : input.residuals) {
    if (whole.bins.size() < kLeastBins) continue;  // a chart of one point shows nothing
    const ResidualChart chart = worst_of(whole);
    const std::string bins =
        chart.bins.size() == whole.bins.size()
            ? fmt::format("{} bins", chart.bins.size())
            : fmt::format("the {} of {} bins whose RMS is largest", chart.bins.size(), whole.bins.size());
    section.blocks.emplace_back(ReportFigure{"figure-residuals-" + chart.by,
                                             fmt::format("Residuals by {}: {}.", chart.by, bins),
                                             residual_chart_svg(chart), residual_chart_json(chart)});
    section.blocks.emplace_back(residual_table_of(chart));
  }
  if (input.standardised && !input.standardised->counts.empty())
    section.blocks.emplace_back(ReportFigure{
        "figure-standardised",
        fmt::format(
            "Standardised residuals in {} bins (Baarda's w): beyond 3.29 one in a thousand is expected.",
            input.standardised->counts.size()),
        histogram_svg(*input.standardised), histogram_json(*input.standardised)});
  return section;
}

}  // namespace octant::survey

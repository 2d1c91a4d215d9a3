// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/svg_chart.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "survey/drawing/escape.h"
#include "survey/geometry/quantity.h"

namespace octant::survey {
namespace {

constexpr double kWidth = 900, kHeight = 330, kLeft = 74, kRight = 20, kTop = 40, kBottom = 56;

constexpr const char* kStyle = R"(<style>
.chart text{font:13px system-ui,sans-serif;fill:#1b2733}.chart .paper{fill:#fff}.chart .grid{stroke:#d9dfe5}.chart .zero{stroke:#5d6b78}
.chart .bar{stroke:#1660a8;stroke-width:2;fill:none}.chart .mean{fill:#b3470b;stroke:#fff}.chart .count{fill:#1660a8;fill-opacity:.55}
.chart .line{fill:none;stroke:#1660a8;stroke-width:2}.chart .other{fill:none;stroke:#b3470b;stroke-width:2;stroke-dasharray:7 4}
@media(prefers-color-scheme:dark){.chart text{fill:#dfe6ec}.chart .paper{fill:#12181e}.chart .grid{stroke:#2b353f}.chart .zero{stroke:#9aa7b3}
.chart .bar,.chart .line{stroke:#6db3f2}.chart .mean{fill:#f0945a;stroke:#12181e}.chart .count{fill:#6db3f2}.chart .other{stroke:#f0945a}}
</style>
)";

/// Axes of a chart: data to pixels.
struct Axes {
  double x_low = 0, x_high = 1, y_low = 0, y_high = 1;
  std::string svg;
  [[nodiscard]] double x(double v) const {
    return kLeft + (v - x_low) / (x_high - x_low) * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double v) const {
    return kHeight - kBottom - (v - y_low) / (y_high - y_low) * (kHeight - kTop - kBottom);
  }

  void draw_y(const std::string& name) {
    for (const double tick : axis_ticks(y_low, y_high)) {
      svg += fmt::format("<line class='{}' x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}'/>",
                         tick == 0.0 ? "zero" : "grid", kLeft, y(tick), kWidth - kRight, y(tick));
      svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{:.10g}</text>\n", kLeft - 8,
                         y(tick) + 4, tick);
    }
    svg += fmt::format("<text x='{}' y='{}'>{}</text>\n", 8, 18, escape_xml(name));
  }
  void draw_x(const std::string& name) {
    for (const double tick : axis_ticks(x_low, x_high, 9)) tick_x(x(tick), fmt::format("{:.10g}", tick));
    name_x(name);
  }
  void tick_x(double at_px, const std::string& label) {
    svg += fmt::format(
        "<line class='grid' x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}'/><text x='{0:.1f}' "
        "y='{3:.1f}' text-anchor='middle'>{4}"
        "</text>\n",
        at_px, kTop, kHeight - kBottom, kHeight - kBottom + 18, escape_xml(label));
  }
  void name_x(const std::string& name) {
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>\n", kWidth - kRight,
                       kHeight - 12, escape_xml(name));
  }
  void legend(double at_px, const std::string& symbol, const std::string& text) {
    svg += symbol + fmt::format("<text x='{:.1f}' y='18'>{}</text>\n", at_px, escape_xml(text));
  }
  [[nodiscard]] std::string whole(const std::string& label) const {
    return fmt::format(
        "<svg class='chart' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
        "height='{1:.0f}' role='img' "
        "aria-label='{2}'>\n{3}<rect class='paper' width='100%' height='100%'/>\n{4}</svg>\n",
        kWidth, kHeight, escape_xml(label), kStyle, svg);
  }
};

void widen(double& low, double& high) {
  if (high > low) return;
  const double room = std::max(std::abs(low), 1.0) * 0.5;
  low -= room;
  high += room;
}

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

}  // namespace

std::vector<double> axis_ticks(double low, double high, int about) {
  std::vector<double> ticks;
  if (!(high > low) || !std::isfinite(high - low)) return ticks;
  const double rough = (high - low) / about, power = std::pow(10.0, std::floor(std::log10(rough))),
               lead = rough / power;
  const double step = (lead > 5 ? 10 : lead > 2 ? 5 : lead > 1 ? 2 : 1) * power;
  for (double k = std::ceil(low / step); k * step <= high + 1e-9 * step; ++k)
    ticks.push_back(k * step + 0.0);  // no "-0"
  return ticks;
}

std::string residual_chart_svg(const ResidualChart& chart) {
  const bool names = chart.unit.empty();
  double reach = 0.0;
  for (const auto& bin : chart.bins) reach = std::max({reach, std::abs(bin.mean_s) * 1.4, bin.rms_s});
  const Unit time = chart.time();
  reach = reach > 0 ? 1.1 * reach * time.per_si : 1.0;
  Axes axes{0, 1, -reach, reach, {}};
  if (names) {
    axes.x_low = -0.5;
    axes.x_high = static_cast<double>(chart.bins.size()) - 0.5;
  } else if (!chart.bins.empty()) {
    axes.x_low = chart.bins.front().from;
    axes.x_high = chart.bins.back().to;
  }
  widen(axes.x_low, axes.x_high);
  axes.draw_y(fmt::format("residual [{}]", time.symbol));
  if (names) {
    const std::size_t every = chart.bins.size() / 24 + 1;
    for (std::size_t i = 0; i < chart.bins.size(); i += every)
      axes.tick_x(axes.x(static_cast<double>(i)), chart.bins[i].name);
    axes.name_x(chart.by);
  } else {
    axes.draw_x(fmt::format("{} [{}]", chart.by, chart.unit));
  }
  std::string bars, means;
  for (std::size_t i = 0; i < chart.bins.size(); ++i) {
    const auto& bin = chart.bins[i];
    const double x = axes.x(names ? static_cast<double>(i) : (bin.from + bin.to) / 2);
    const double half = names ? 5.0 : std::max(3.0, (axes.x(bin.to) - axes.x(bin.from)) / 2);
    const double up = axes.y(time.per_si * bin.rms_s), down = axes.y(-time.per_si * bin.rms_s);
    bars += fmt::format("M{0:.1f} {1:.1f}V{2:.1f}M{3:.1f} {1:.1f}h{4:.1f}M{3:.1f} {2:.1f}h{4:.1f}", x, up,
                        down, x - half, 2 * half);
    means += fmt::format("<circle class='mean' cx='{:.1f}' cy='{:.1f}' r='5'/>", x,
                         axes.y(time.per_si * bin.mean_s));
  }
  axes.svg += "<path class='bar' d='" + bars + "'/>\n" + means + "\n";
  axes.legend(520, "<circle class='mean' cx='508' cy='14' r='5'/>", "mean");
  axes.legend(600, "<path class='bar' d='M584 6v16M578 6h12M578 22h12'/>", "plus and minus the RMS");
  return axes.whole("Residuals by " + chart.by);
}

std::vector<double> normal_counts(const Histogram& histogram) {
  const double total =
      static_cast<double>(std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::size_t{0}));
  std::vector<double> expected;
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double from = histogram.from + histogram.width * static_cast<double>(i);
    const double below = i == 0 ? 0.0 : normal_cdf(from),
                 above = i + 1 == histogram.counts.size() ? 1.0 : normal_cdf(from + histogram.width);
    expected.push_back(total * (above - below));
  }
  return expected;
}

std::string histogram_svg(const Histogram& histogram) {
  const std::vector<double> expected = normal_counts(histogram);
  double most = 1.0;
  for (const std::size_t n : histogram.counts) most = std::max(most, static_cast<double>(n));
  for (const double n : expected) most = std::max(most, n);
  Axes axes{histogram.from,
            histogram.from + histogram.width * static_cast<double>(histogram.counts.size()),
            0,
            1.08 * most,
            {}};
  widen(axes.x_low, axes.x_high);
  axes.draw_y("arrivals in a bin");
  axes.draw_x("residual over its sigma");
  std::string bars, curve;
  const double width_px = axes.x(axes.x_low + histogram.width) - axes.x(axes.x_low);
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double left = axes.x(histogram.from + histogram.width * static_cast<double>(i)),
                 top = axes.y(static_cast<double>(histogram.counts[i]));
    if (histogram.counts[i] > 0)
      bars += fmt::format("M{:.1f} {:.1f}V{:.1f}h{:.1f}V{:.1f}z", left + 0.5, axes.y(0), top, width_px - 1,
                          axes.y(0));
    curve += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', left + width_px / 2, axes.y(expected[i]));
  }
  axes.svg += "<path class='count' d='" + bars + "'/>\n<path class='other' d='" + curve + "'/>\n";
  axes.legend(520, "<rect class='count' x='500' y='6' width='14' height='14'/>", "counted");
  axes.legend(632, "<path class='other' d='M596 14h30'/>", "standard normal");
  return axes.whole("Distribution of the standardised residuals");
}

std::string error_curve_svg(const std::vector<double>& quantiles_m, const std::optional<double>& limit_m) {
  if (quantiles_m.empty()) return {};
  const double high_m = std::max(quantiles_m.back(), limit_m.value_or(0.0));
  const Unit length = length_unit(high_m);
  Axes axes{0, 1.05 * length.per_si * high_m, 0, 100, {}};
  widen(axes.x_low, axes.x_high);
  axes.draw_y("share of the fixes [%]");
  axes.draw_x(fmt::format("position error below [{}]", length.symbol));
  std::string curve;
  for (std::size_t i = 0; i < quantiles_m.size(); ++i) {
    const double share = quantiles_m.size() > 1
                             ? 100.0 * static_cast<double>(i) / static_cast<double>(quantiles_m.size() - 1)
                             : 100.0;
    curve += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', axes.x(length.per_si * quantiles_m[i]),
                         axes.y(share));
  }
  axes.svg += "<path class='line' d='" + curve + "'/>\n";
  axes.legend(420, "<path class='line' d='M384 14h30'/>", "fixes of the held-out run");
  if (limit_m) {
    const double x = axes.x(length.per_si * *limit_m);
    axes.svg +=
        fmt::format("<path class='other' d='M{0:.1f} {1:.1f}V{2:.1f}'/>\n", x, kTop, kHeight - kBottom);
    axes.legend(646, "<path class='other' d='M610 14h30'/>", "tolerance (of the RMSE)");
  }
  return axes.whole("Position errors of the held-out run");
}

}  // namespace octant::survey

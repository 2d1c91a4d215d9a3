// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/site_sheet.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <qrencode.h>
#include <nlohmann/json.hpp>

#include "survey/drawing/escape.h"
#include "survey/geometry/quantity.h"
#include "survey/page/report_html.h"
#include "survey/report/report.h"

namespace octant::survey {
namespace {

constexpr int kSheetQuiet = 4;  // modules of white around, as the standard asks

constexpr const char* kSheetStyle =
    R"(.tags{display:grid;grid-template-columns:repeat(auto-fill,minmax(17rem,1fr));gap:.8rem;margin-top:1.2rem}
.tag{border:1px solid var(--soft);border-radius:.4rem;padding:.7rem .9rem;break-inside:avoid}
.tag h2{border:0;margin:0;padding:0;font-size:1.5rem;overflow-wrap:anywhere}.tag svg{width:36mm;height:36mm;float:right;margin:0 0 .3rem .6rem}
.tag dl{margin:.3rem 0 0;font-size:.85rem}.tag dt{color:var(--soft)}.tag dd{margin:0 0 .25rem;font-variant-numeric:tabular-nums}
@media print{.tags{grid-template-columns:1fr 1fr;gap:5mm}.tag h2{font-size:16pt}}
)";

std::string entry(const char* what, const std::string& value) {
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", what, escape_xml(value));
}

std::string tag_html(const Deployment& d, const DeploymentBeacon& b, const std::string& digest) {
  std::string html = "<article class='tag'>\n";
  if (b.status == BeaconStatus::kUndetermined)
    return html + "<h2>" + escape_xml(b.name) +
           "</h2>\n<p class='bad'>&#10007; not determined; localizers leave it out</p>\n</article>\n";
  const std::string code = qr_svg(beacon_tag(d, b, digest));
  html += code.empty() ? "<p>Its name is too long for a code.</p>\n" : code;
  html += "<h2>" + escape_xml(b.name) + "</h2>\n<dl>\n";
  const Eigen::Vector3d U = 2 * b.covariance_m2.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    const char* axis[] = {"x", "y", "z"};
    html += entry(axis[i], fmt::format("{:.4f}\u00a0m, U\u00a0=\u00a0{}\u00a0{}", b.position_m[i],
                                       fmt::format("{:.3g}", length_unit(U[i]).per_si * U[i]),
                                       length_unit(U[i]).symbol));
  }
  html += entry(
      "delay", fmt::format("{}, U = {}", time_symbol_text(b.delay_s), time_symbol_text(2 * b.delay_sigma_s)));
  html +=
      entry("status", b.status == BeaconStatus::kControlPoint ? "control point, held fixed" : "calibrated");
  return html + "</dl>\n</article>\n";
}

}  // namespace

std::string beacon_tag(const Deployment& deployment, const DeploymentBeacon& beacon,
                       const std::string& digest) {
  // A tenth of a millimetre is what the sheet shows.
  const auto shown = [](double metres) { return std::round(metres * 1e4) / 1e4; };
  const nlohmann::ordered_json tag = {
      {"octant", 1},
      {"site", deployment.site},
      {"beacon", beacon.name},
      {"position_m",
       {shown(beacon.position_m.x()), shown(beacon.position_m.y()), shown(beacon.position_m.z())}},
      {"deployment", digest}};
  return tag.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

std::string qr_svg(const std::string& text) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeData(static_cast<int>(text.size()), reinterpret_cast<const unsigned char*>(text.data()), 0,
                        QR_ECLEVEL_M),
      &QRcode_free);
  if (!code) return {};
  std::string path;
  for (int y = 0; y < code->width; ++y) {
    for (int x = 0; x < code->width;) {
      int end = x;
      while (end < code->width && (code->data[y * code->width + end] & 1) != 0) ++end;
      if (end > x)
        path += fmt::format("M{} {}h{}v1h-{}z", x + kSheetQuiet, y + kSheetQuiet, end - x, end - x);
      x = end + 1;
    }
  }
  const int side = code->width + 2 * kSheetQuiet;
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {0}' shape-rendering='crispEdges' role='img' "
      "aria-label='QR code'>"
      "<rect width='{0}' height='{0}' fill='#fff'/><path fill='#000' d='{1}'/></svg>\n",
      side, path);
}

std::string site_sheet_html(const Deployment& d, const std::string& digest) {
  std::string html = page_head(d.site + " – beacons", kSheetStyle, false);
  html += fmt::format("<header>\n<h1>{}</h1>\n<p class='soft'>Beacons as calibrated {}; deployment {}</p>\n",
                      escape_xml(d.site), escape_xml(d.created), escape_xml(digest));
  html += fmt::format(
      "<p>Datum: {}. Speed: {}.</p>\n<p class='soft'>Each code holds site, beacon, position and the "
      "deployment's digest as JSON. U: expanded uncertainty, k = 2.</p>\n</header>\n",
      escape_xml(d.datum.description), escape_xml(speed_in_words(d)));
  html += "<main class='tags'>\n";
  for (const auto& b : d.beacons) html += tag_html(d, b, digest);
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace octant::survey

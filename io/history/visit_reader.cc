// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include "io/deployment/deployment_digest.h"
#include "io/deployment/deployment_json.h"
#include "io/history/history.h"
#include "io/text/bounds.h"
#include "io/text/json_reader.h"
#include "models/support/utc_time.h"

namespace octant::io {
namespace {

std::int64_t date_of(const JsonValue& json) {
  const std::string text = json.text();
  const auto seconds = utc_seconds(text);
  if (!seconds) json.fail(in_quotes(text), "a date in ISO 8601, such as 2026-11-22T10:27:37Z");
  return seconds.value_or(0);
}

Result<Visit> visit_of_deployment(const nlohmann::json& json, const std::string& text,
                                  const std::string& file) {
  const auto deployment = deployment_from_json(text, file);
  if (!deployment) return fail(deployment.error());
  const Deployment& d = *deployment;
  JsonLog log{file, text, std::nullopt};
  Visit visit;
  visit.kind = VisitKind::kCalibration;
  visit.happened_s = date_of(JsonValue(&json, "", log).at("created"));
  if (log.error) return fail(*log.error);
  visit.site = d.site;
  visit.digest = visit.deployment_digest = digest_of(json);
  visit.temperature_degC = d.validity_temperature_degC;
  const double reference_degC = d.medium.temperature_degC;
  visit.speed =
      VisitSpeed{d.speed_mps(reference_degC), d.speed_sigma_mps, d.speed_offset_mps, reference_degC};
  visit.program = d.program_version;
  for (const DeploymentBeacon& b : d.beacons)
    visit.beacons.push_back({b.name, b.position_m, b.covariance_m2.diagonal().cwiseMax(0.0).cwiseSqrt(),
                             b.delay_s, b.delay_sigma_s, b.status});
  return visit;
}

/// Members that `verify` and `monitor` write before their figures.
Result<Visit> visit_of_result(const nlohmann::json& json, const std::string& text, const std::string& file) {
  if (!json.is_object() || !json.contains("kind"))
    return fail(
        {.file = file,
         .found = "neither a deployment nor what octant verify --json or octant monitor --json prints",
         .expected = "one of these",
         .advice = "results of an older octant lack 'kind', 'site' and 'created': make them again"});
  JsonLog log{file, text, std::nullopt};
  const JsonValue root(&json, "", log);
  Visit visit;
  visit.kind = root.at("kind").choice<VisitKind>(
      {{"verification", VisitKind::kVerification}, {"monitoring", VisitKind::kMonitoring}});
  visit.site = root.at("site").text();
  visit.happened_s = date_of(root.at("created"));
  visit.verdict = root.at("status").text();
  visit.deployment_digest = root.at("deployment").at("digest").text();
  visit.program = root.find("program").find("version").text();
  if (const JsonValue range = root.find("temperature_degC"); range.present()) {
    const std::vector<double> ends = range.numbers(2);
    visit.temperature_degC = {ends[0], ends[1]};
  }
  visit.digest = digest_of(json);
  if (log.error) return fail(*log.error);
  return visit;
}

}  // namespace

Result<Visit> visit_of(const std::string& text, const std::string& file) {
  if (auto ok = check_no_site_file(text, file); !ok) return fail(ok.error());
  const auto json = parse_json(text, file);
  if (!json) return fail(json.error());
  const bool is_deployment = json->is_object() && json->contains("type");
  auto visit = is_deployment ? visit_of_deployment(*json, text, file) : visit_of_result(*json, text, file);
  if (!visit) return visit;
  visit->source = file;
  visit->document = text;
  return visit;
}

Result<Visit> read_visit(const std::string& path) {
  return read_document(path).and_then([&path](const std::string& text) { return visit_of(text, path); });
}

}  // namespace octant::io

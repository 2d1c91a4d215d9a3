// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/validity_words.h"

#include <algorithm>

#include <fmt/format.h>

#include "apps/octant/text/table.h"
#include "io/deployment/deployment_json.h"
#include "models/validity.h"

namespace octant::app {

void warn_outside_validity(const Deployment& d, const std::vector<MeasurementLog>& runs,
                           const Localization& found, Session& session) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const OutsideValidity outside = outside_validity(d, runs[i], found.fixes[i]);
    if (outside.reference_assumed)
      session.note(
          fmt::format("{}: no temperature is stated, so {:g} degC is assumed, as in the calibration; a "
                      "degree of error is 0.18 % of every distance",
                      runs[i].path, d.medium.temperature_degC));
    if (outside.temperature_degC)
      session.warn(
          fmt::format("{}: {:.1f} degC is far outside the calibrated {:.1f} to {:.1f} degC: the speed there "
                      "is the model's, not measured",
                      runs[i].path, *outside.temperature_degC, (*d.validity_temperature_degC)[0],
                      (*d.validity_temperature_degC)[1]));
    if (outside.outside > 0)
      session.warn(
          fmt::format("{}: {} of {} fixes lie outside the calibrated area, up to {} from it: beacons were "
                      "not held against a recording there",
                      runs[i].path, outside.outside, outside.fixes, length_text(outside.farthest_m)));
  }
}

Json assumed_temperature_json(const Deployment& d, const std::vector<MeasurementLog>& runs) {
  const bool assumed = std::any_of(runs.begin(), runs.end(), [&](const MeasurementLog& run) {
    return outside_validity(d, run, {}).reference_assumed;
  });
  return assumed ? Json(d.medium.temperature_degC) : Json(nullptr);
}

Json result_head(const std::string& kind, const std::string& deployment_path, const Deployment& d,
                 const std::vector<MeasurementLog>& runs) {
  std::optional<std::array<double, 2>> range;
  for (const MeasurementLog& run : runs) {
    const auto stated = stated_temperatures(run);
    if (!stated) continue;
    range = range ? std::array<double, 2>{std::min((*range)[0], (*stated)[0]),
                                          std::max((*range)[1], (*stated)[1])}
                  : *stated;
  }
  const auto digest = io::deployment_digest(deployment_path);
  return {{"kind", kind},
          {"site", d.site},
          {"created", created_now()},
          {"deployment", {{"path", deployment_path}, {"digest", digest ? Json(*digest) : Json(nullptr)}}},
          {"temperature_degC", range ? Json(*range) : Json(nullptr)},
          {"program", {{"name", "octant"}, {"version", OCTANT_VERSION}}}};
}

}  // namespace octant::app

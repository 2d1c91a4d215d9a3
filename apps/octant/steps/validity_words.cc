// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/validity_words.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"
#include "models/support/utc_time.h"
#include "models/validity.h"

namespace octant::app {

namespace {

/// Describes the speed that was used without a valid temperature.
std::string speed_words(const std::string& path, const RunSpeed& speed, bool no_temperature) {
  std::string text = path;
  text += no_temperature ? ": no temperature is stated" : ": by its arrivals the speed is not the model's";
  text += fmt::format(", so the speed is taken from {} arrivals of {} poses: {:+.2f} m/s (sigma {:.2f} m/s)",
                      speed.arrivals, speed.poses, speed.offset_mps, speed.sigma_mps);
  if (no_temperature && speed.temperature_sigma_degC > 0.0)
    text += fmt::format(", as in air of {:.1f} degC (sigma {:.1f} degC)", speed.temperature_degC,
                        speed.temperature_sigma_degC);
  return text + "; its sigma is part of the fixes'";
}

/// "17.0 to 23.5", or one number if both are equal.
std::string range_text(const std::array<double, 2>& range) {
  const std::string low = fmt::format("{:.1f}", range[0]), high = fmt::format("{:.1f}", range[1]);
  return low == high ? low : low + " to " + high;
}

constexpr double kDay_s = 86400.0;

std::string why_due(const Deployment& d, const CalibrationDue& due) {
  if (!due.by_drift())
    return fmt::format("{:g} months after the calibration, as the site states", *d.validity_period.months);
  return fmt::format("by then {} may be off by more than {}, if beacons settle by {} a month", due.beacon,
                     length_text(*d.tolerance.beacon_m),
                     length_text(*d.validity_period.beacon_drift_m_per_month));
}

std::optional<double> seconds_since(std::int64_t then_s) {
  const auto now_s = utc_seconds(created_now());
  return now_s ? std::optional<double>(static_cast<double>(*now_s - then_s)) : std::nullopt;
}

std::string agreement_words(const std::optional<RunSpeed>& speed) {
  if (speed && speed->determined)
    return fmt::format("the arrivals agree with it: {:+.2f} m/s (sigma {:.2f} m/s)", speed->offset_mps,
                       speed->sigma_mps);
  const std::string unknown = speed ? "the arrivals do not tell the speed, and " : "";
  return unknown + "a degree of error is 0.18 % of every distance";
}

}  // namespace

void warn_outside_validity(const Deployment& d, const std::vector<MeasurementLog>& runs,
                           const Localization& found, Session& session) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const OutsideValidity outside = outside_validity(d, runs[i], found.of_run(i));
    const auto& speed = found.speeds[i];
    if (speed && speed->differs()) {
      session.warn(speed_words(runs[i].path, *speed, outside.reference_assumed));
    } else if (outside.reference_assumed) {
      session.note(
          fmt::format("{}: no temperature is stated, so {:g} degC is assumed, as in the calibration; {}",
                      runs[i].path, d.medium.temperature_degC, agreement_words(speed)));
    }
    if (outside.temperature_degC)
      session.warn(fmt::format(
          "{}: {:.1f} degC is far outside the calibrated {} degC: the speed there is the model's, "
          "not measured",
          runs[i].path, *outside.temperature_degC, range_text(*d.validity_temperature_degC)));
    if (outside.outside > 0)
      session.warn(
          fmt::format("{}: {} of {} fixes lie outside the calibrated area, up to {} from it: beacons were "
                      "not held against a recording there",
                      runs[i].path, outside.outside, outside.fixes, length_text(outside.farthest_m)));
  }
}

void warn_if_overdue(const Deployment& d, Session& session) {
  const auto due = calibration_due(d);
  const auto late_s = due ? seconds_since(due->at_s) : std::nullopt;
  if (late_s && *late_s >= 0.0)
    session.warn(
        fmt::format("the calibration is of {}, and a recalibration is due since {} ({}): octant monitor "
                    "tells whether it still holds, octant recalibrate renews it",
                    d.created.substr(0, 10), utc_text(due->at_s).substr(0, 10), why_due(d, *due)));
}

std::string due_line(const Deployment& d) {
  const auto due = calibration_due(d);
  if (!due) return "";
  return fmt::format("{:<17}by {} ({})\n", "recalibrate", utc_text(due->at_s).substr(0, 10),
                     why_due(d, *due));
}

Json calibration_age_json(const Deployment& d) {
  const auto created_s = utc_seconds(d.created);
  const auto age_s = created_s ? seconds_since(*created_s) : std::nullopt;
  const auto due = calibration_due(d);
  const auto late_s = due ? seconds_since(due->at_s) : std::nullopt;
  return {{"created", d.created},
          {"age_days", age_s ? Json(std::floor(*age_s / kDay_s)) : Json(nullptr)},
          {"due", due ? Json(utc_text(due->at_s)) : Json(nullptr)},
          {"overdue", late_s ? Json(*late_s >= 0.0) : Json(nullptr)}};
}

Json assumed_temperature_json(const Deployment& d, const Localization& found,
                              const std::vector<MeasurementLog>& runs) {
  bool assumed = false;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool told = found.speeds[i] && found.speeds[i]->differs();
    assumed = assumed || (!told && outside_validity(d, runs[i], {}).reference_assumed);
  }
  return assumed ? Json(d.medium.temperature_degC) : Json(nullptr);
}

Json speeds_json(const Localization& found, const std::vector<MeasurementLog>& runs) {
  Json list = Json::array();
  for (std::size_t i = 0; i < runs.size() && i < found.speeds.size(); ++i) {
    if (!found.speeds[i]) continue;
    const RunSpeed& s = *found.speeds[i];
    const auto if_told = [&s](double value) { return s.determined ? Json(value) : Json(nullptr); };
    const bool of_air = s.determined && s.temperature_sigma_degC > 0.0;
    list.push_back({{"run", runs[i].path},
                    {"determined", s.determined},
                    {"taken", s.differs()},
                    {"offset_mps", if_told(s.offset_mps)},
                    {"sigma_mps", if_told(s.sigma_mps)},
                    {"temperature_degC", of_air ? Json(s.temperature_degC) : Json(nullptr)},
                    {"temperature_sigma_degC", of_air ? Json(s.temperature_sigma_degC) : Json(nullptr)},
                    {"poses", s.poses},
                    {"arrivals", s.arrivals}});
  }
  return list;
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
          {"temperature_degC", range},
          {"program", {{"name", "octant"}, {"version", OCTANT_VERSION}}}};
}

}  // namespace octant::app

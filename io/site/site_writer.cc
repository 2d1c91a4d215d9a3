// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "io/site/site_yaml.h"
#include "io/text/text.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

using SiteOut = std::back_insert_iterator<std::string>;

std::string list_text(const std::array<std::optional<double>, 3>& values) {
  const auto item = [](const std::optional<double>& value) { return value ? exact(*value) : "null"; };
  return fmt::format("[{}, {}, {}]", item(values[0]), item(values[1]), item(values[2]));
}

std::string list_text(const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

std::string sigma_text(const std::array<std::optional<double>, 3>& sigmas) {
  return sigmas[0] && sigmas[0] == sigmas[1] && sigmas[1] == sigmas[2] ? exact(*sigmas[0])
                                                                       : list_text(sigmas);
}

bool any_stated(const std::array<std::optional<double>, 3>& values) {
  return values[0] || values[1] || values[2];
}

std::string prior_text(const Prior& prior) {
  return fmt::format("{{value: {}, sigma: {}}}", prior.value, prior.sigma);
}

std::string delay_per_text(const DelayPer& per) {
  std::string out;
  for (const auto& [on, word] :
       {std::pair{per.beacon, "beacon"}, {per.receiver, "receiver"}, {per.site, "site"}}) {
    if (on) out += fmt::format("{}{}", out.empty() ? "" : ", ", word);
  }
  if (out.empty()) return "none";
  return out.find(',') == std::string::npos ? out : fmt::format("[{}]", out);
}

void write_medium(const Site& site, SiteOut out) {
  const Medium& m = site.medium;
  fmt::format_to(out, "medium:\n  model: {}\n", to_string(m.model));
  // With a model of air or sea water the number is not used; the stated value is kept.
  if (m.model == MediumModel::kConstant || m.speed_mps != Medium{}.speed_mps)
    fmt::format_to(out, "  speed_mps: {}\n", m.speed_mps);
  fmt::format_to(out, "  temperature_degC: {}\n", m.temperature_degC);
  fmt::format_to(out, "  relative_humidity: {}\n  pressure_pa: {}\n", m.relative_humidity, m.pressure_pa);
  if (m.profile) {
    fmt::format_to(out, "  profile:\n");
    for (const SpeedProfile::Level& level : m.profile->levels())
      fmt::format_to(out, "    - [{}, {}]\n", level.height_m, level.speed_mps);
  }
  fmt::format_to(out, "  sigma_mps: {}\n  offset_per: {}\n", site.speed_sigma_mps,
                 site.speed_offset_per_run ? "run" : "site");
}

void write_timing(const Timing& t, SiteOut out) {
  fmt::format_to(out, "timing:\n  clock: {}\n",
                 t.clock == Clock::kCycleOffset ? "cycle_offset" : "synchronised");
  fmt::format_to(out, "  ranging: {}\n", t.ranging == Ranging::kTwoWay ? "two_way" : "one_way");
  if (t.ranging == Ranging::kTwoWay || t.turnaround_s != 0.0)
    fmt::format_to(out, "  turnaround_s: {}\n", t.turnaround_s);
  fmt::format_to(out, "  delay_per: {}\n", delay_per_text(t.delay_per));
  fmt::format_to(out, "  delay_s: {}\n  delay_sigma_s: {}\n", t.delay_s, t.delay_sigma_s);
  if (t.drift != 0.0 || t.drift_sigma > 0)
    fmt::format_to(out, "  drift_ppm: {}\n  drift_sigma_ppm: {}\n", 1e6 * t.drift, 1e6 * t.drift_sigma);
}

void write_noise(const Site& site, SiteOut out) {
  const Noise& n = site.noise;
  fmt::format_to(out, "noise:\n");
  if (site.tof_sigma_given) fmt::format_to(out, "  tof_sigma_s: {}\n", n.tof_sigma_s);
  fmt::format_to(out, "  amplitude_relative_sigma: {}\n", n.amplitude_relative_sigma);
  if (n.pair_sigma_s) fmt::format_to(out, "  pair_sigma_s: {}\n", *n.pair_sigma_s);
  fmt::format_to(out, "  bearing_sigma_rad: {}\n  range_sigma_m: {}\n", n.bearing_sigma_rad, n.range_sigma_m);
}

void write_attenuation(const AttenuationPrior& a, SiteOut out) {
  fmt::format_to(out, "attenuation:\n  amplitude_1m_v: {}\n", prior_text(a.amplitude_1m_v));
  fmt::format_to(out, "  absorption_np_per_m: {}\n", prior_text(a.absorption_np_per_m));
  fmt::format_to(out, "  threshold_v: {}\n  rise_time_s: {}\n", a.threshold_v, prior_text(a.rise_time_s));
  if (a.half_power_angle_rad.value > 0)
    fmt::format_to(out, "  half_power_angle_rad: {}\n", prior_text(a.half_power_angle_rad));
  if (std::isfinite(a.saturation_v)) fmt::format_to(out, "  saturation_v: {}\n", a.saturation_v);
}

void write_beacons(const Site& site, SiteOut out) {
  fmt::format_to(out, "beacons:{}\n", site.beacons.empty() ? " []" : "");
  for (const SiteBeacon& b : site.beacons) {
    fmt::format_to(out, "  - {{id: {}", yaml_text(b.name));
    if (any_stated(b.position_m)) fmt::format_to(out, ", position_m: {}", list_text(b.position_m));
    if (any_stated(b.sigma_m)) fmt::format_to(out, ", sigma_m: {}", sigma_text(b.sigma_m));
    if (b.delay_s) fmt::format_to(out, ", delay_s: {}", *b.delay_s);
    if (b.delay_sigma_s) fmt::format_to(out, ", delay_sigma_s: {}", *b.delay_sigma_s);
    fmt::format_to(out, "}}\n");
  }
}

void write_rail(const Rail& rail, SiteOut out) {
  const auto point = [](const Eigen::Vector2d& p) { return fmt::format("[{}, {}]", p.x(), p.y()); };
  if (rail.shape == Rail::Shape::kArc) {
    fmt::format_to(out, "    rail: {{centre_m: {}, radius_m: {}}}\n", point(rail.centre_m), rail.radius_m);
  } else {
    fmt::format_to(out, "    rail: {{from_m: {}, to_m: {}}}\n", point(rail.from_m), point(rail.to_m));
  }
}

void write_vehicles(const Site& site, SiteOut out) {
  fmt::format_to(out, "vehicles:\n");
  for (const SiteVehicle& vehicle : site.vehicles) {
    fmt::format_to(out, "  - id: {}\n    receivers:{}\n", yaml_text(vehicle.name),
                   vehicle.receiver_count == 0 ? " []" : "");
    for (std::size_t i = 0; i < vehicle.receiver_count; ++i) {
      const SiteReceiver& r = site.receivers[vehicle.first_receiver + i];
      fmt::format_to(out, "      - {{id: {}, position_m: {}, sigma_m: {}", yaml_text(r.name),
                     list_text(r.position_m), list_text(r.sigma_m));
      if (r.axis) fmt::format_to(out, ", axis: {}", list_text(*r.axis));
      fmt::format_to(out, "}}\n");
    }
    if (vehicle.array)
      fmt::format_to(out, "    array: {{radius_sigma_m: {}, turn_sigma_rad: {}}}\n",
                     vehicle.array->radius_sigma_m, vehicle.array->turn_sigma_rad);
    if (const auto& m = vehicle.motion)
      fmt::format_to(out,
                     "    motion: {{speed_mps: {}, acceleration_mps2: {}, turn_rate_rad_per_s: {}, "
                     "turn_acceleration_rad_per_s2: {}}}\n",
                     m->speed_mps, m->acceleration_mps2, m->turn_rate_rad_per_s,
                     m->turn_acceleration_rad_per_s2);
    if (vehicle.rail) write_rail(*vehicle.rail, out);
  }
}

void write_distances(const Site& site, SiteOut out) {
  fmt::format_to(out, "control:\n  distances:\n");
  for (const ControlDistance& d : site.distances) {
    fmt::format_to(out, "    - {{from: {}, to: {}, distance_m: {}, sigma_m: {}}}\n",
                   yaml_text(site.beacons[d.from.index()].name), yaml_text(site.beacons[d.to.index()].name),
                   d.distance_m, d.sigma_m);
  }
}

}  // namespace

std::string site_to_yaml(const Site& site) {
  std::string text;
  const SiteOut out = std::back_inserter(text);
  fmt::format_to(out, "octant_site: 1\nname: {}\n", yaml_text(site.name));
  fmt::format_to(out, "motion: {}\n", site.motion == Motion::kSpatial ? "spatial" : "planar");
  if (site.medium_given) write_medium(site, out);
  if (site.timing_given) write_timing(site.timing, out);
  write_noise(site, out);
  if (site.attenuation) write_attenuation(*site.attenuation, out);
  write_beacons(site, out);
  write_vehicles(site, out);
  if (!site.distances.empty()) write_distances(site, out);
  if (const Gates& g = site.gates; g.min_range_m > 0 || std::isfinite(g.max_range_m) || !g.triangle) {
    fmt::format_to(out, "gates:\n  min_range_m: {}\n", g.min_range_m);
    if (std::isfinite(g.max_range_m)) fmt::format_to(out, "  max_range_m: {}\n", g.max_range_m);
    fmt::format_to(out, "  triangle: {}\n", g.triangle);
  }
  if (site.tolerance.beacon_m || site.tolerance.fix_m) {
    fmt::format_to(out, "tolerance:\n");
    if (site.tolerance.beacon_m) fmt::format_to(out, "  beacon_m: {}\n", *site.tolerance.beacon_m);
    if (site.tolerance.fix_m) fmt::format_to(out, "  fix_m: {}\n", *site.tolerance.fix_m);
  }
  if (const ValidityPeriod& v = site.validity; v.stated()) {
    fmt::format_to(out, "validity:\n");
    if (v.months) fmt::format_to(out, "  months: {}\n", *v.months);
    if (v.beacon_drift_m_per_month)
      fmt::format_to(out, "  beacon_drift_m_per_month: {}\n", *v.beacon_drift_m_per_month);
  }
  if (const DriftRates& drift = site.drift; drift.given()) {
    fmt::format_to(out, "drift:\n");
    if (drift.beacon_m_per_year) fmt::format_to(out, "  beacon_m_per_year: {}\n", *drift.beacon_m_per_year);
    if (drift.delay_m_per_year) fmt::format_to(out, "  delay_m_per_year: {}\n", *drift.delay_m_per_year);
    if (drift.receiver_m_per_year)
      fmt::format_to(out, "  receiver_m_per_year: {}\n", *drift.receiver_m_per_year);
    if (drift.speed_mps_per_year)
      fmt::format_to(out, "  speed_mps_per_year: {}\n", *drift.speed_mps_per_year);
  }
  return text;
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/help/site_template.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "io/yaml/yaml_writer.h"

namespace octant::app {
namespace {

constexpr std::string_view kHead = R"(# Site file: what is known of a place before its beacons are calibrated.
# Fill in what is marked <--; the rest are typical values. Lengths are metres, times seconds, angles
# radians, temperatures degrees Celsius, and every sigma is one standard deviation: how far off the
# value beside it may be. All keys: octant schema site --page
)";

constexpr std::string_view kUltrasound = R"(
medium:                          # what the signal runs through
  model: cramer1993              # speed of sound in moist air, from the three below
  temperature_degC: 20.0         # <-- while recording; a column temperature_degC in tof.csv is better
  relative_humidity: 0.50        # 50 %
  pressure_pa: 101325            # 1013 hPa
  sigma_mps: 1.0                 # the true speed may differ from the model's by so much (m/s)
timing:
  clock: synchronised            # radio or a wire marks each firing; if not: cycle_offset
  ranging: one_way               # from beacon to receiver; there and back: two_way
  delay_per: beacon              # electronic delay, found for each beacon (or receiver, site, none)
  delay_s: 0.0                   # expected delay: 100 microseconds are 1.0e-4
  delay_sigma_s: 3.0e-4          # how far off that may be (300 microseconds, 0.1 m in air)
noise:
  tof_sigma_s: 1.0e-5            # of one time of flight: 10 microseconds, 3.4 mm in air
)";

constexpr std::string_view kUwb = R"(
medium:                          # what the signal runs through
  model: constant
  speed_mps: 299702547           # radio in air
  sigma_mps: 0.0                 # known exactly
timing:
  clock: synchronised            # ranges, not arrival times on a clock of the robot's own
  ranging: one_way               # modules that report the distance have halved the way there and back
  delay_per: beacon              # antenna delay, found for each anchor (or receiver, site, none)
  delay_s: 0.0                   # expected delay; 1 ns is 0.3 m
  delay_sigma_s: 1.0e-9          # how far off that may be
noise:
  tof_sigma_s: 3.0e-10           # of one time of flight: 0.3 nanoseconds, 0.1 m
)";

constexpr std::string_view kUnderwater = R"(
medium:                          # what the signal runs through
  model: constant
  speed_mps: 1500.0              # <-- sea water; fresh water 1480. From a probe if there is one
  sigma_mps: 10.0                # how far off that may be (m/s)
timing:
  clock: synchronised            # both clocks agree; if not: cycle_offset
  ranging: two_way               # interrogate and answer; from beacon to receiver: one_way
  turnaround_s: 0.0              # <-- from hearing to answering, two_way only
  delay_per: beacon              # electronic delay, found for each transponder (or receiver, site, none)
  delay_s: 0.0                   # expected delay
  delay_sigma_s: 1.0e-3          # how far off that may be (1 millisecond, 1.5 m)
noise:
  tof_sigma_s: 1.0e-4            # of one time of flight: 0.1 milliseconds, 0.15 m
)";

constexpr std::string_view kBeacons = R"(
# Beacons hang on the building. At least three, not in one line, tie the map to it: survey them (total
# station, or tape from two walls) and hold them fixed by sigma_m: 0. Of the others say what you know:
#   - {{id: A, position_m: [0.00, 0.00, 2.50], sigma_m: 0.0}}       surveyed: a control point
#   - {{id: B, position_m: [10.0, 0.1, 2.5], sigma_m: 0.3}}         paced off, 0.3 m or so
#   - {{id: C, position_m: [null, null, 2.5], sigma_m: [null, null, 0.01]}}   only the height is known
#   - {{id: D}}                                                     nothing is known
beacons:{}
)";

constexpr std::string_view kTail = R"(
# What the site must reach; verdicts are held against it.
tolerance:
  beacon_m: {}                 # <-- largest error of a beacon in the plane (95 %)
  fix_m: {}                    # <-- largest error of a fix (RMSE)

# For how long a calibration may be trusted: localize, verify and monitor say when the next one is due.
# validity: {{months: 12}}         # and, or instead, beacon_drift_m_per_month: 0.001
)";

/// Receivers on a ring as a placeholder: their positions have to be measured.
std::string receivers_text(const std::vector<std::string>& named) {
  const std::vector<std::string> receivers = named.empty() ? std::vector<std::string>{"r0"} : named;
  const double radius_m = receivers.size() > 1 ? 0.1 : 0.0;
  std::string text;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(receivers.size());
    const auto rounded = [](double metres) { return std::round(1e3 * metres) / 1e3 + 0.0; };
    text += fmt::format("      - {{id: {}, position_m: [{:.3f}, {:.3f}, 0.300], sigma_m: 0.003}}   # <--\n",
                        io::yaml_text(receivers[i]), rounded(radius_m * std::cos(turn)),
                        rounded(radius_m * std::sin(turn)));
  }
  return text;
}

}  // namespace

std::string site_template(SiteKind kind, const std::string& name, const io::RunIds& ids) {
  const bool dives = kind == SiteKind::kUnderwater;
  std::string text =
      std::string(kHead) +
      fmt::format("octant_site: 1\nname: {:<26} # <-- as results call it\n", io::yaml_text(name));
  text += fmt::format("motion: {:<24} # planar: drives on a floor; spatial: flies or dives\n",
                      dives ? "spatial" : "planar");
  text += kind == SiteKind::kUltrasound ? kUltrasound : dives ? kUnderwater : kUwb;
  std::string beacons;
  for (const std::string& beacon : ids.beacons)
    beacons += fmt::format("\n  - {{id: {}}}", io::yaml_text(beacon));
  text += fmt::format(kBeacons, beacons);
  text +=
      "\n# Where the receivers sit on the vehicle: x forward, y left, z up from its origin, and how far off\n"
      "# that may be. Measure with a ruler, to some millimetres.\nvehicles:\n";
  for (const auto& vehicle : ids.vehicles)
    text += fmt::format("  - id: {}\n    receivers:\n", io::yaml_text(vehicle.name)) +
            receivers_text(vehicle.receivers);
  const auto tolerance = kind == SiteKind::kUltrasound ? std::pair{"0.03", "0.05"}
                         : dives                       ? std::pair{"0.50", "1.00"}
                                                       : std::pair{"0.10", "0.15"};
  return text + fmt::format(kTail, tolerance.first, tolerance.second);
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/floor_maps.h"

#include <algorithm>

namespace octant::survey {
namespace {

struct MapDescription {
  const char *name, *title, *unit;
};
constexpr MapDescription kMapDescriptions[kMaps] = {
    {"sigma_m", "expected standard deviation, one fix's noise", "m"},
    {"total_m", "expected standard deviation with the calibration's part", "m"},
    {"calibration_m", "the calibration's part: it does not average out", "m"},
    {"speed_part_m", "the speed of sound's part, systematic too", "m"},
    {"temperature_m", "error where the air is warmer and nobody says so", "m"},
    {"sigma_heading_rad", "expected standard deviation of the heading", "rad"},
    {"hdop", "horizontal dilution of precision", ""},
    {"pdop", "dilution of position", ""},
    {"vdop", "vertical dilution", ""},
    {"tdop", "dilution of the clock's offset", ""},
    {"gdop", "dilution of position and clock", ""},
    {"heading_dop_rad_per_m", "dilution of the heading", "rad/m"},
    {"beacons_heard", "beacons heard", ""},
    {"detectable_bias_m", "smallest fault of one beacon that is surely noticed", "m"},
    {"protection_m", "horizontal protection level", "m"},
    {"mirror", "mirror image that explains the ranges as well", ""},
    {"loss_one_m", "expected standard deviation with the worst beacon gone", "m"},
    {"loss_one_beacon", "the beacon that is missed most", ""},
    {"loss_two_m", "expected standard deviation with the worst two gone", "m"}};

}  // namespace

std::vector<bool> wanted_maps(const SurveyModel& model, const Survey& survey, const SurveyOptions& options,
                              bool route) {
  std::vector<bool> wanted(kMaps, true);
  wanted[kMapTotal] = wanted[kMapCalibration] = survey.calibrated;
  wanted[kMapSpeedPart] = model.speed_sigma_mps > 0;
  wanted[kMapTemperature] = survey.temperature_error_degC.has_value();
  wanted[kMapSigmaHeading] = wanted[kMapHeadingDop] = model.unknowns.rotation > 0;
  wanted[kMapVdop] = wanted[kMapPdop] = model.motion == Motion::kSpatial;
  wanted[kMapTdop] = wanted[kMapGdop] = model.unknowns.clock;
  wanted[kMapBias] = wanted[kMapProtection] = options.integrity;
  wanted[kMapMirror] = options.integrity && model.motion == Motion::kPlanar;
  wanted[kMapLossOne] = wanted[kMapLossBeacon] = options.failures > 0 && !route;
  wanted[kMapLossTwo] = options.failures > 1 && !route;
  return wanted;
}

std::vector<FloorMap> make_maps(const std::vector<bool>& wanted, std::size_t count, const SurveyModel& model,
                                std::vector<FloorMap*>& by_name) {
  std::vector<FloorMap> maps;
  for (std::size_t m = 0; m < kMaps; ++m) {
    if (!wanted[m]) continue;
    FloorMap map{kMapDescriptions[m].name,
                 kMapDescriptions[m].title,
                 kMapDescriptions[m].unit,
                 m == kMapBeacons,
                 {},
                 std::vector<float>(count, kNoMapValue),
                 {}};
    const bool length = m == kMapSigma || m == kMapTotal || m == kMapLossOne || m == kMapLossTwo;
    if (length) map.limit = model.tolerance.fix_m;
    maps.push_back(std::move(map));
  }
  by_name.assign(kMaps, nullptr);
  for (std::size_t m = 0, k = 0; m < kMaps; ++m)
    if (wanted[m]) by_name[m] = &maps[k++];
  return maps;
}

}  // namespace octant::survey

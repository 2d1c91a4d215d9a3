// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: which maps a survey has.

#include <limits>
#include <vector>

#include "survey/map/survey_result.h"

namespace octant::survey {

/// A map's value where there is no fix.
inline constexpr float kNoMapValue = std::numeric_limits<float>::infinity();

/// The maps of a survey, in the order in which they are shown.
enum MapName : std::size_t {
  kMapSigma,
  kMapTotal,
  kMapCalibration,
  kMapSpeedPart,
  kMapTemperature,
  kMapSigmaHeading,
  kMapHdop,
  kMapPdop,
  kMapVdop,
  kMapTdop,
  kMapGdop,
  kMapHeadingDop,
  kMapBeacons,
  kMapBias,
  kMapProtection,
  kMapMirror,
  kMapLossOne,
  kMapLossBeacon,
  kMapLossTwo,
  kMaps
};

/// Selects the maps that apply to this model.
/// @param route  along a route, where losses of beacons are not evaluated
[[nodiscard]] std::vector<bool> wanted_maps(const SurveyModel& model, const Survey& survey,
                                            const SurveyOptions& options, bool route);

/// Creates these maps with `count` empty values each.
/// @param by_name  out: the map of each MapName, or null
[[nodiscard]] std::vector<FloorMap> make_maps(const std::vector<bool>& wanted, std::size_t count,
                                              const SurveyModel& model, std::vector<FloorMap*>& by_name);

}  // namespace octant::survey

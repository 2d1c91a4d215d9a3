// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: which maps a survey has.

#include <limits>
#include <vector>

#include "survey/map/survey.h"

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

/// Which maps make sense for this model.
/// @param route  along a route, where no losses are looked at
[[nodiscard]] std::vector<bool> wanted_maps(const SurveyModel& model, const Survey& survey,
                                            const SurveyOptions& options, bool route);

/// Those maps with `count` empty values each.
/// @param by_name  out: of each MapName its map among them, or null
[[nodiscard]] std::vector<FloorMap> make_maps(const std::vector<bool>& wanted, std::size_t count,
                                              const SurveyModel& model, std::vector<FloorMap*>& by_name);

}  // namespace octant::survey

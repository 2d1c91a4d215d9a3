// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "io/schema/schema_texts.h"

namespace octant::io {
namespace {

constexpr std::string_view kSurveyHead = R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:survey:1",
  "title": "Octant survey (octant survey --csv cells.csv --maps DIR)",
  "description": "What a geometry is worth, cell by cell and along routes. An empty cell of a table: no fix there.",
  "type": "object",
  "x-files": {
    "cells.csv": {
      "description": "a row for each cell of the floor, the worst of its headings; RFC 4180, decimal point",
      "columns": {
        "x_m": "middle of the cell",
        "y_m": "middle of the cell",
)json";

/// What a fix is worth at a cell or a pose of a route.
constexpr std::string_view kSurveyOfAFix =
    R"json(        "sigma_m": "expected standard deviation of a fix by the noise of its arrivals",
        "total_m": "optional; the same with the calibration's part; left out: a site that is not calibrated",
        "calibration_m": "optional; the calibration's part alone, which does not average out; left out: a site that is not calibrated",
        "speed_part_m": "optional; shift of a fix by one sigma of the speed of sound; left out: the speed is held fixed",
        "temperature_m": "optional; error where the air is warmer by the scene's temperature_error_degC and nobody says so; left out: the speed does not depend on it",
        "sigma_heading_rad": "optional; expected standard deviation of the heading; left out: one receiver tells none",
        "hdop": "horizontal dilution of precision",
        "pdop": "optional; dilution of the position in space; left out: planar motion",
        "vdop": "optional; vertical dilution; left out: planar motion",
        "tdop": "optional; dilution of the clock's offset; left out: a synchronised clock",
        "gdop": "optional; dilution of position and clock together; left out: a synchronised clock",
        "heading_dop_rad_per_m": "optional; dilution of the heading; left out: one receiver tells none",
        "beacons_heard": "how many beacons are heard",
        "detectable_bias_m": "optional; smallest fault of one beacon that is surely noticed; left out: not asked for",
        "protection_m": "optional; bound of the error in the plane, an unnoticed fault of one beacon included; left out: not asked for",
        "mirror": "optional; 1: a mirror image explains the ranges as well, else 0; left out: motion in space",
)json";

constexpr std::string_view kSurveyRoutes =
    R"json(        "loss_one_m": "optional; expected standard deviation with the worst beacon gone; left out: --failures 0",
        "loss_one_beacon": "optional; the beacon that is missed most; left out: --failures 0",
        "loss_two_m": "optional; expected standard deviation with the worst two gone; left out: --failures below 2, or more than 300 beacons",
        "heard": "ids of the beacons that are heard, separated by semicolons; empty: none"
      }
    },
    "routes.csv": {
      "description": "a row for each pose along the scene's routes; written where there are any",
      "columns": {
        "route": "id of the scene's route",
        "x_m": "a pose along the route, a cell apart",
        "y_m": "a pose along the route, a cell apart",
        "heading_rad": "along the route, counter-clockwise from +x",
)json";

constexpr std::string_view kSurveyTail =
    R"json(        "heard": "ids of the beacons that are heard, separated by semicolons; empty: none"
      }
    },
    "NAME.svg": {"description": "a drawing of each column of cells.csv with beacons, walls and a legend; against tolerance.fix_m green inside, amber near, red beyond"},
    "NAME.png": {"description": "the same, a pixel a cell, north up, in the drawing's colours; transparent: off the floor"},
    "NAME.pgm": {"description": "the same as a costmap: 254 best, 1 at the tolerance (else at the 95 % quantile), 0 beyond it or no fix, 205 off the floor"},
    "NAME.yaml": {
      "description": "goes with NAME.pgm, as ROS' map_server reads it",
      "columns": {
        "image": "NAME.pgm",
        "mode": "scale: grey values are costs",
        "resolution": "side of a cell in metres",
        "origin": "x, y of the lower left corner in metres, and a turn, which is 0",
        "negate": "0",
        "occupied_thresh": "costs from this share of the range on count as occupied",
        "free_thresh": "and up to this as free"
      }
    }
  }
}
)json";

}  // namespace

std::string_view survey_schema() {
  static const std::string text = std::string(kSurveyHead)
                                      .append(kSurveyOfAFix)
                                      .append(kSurveyRoutes)
                                      .append(kSurveyOfAFix)
                                      .append(kSurveyTail);
  return text;
}

}  // namespace octant::io

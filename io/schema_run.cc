// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema_texts.h"

namespace octant::io {

std::string_view run_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:run:1",
  "title": "Octant run file (run.yaml)",
  "description": "What holds for a whole recording. The rows are beside it: tof.csv, bearings.csv, scans.csv, odometry.csv, poses.tum, truth.tum.",
  "type": "object",
  "required": ["octant_run"],
  "additionalProperties": false,
  "properties": {
    "octant_run": {"const": 1, "description": "version of the format"},
    "vehicle": {"type": ["string", "number", "boolean"], "description": "of rows that name none", "default": "robot"},
    "temperature_degC": {"type": "number", "minimum": -100, "maximum": 100},
    "relative_humidity": {"type": "number", "minimum": 0, "maximum": 1},
    "pressure_pa": {"type": "number", "minimum": 1e4, "maximum": 1e7},
    "range_max_m": {"type": "number", "exclusiveMinimum": 0, "description": "scan beams beyond it saw nothing"},
    "poses": {
      "description": "accuracy of poses.tum; sigma 0: exact",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "position_sigma_m": {"$ref": "#/$defs/not_negative", "default": 0.01},
        "heading_sigma_rad": {"$ref": "#/$defs/not_negative", "default": 0.01},
        "heading": {"const": "unknown"},
        "attitude_sigma_rad": {"$ref": "#/$defs/not_negative", "description": "roll and pitch; the heading's where it is not given"},
        "max_gap_s": {"$ref": "#/$defs/not_negative", "default": 1, "description": "longest gap over which poses are interpolated"}
      },
      "not": {"required": ["heading", "heading_sigma_rad"]}
    },
    "truth": {
      "description": "accuracy of truth.tum",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "position_sigma_m": {"$ref": "#/$defs/not_negative", "default": 0.01},
        "heading_sigma_rad": {"$ref": "#/$defs/not_negative", "default": 0.01},
        "heading": {"const": "unknown"},
        "attitude_sigma_rad": {"$ref": "#/$defs/not_negative"}
      },
      "not": {"required": ["heading", "heading_sigma_rad"]}
    },
    "odometry": {
      "description": "over a step of length d and turn a: sigma_xy^2 = distance^2 d + floor_m^2, sigma_heading^2 = heading^2 d + (per_rad a)^2 + floor_rad^2",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "distance_sigma_m_per_sqrt_m": {"$ref": "#/$defs/not_negative", "default": 0.02},
        "heading_sigma_rad_per_sqrt_m": {"$ref": "#/$defs/not_negative", "default": 0.02},
        "heading_sigma_per_rad": {"$ref": "#/$defs/not_negative", "default": 0},
        "floor_m": {"$ref": "#/$defs/not_negative", "default": 1e-4},
        "floor_rad": {"$ref": "#/$defs/not_negative", "default": 1e-4}
      }
    }
  },
  "$defs": {"not_negative": {"type": "number", "minimum": 0}}
}
)json";
}

}  // namespace octant::io

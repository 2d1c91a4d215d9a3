// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view run_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:run:1",
  "title": "Octant run file (run.yaml)",
  "description": "What holds for a whole recording. The rows are beside it, in the files that x-files lists with their columns; at least one of tof.csv, bearings.csv and scans.csv.",
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
  "$defs": {"not_negative": {"type": "number", "minimum": 0}},
  "x-files": {
    "tof.csv": {
      "description": "arrivals, a row each; time_s does not decrease. Rows with the same epoch (one contiguous block a vehicle) share one pose of the vehicle; without the column it moves",
      "columns": {
        "time_s": "the instant at which the vehicle's end of the path acts",
        "beacon": "id of the site's",
        "tof_s": "time of flight; empty, nan or not positive: nothing came, the row is counted and left out (negative is legal for a clock with a cycle offset)",
        "distance_m": "in place of tof_s where medium.model is constant: the distance at its speed_mps",
        "epoch": "optional; whole number of the stop",
        "vehicle": "optional; run.yaml's, else robot",
        "receiver": "optional where the vehicle has one",
        "amplitude_v": "optional",
        "level_dbm": "optional, in place of amplitude_v",
        "temperature_degC": "optional; else run.yaml's, else the site's"
      }
    },
    "odometry.csv": {
      "description": "how the vehicle moved: each row is its pose in the frame of the row before (x forward, y left, heading counter-clockwise); the first row is the anchor, all zero. In space (inertial, visual odometry): dz_m, and qx, qy, qz, qw in place of dheading_rad",
      "columns": {"time_s": "increasing", "dx_m": "forward, in the frame of the row before", "dy_m": "left, in the frame of the row before", "dheading_rad": "turn, counter-clockwise; in space a quaternion instead", "dz_m": "optional: up, in the frame of the row before", "qx": "in space, with qy, qz and qw: this row's axes in those of the row before", "qy": "see qx", "qz": "see qx", "qw": "see qx", "vehicle": "optional"}
    },
    "odometry.tum": {"description": "in place of odometry.csv, in the format of poses.tum: where odometry has the vehicle, in a frame of its own"},
    "bearings.csv": {
      "description": "directions to reflectors, which stand among the site's beacons",
      "columns": {"time_s": "does not decrease", "reflector": "id of the site's; empty: an unlabelled one", "bearing_rad": "in the vehicle's frame, counter-clockwise from +x", "epoch": "optional; the same number in tof.csv is the same pose", "vehicle": "optional"}
    },
    "scans.csv": {
      "description": "laser scans; an empty cell, or one beyond range_max_m, saw nothing",
      "columns": {"time_s": "does not decrease", "angle_min_rad": "of the first beam", "angle_increment_rad": "from beam to beam", "range0_m, range1_m, ...": "a column a beam"}
    },
    "points.csv": {
      "description": "poses measured by hand, one a stop; observations like poses.tum, of which there is then none",
      "columns": {"epoch": "of tof.csv or bearings.csv, once each", "x_m": "of the vehicle, in the map", "y_m": "of the vehicle, in the map", "z_m": "optional", "heading_rad": "optional", "sigma_m": "optional; else poses.position_sigma_m of run.yaml", "heading_sigma_rad": "optional; else poses.heading_sigma_rad", "vehicle": "optional"}
    },
    "truth.csv": {"description": "a reference for octant verify, with the columns of points.csv; nothing else opens it"},
    "poses.tum": {"description": "measured poses of the vehicle, observations: time_s x y z qx qy qz qw in a row, separated by blanks, time strictly increasing; # begins a comment",
      "columns": {"time_s": "strictly increasing", "x y z": "of the vehicle in the map, metres", "qx qy qz qw": "its rotation as a quaternion; 0 0 0 1 for none"}},
    "truth.tum": {"description": "a reference trajectory for octant verify, in the format of poses.tum; nothing else opens it"}
  }
}
)json";
}

}  // namespace octant::io

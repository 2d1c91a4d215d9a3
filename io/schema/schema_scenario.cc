// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_scenario.h"

namespace octant::io {

std::string_view scenario_schema() {
  return R"schema({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "title": "Octant scenario",
  "description": "A world for octant simulate: the truth, and how it is recorded.",
  "type": "object",
  "required": ["octant_scenario", "site"],
  "properties": {
    "octant_scenario": {"const": 1},
    "site": {
      "type": "object",
      "description": "Content of a site file (octant schema site), but with the beacons' TRUE positions. sigma_m is what people know: the simulated site file gets truth plus noise of that sigma; 0 is a control point; null, nobody knows the coordinate.",
      "required": ["beacons", "vehicles"]
    },
    "hall_m": {"description": "Floor of the hall from the origin, x and y.", "$ref": "#/$defs/pair", "default": [20.0, 12.0]},
    "range_m": {"description": "Beyond it nothing is heard.", "type": "number", "exclusiveMinimum": 0, "default": 12.0},
    "hearing_half_angle_rad": {"description": "Half angle of the cone in which a receiver with an axis hears; above pi: all round.", "type": "number", "exclusiveMinimum": 0, "default": 3.2},
    "path": {"description": "How the vehicle goes in the calibration run.", "$ref": "#/$defs/path"},
    "heldout_path": {"description": "The same for the held-out run; keys left out are those of path, with a third of the epochs or half of the time.", "$ref": "#/$defs/path"},
    "echo_fraction": {"description": "Share of late arrivals, half of them because a beacon is shadowed for an epoch.", "type": "number", "minimum": 0, "maximum": 0.99, "default": 0},
    "echo_delay_s": {"description": "Shortest and longest lateness of an echo, log-uniform.", "$ref": "#/$defs/pair", "default": [0.3e-3, 12e-3]},
    "early_fraction": {"description": "Share of spurious early arrivals.", "type": "number", "minimum": 0, "maximum": 0.99, "default": 0},
    "quantum_s": {"description": "Resolution of the counter; 0: none.", "type": "number", "minimum": 0, "default": 0},
    "true_speed_offset_mps": {"description": "True speed less that of the site's medium. Left out: from true_temperature_offset_degC, else drawn from medium.sigma_mps.", "type": "number"},
    "true_temperature_offset_degC": {"description": "True temperature less the site's.", "type": "number"},
    "warming_degC": {"description": "Rise of the temperature along the run, logged in the temperature column; 0: no column.", "type": "number", "default": 0},
    "true_delay_s": {"description": "Lowest and highest true delay, uniform. Left out: drawn from timing.delay_s and delay_sigma_s.", "$ref": "#/$defs/pair"},
    "cycle_offset_s": {"description": "Lowest and highest offset of an epoch with clock cycle_offset, uniform.", "$ref": "#/$defs/pair", "default": [0.0, 0.05]},
    "unknown_beacons": {"description": "The simulated site file says nothing of the positions of beacons that are no control points.", "type": "boolean", "default": false},
    "log_amplitude": {"description": "Write the amplitude column.", "type": "boolean", "default": false},
    "log_poses": {"description": "Write measured poses, poses.tum.", "type": "boolean", "default": false},
    "bearings": {
      "description": "Bearings to the site's beacons, which then are reflectors; once a stop, or along a drive. Noise: noise.bearing_sigma_rad of the site. A site without noise.tof_sigma_s has no arrivals.",
      "type": "object",
      "properties": {
        "range_m": {"description": "Beyond it a reflector is not seen.", "type": "number", "exclusiveMinimum": 0, "default": 1e6},
        "unlabelled_fraction": {"description": "Share of bearings without a reflector's name.", "type": "number", "minimum": 0, "maximum": 1, "default": 0},
        "period_s": {"description": "Of a drive.", "type": "number", "exclusiveMinimum": 0, "default": 0.5}
      }
    },
    "scans": {
      "description": "Laser scans of walls_m from the vehicle frame's origin; once a stop, or along a drive. Noise: noise.range_sigma_m of the site.",
      "type": "object",
      "properties": {
        "period_s": {"description": "Of a drive.", "type": "number", "exclusiveMinimum": 0, "default": 0.5},
        "angle_min_rad": {"type": "number", "default": -1.5707963267948966},
        "angle_increment_rad": {"type": "number", "exclusiveMinimum": 0, "default": 0.017453292519943295},
        "beams": {"type": "integer", "minimum": 1, "default": 181},
        "range_max_m": {"type": "number", "exclusiveMinimum": 0, "default": 30.0}
      }
    },
    "walls_m": {"description": "Ends of straight walls, x1 y1 x2 y2. They stop the scanner's beams, but neither sound nor bearings.", "type": "array", "items": {"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4}},
    "poses": {
      "description": "Accuracy of the measured poses, as in run.yaml.",
      "type": "object",
      "properties": {
        "position_sigma_m": {"type": "number", "minimum": 0}, "heading_sigma_rad": {"type": "number", "minimum": 0},
        "heading": {"const": "unknown"}, "attitude_sigma_rad": {"type": "number", "minimum": 0},
        "max_gap_s": {"type": "number", "exclusiveMinimum": 0}
      }
    },
    "odometry": {
      "description": "Noise of the odometry, as in run.yaml.",
      "type": "object",
      "properties": {
        "distance_sigma_m_per_sqrt_m": {"type": "number", "minimum": 0}, "heading_sigma_rad_per_sqrt_m": {"type": "number", "minimum": 0},
        "heading_sigma_per_rad": {"type": "number", "minimum": 0}, "floor_m": {"type": "number", "minimum": 0},
        "floor_rad": {"type": "number", "minimum": 0}
      }
    }
  },
  "$defs": {
    "pair": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
    "path": {
      "type": "object",
      "properties": {
        "kind": {"description": "stops: stationary epochs along a Lissajous figure through the hall; waypoints: stationary epochs evenly along a polyline; stations: stationary epochs at the poses listed; drive: continuous, between random goals or round the waypoints, with odometry.", "enum": ["stops", "waypoints", "stations", "drive"], "default": "stops"},
        "epochs": {"type": "integer", "minimum": 1, "default": 120},
        "epoch_period_s": {"type": "number", "exclusiveMinimum": 0, "default": 5.0},
        "slot_s": {"description": "Between the firings of two beacons.", "type": "number", "exclusiveMinimum": 0, "default": 0.05},
        "rounds": {"description": "How often each beacon fires in an epoch.", "type": "integer", "minimum": 1, "default": 1},
        "duration_s": {"description": "Of a drive.", "type": "number", "exclusiveMinimum": 0, "default": 120.0},
        "speed_mps": {"type": "number", "exclusiveMinimum": 0, "default": 0.6},
        "turn_rate_rad_per_s": {"type": "number", "exclusiveMinimum": 0, "default": 0.7},
        "odometry_period_s": {"type": "number", "exclusiveMinimum": 0, "default": 0.05},
        "waypoints_m": {"type": "array", "items": {"$ref": "#/$defs/pair"}},
        "stations": {"description": "Of kind stations: [x_m, y_m, heading_rad] of each; epochs is their number unless it is stated.", "type": "array", "minItems": 1, "items": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}}
      }
    }
  }
}
)schema";
}

}  // namespace octant::io

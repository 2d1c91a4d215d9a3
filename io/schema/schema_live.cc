// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view live_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:live:1",
  "title": "Octant live lines (octant localize --follow)",
  "description": "One JSON object a line, at most 65536 bytes, in the order of time of each vehicle; empty lines and lines that begin with # say nothing. Keys that are not listed are ignored. Times are seconds on any clock that is the same for all lines.",
  "type": "object",
  "oneOf": [{"$ref": "#/$defs/arrival"}, {"$ref": "#/$defs/odometry"}, {"$ref": "#/$defs/flush"}],
  "$defs": {
    "name": {"type": ["string", "integer"]},
    "arrival": {
      "description": "One time of flight. Arrivals of one epoch, or without epochs those within 5 ms of each other, make a fix as soon as one of another pose comes, or nothing for 2 s (without epochs: 50 ms); with odometry each instant makes one, as soon as the odometry row at or after it has come.",
      "type": "object",
      "required": ["time_s", "beacon"],
      "properties": {
        "time_s": {"type": "number", "description": "the instant at which the vehicle's end of the path acts"},
        "beacon": {"$ref": "#/$defs/name"},
        "tof_s": {"type": "number"},
        "distance_m": {"type": "number", "description": "instead of tof_s, where the medium's speed is constant"},
        "epoch": {"type": ["integer", "null"], "description": "arrivals of one stop share one"},
        "vehicle": {"$ref": "#/$defs/name", "description": "none: the only one, or robot"},
        "receiver": {"$ref": "#/$defs/name", "description": "none: the vehicle's only one"},
        "amplitude_v": {"type": ["number", "null"]},
        "temperature_degC": {"type": ["number", "null"]}
      }
    },
    "odometry": {
      "description": "The vehicle's pose in the frame that it had at its row before; its first row is the anchor. How good it is says --odometry RUN.yaml, by the keys of a recording's odometry block (octant schema run), or what holds there where nothing is said.",
      "type": "object",
      "required": ["time_s"],
      "anyOf": [{"required": ["dx_m"]}, {"required": ["dheading_rad"]}, {"required": ["qx", "qy", "qz", "qw"]}],
      "properties": {
        "time_s": {"type": "number"},
        "dx_m": {"type": "number", "default": 0},
        "dy_m": {"type": "number", "default": 0},
        "dheading_rad": {"type": "number", "default": 0},
        "dz_m": {"type": "number", "default": 0, "description": "of a vehicle in space"},
        "qx": {"type": "number", "description": "in space, with qy, qz and qw in place of dheading_rad: this row's axes in those of the row before"},
        "qy": {"type": "number"}, "qz": {"type": "number"}, "qw": {"type": "number"},
        "vehicle": {"$ref": "#/$defs/name"}
      }
    },
    "flush": {"description": "Nothing more is coming of the pose that is open.", "type": "object", "required": ["flush"]},
    "fix": {
      "description": "What comes out with --format json; x_m to sigma_heading_rad with status ok alone.",
      "type": "object",
      "required": ["type", "time_s", "vehicle", "status", "arrivals_used", "arrivals_rejected", "integrity", "integrity_reason"],
      "properties": {
        "type": {"const": "fix"},
        "time_s": {"type": "number"},
        "vehicle": {"type": "string"},
        "status": {"enum": ["ok", "too_few_arrivals", "poor_geometry", "ambiguous", "no_consensus", "not_converged"]},
        "epoch": {"type": "integer"},
        "x_m": {"type": "number"}, "y_m": {"type": "number"}, "z_m": {"type": "number"},
        "heading_rad": {"type": "number"},
        "quaternion_xyzw": {"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4},
        "sigma_x_m": {"type": "number"}, "sigma_y_m": {"type": "number"},
        "sigma_heading_rad": {"type": "number", "description": "pi: not known"},
        "protection_level_m": {"type": "number"},
        "arrivals_used": {"type": "integer"}, "arrivals_rejected": {"type": "integer"},
        "integrity": {"enum": ["ok", "degraded", "no_fix"]},
        "integrity_reason": {"type": "string", "description": "beacon_fault, not_protected, or the status; empty where all is well"}
      }
    },
    "alarm": {
      "description": "With --watch: what no longer fits the deployment.",
      "type": "object",
      "required": ["type", "time_s", "kind", "size_m", "sigma_m", "since_s"],
      "properties": {
        "type": {"const": "alarm"},
        "kind": {"enum": ["beacon_late", "beacon_moved", "receiver_late", "receiver_moved"]},
        "beacon": {"type": "string"},
        "receiver": {"type": "string", "description": "vehicle/receiver"},
        "axis": {"enum": ["x", "y", "z"]},
        "size_m": {"type": "number"}, "sigma_m": {"type": "number"},
        "since_s": {"type": "number"}, "time_s": {"type": "number"}
      }
    }
  }
})json";
}

}  // namespace octant::io

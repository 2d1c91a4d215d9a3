// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What octant convert keeps beside a run: how it was read; and what a user keeps for all commands.
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view columns_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:columns:1",
  "title": "Octant columns of a table (octant convert --columns columns.yaml)",
  "description": "Which column of any table of times of flight or distances becomes which of tof.csv. A source is a column's name, for numbers with a factor behind a star (timestamp_ms*1e-3); without one, a name that ends in _ms, _us, _ns, _cm, _mm, _km, _ft or _mv is taken in that unit. octant convert --columns time=...,beacon=... writes it beside the run.",
  "type": "object",
  "required": ["octant_columns", "columns"],
  "additionalProperties": false,
  "properties": {
    "octant_columns": {"const": 1},
    "columns": {
      "type": "object",
      "required": ["time_s", "beacon"],
      "additionalProperties": false,
      "properties": {
        "time_s": {"type": "string"},
        "beacon": {"type": "string"},
        "tof_s": {"type": "string"},
        "distance_m": {"type": "string"},
        "epoch": {"type": "string"},
        "vehicle": {"type": "string"},
        "receiver": {"type": "string"},
        "amplitude_v": {"type": "string"},
        "temperature_degC": {"type": "string"}
      }
    },
    "ignore": {"type": "array", "items": {"type": "string"}}
  }
}
)json";
}

std::string_view topics_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:topics:1",
  "title": "Octant topics of a bag (octant convert --topics topics.yaml)",
  "description": "Which topic of a ROS 2 bag is what. {beacon}, {receiver} and {vehicle} stand in a topic or a frame for a name without a slash, * for anything. octant convert --topics range=... writes it beside the run.",
  "type": "object",
  "required": ["octant_topics"],
  "additionalProperties": false,
  "properties": {
    "octant_topics": {"const": 1},
    "ranges": {
      "type": "array",
      "items": {
        "type": "object",
        "required": ["topic"],
        "additionalProperties": false,
        "properties": {
          "topic": {"type": "string"},
          "frame": {"type": "string"},
          "beacon": {"type": "string"},
          "receiver": {"type": "string"},
          "vehicle": {"type": "string"}
        }
      }
    },
    "odometry": {"$ref": "#/$defs/pose"},
    "poses": {"$ref": "#/$defs/pose"},
    "truth": {"$ref": "#/$defs/pose"},
    "time": {"enum": ["header", "recorded"], "default": "header"},
    "ignore": {"type": "array", "items": {"type": "string"}}
  },
  "$defs": {
    "pose": {
      "type": "object",
      "required": ["topic"],
      "additionalProperties": false,
      "properties": {
        "topic": {"type": "string"},
        "parent": {"type": "string"},
        "child": {"type": "string"}
      }
    }
  }
}
)json";
}

std::string_view defaults_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:defaults:1",
  "title": "Octant defaults (~/.config/octant/defaults.yaml, or the file that OCTANT_DEFAULTS names)",
  "description": "What would otherwise be typed with every command; a command's own words go before it. Only what changes no result can stand here, so that no deployment hangs on a file that nobody sees. An empty OCTANT_DEFAULTS: no such file is read.",
  "type": "object",
  "required": ["octant_defaults"],
  "additionalProperties": false,
  "properties": {
    "octant_defaults": {"const": 1},
    "threads": {"type": "integer", "minimum": 0, "maximum": 1024, "default": 0},
    "progress": {"enum": ["auto", "plain", "json", "none"], "default": "auto"},
    "quiet": {"type": "boolean", "default": false},
    "verbose": {"type": "boolean", "default": false}
  }
}
)json";
}

}  // namespace octant::io

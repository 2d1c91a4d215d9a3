// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view site_schema() {
  static const std::string text = std::string(R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:site:1",
  "title": "Octant site file (site.yaml)",
  "description": "What is known of a site before calibration. SI units, radians, degrees Celsius; map: z up; vehicle: x forward, y left, z up.",
  "type": "object",
  "required": ["octant_site", "motion", "beacons", "vehicles"],
  "additionalProperties": false,
  "properties": {
    "octant_site": {"const": 1, "description": "version of the format"},
    "name": {"type": "string"},
    "motion": {"enum": ["planar", "spatial"], "description": "planar: x, y, heading; spatial: 6 degrees of freedom"},
    "medium": {
      "description": "may be left out where there are no arrivals",
      "type": ["object", "null"],
      "required": ["model"],
      "additionalProperties": false,
      "properties": {
        "model": {"enum": ["cramer1993", "linear_temperature", "constant"]},
        "temperature_degC": {"type": "number", "minimum": -100, "maximum": 100, "default": 20},
        "relative_humidity": {"type": "number", "minimum": 0, "maximum": 1, "default": 0.5},
        "pressure_pa": {"type": "number", "minimum": 1e4, "maximum": 1e7, "default": 101325},
        "speed_mps": {"$ref": "#/$defs/positive", "description": "of the constant model"},
        "sigma_mps": {"$ref": "#/$defs/not_negative", "default": 0, "description": "prior of the offset from the model; 0: held fixed"},
        "offset_per": {"enum": ["site", "run"], "default": "site"}
      },
      "if": {"properties": {"model": {"const": "constant"}}},
      "then": {"required": ["speed_mps"]}
    },
    "timing": {
      "description": "may be left out where there are no arrivals",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "clock": {"enum": ["synchronised", "cycle_offset"], "default": "synchronised"},
        "ranging": {"enum": ["one_way", "two_way"], "default": "one_way"},
        "turnaround_s": {"$ref": "#/$defs/not_negative", "default": 0},
        "delay_per": {
          "default": "none",
          "oneOf": [
            {"enum": ["beacon", "receiver", "site", "none"]},
            {"type": "array", "items": {"enum": ["beacon", "receiver", "site"]}}
          ]
        },
        "delay_s": {"type": "number", "default": 0},
        "delay_sigma_s": {"$ref": "#/$defs/not_negative", "default": 0},
        "drift_ppm": {"type": "number", "default": 0, "description": "cycle_offset: rate of the vehicle's clock against the beacons', prior mean"},
        "drift_sigma_ppm": {"$ref": "#/$defs/not_negative", "default": 0, "description": "0: held fixed"}
      }
    },
    "noise": {
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "tof_sigma_s": {"$ref": "#/$defs/positive"},
        "amplitude_relative_sigma": {"$ref": "#/$defs/positive", "default": 0.05},
        "pair_sigma_s": {"$ref": "#/$defs/not_negative"},
        "bearing_sigma_rad": {"$ref": "#/$defs/positive", "default": 0.01},
        "range_sigma_m": {"$ref": "#/$defs/positive", "default": 0.02}
      }
    },
    "attenuation": {
      "description": "leave the block out to switch time-walk off",
      "type": ["object", "null"],
      "required": ["amplitude_1m_v", "absorption_np_per_m", "threshold_v", "rise_time_s"],
      "additionalProperties": false,
      "properties": {
        "amplitude_1m_v": {"$ref": "#/$defs/prior"},
        "absorption_np_per_m": {"$ref": "#/$defs/prior"},
        "threshold_v": {"$ref": "#/$defs/not_negative"},
        "rise_time_s": {"$ref": "#/$defs/prior"},
        "half_power_angle_rad": {"description": "off a receiver's axis, where the amplitude is 3 dB down; left out: receivers hear all round alike", "$ref": "#/$defs/prior"},
        "saturation_v": {"description": "logged amplitudes from here on are not used", "$ref": "#/$defs/positive"}
      }
    },
    "beacons": {
      "type": "array",
      "items": {
        "type": "object",
        "required": ["id"],
        "additionalProperties": false,
        "properties": {
          "id": {"$ref": "#/$defs/id"},
          "position_m": {"description": "null: unknown", "oneOf": [{"$ref": "#/$defs/coordinates_or_null"}, {"type": "null"}]},
          "sigma_m": {
            "description": "one for all axes or one each; 0: held fixed; null or absent: no prior",
            "oneOf": [{"$ref": "#/$defs/not_negative"}, {"$ref": "#/$defs/coordinates_or_null"}, {"type": "null"}]
          },
          "delay_s": {"type": "number", "description": "prior of this beacon's delay, in place of timing.delay_s; delay_per: beacon"},
          "delay_sigma_s": {"description": "in place of timing.delay_sigma_s; 0: held fixed", "$ref": "#/$defs/not_negative"}
        }
      }
    },
    "vehicles": {
      "type": "array",
      "minItems": 1,
      "items": {
        "type": "object",
        "additionalProperties": false,
        "properties": {
          "id": {"$ref": "#/$defs/id", "default": "robot"},
          "array": {
            "description": "the receivers as one piece, adjusted by its radius and its turn instead of receiver by receiver",
            "type": ["object", "null"],
            "additionalProperties": false,
            "properties": {
              "radius_sigma_m": {"$ref": "#/$defs/not_negative", "default": 0},
              "turn_sigma_rad": {"$ref": "#/$defs/not_negative", "default": 0}
            }
          },
          "motion": {
            "description": "how the vehicle usually moves: ties its states together in drives with neither odometry nor measured poses",
            "type": ["object", "null"],
            "additionalProperties": false,
            "properties": {
              "speed_mps": {"$ref": "#/$defs/positive", "default": 1.0},
              "acceleration_mps2": {"$ref": "#/$defs/positive", "default": 0.5, "description": "change of velocity within a second"},
              "turn_rate_rad_per_s": {"$ref": "#/$defs/positive", "default": 1.0},
              "turn_acceleration_rad_per_s2": {"$ref": "#/$defs/positive", "default": 1.0}
            }
          },
          "receivers": {
            "oneOf": [
              {
                "type": "object",
                "required": ["layout", "side_m", "height_m"],
                "additionalProperties": false,
                "properties": {
                  "layout": {"enum": ["octagon"]},
                  "side_m": {"$ref": "#/$defs/positive", "description": "between neighbours"},
                  "height_m": {"type": "number"},
                  "turn_rad": {"type": "number", "default": 0, "description": "direction of r0 from the vehicle's +x axis"},
                  "sigma_m": {"$ref": "#/$defs/receiver_sigma"}
                }
              },
              {
                "type": "array",
                "items": {
                  "type": "object",
                  "required": ["id", "position_m"],
                  "additionalProperties": false,
                  "properties": {
                    "id": {"$ref": "#/$defs/id"},
                    "position_m": {"$ref": "#/$defs/vector", "description": "in the vehicle frame"},
                    "sigma_m": {"$ref": "#/$defs/receiver_sigma"},
                    "axis": {"$ref": "#/$defs/vector", "description": "direction of hearing"}
                  }
                }
              },
              {"type": "null"}
            ]
          },
          "rail": {"oneOf": [{"$ref": "#/$defs/rail"}, {"type": "null"}]}
        }
      }
    },
    "control": {
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "distances": {
          "type": ["array", "null"],
          "items": {
            "type": "object",
            "required": ["from", "to", "distance_m", "sigma_m"],
            "additionalProperties": false,
            "properties": {
              "from": {"$ref": "#/$defs/id"},
              "to": {"$ref": "#/$defs/id"},
              "distance_m": {"$ref": "#/$defs/positive"},
              "sigma_m": {"$ref": "#/$defs/not_negative"}
            }
          }
        }
      }
    },
    "gates": {
      "description": "what is left out before anything is known of the vehicle; an arrival that fits the final adjustment is used after all",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {
        "min_range_m": {"$ref": "#/$defs/not_negative", "default": 0, "description": "nearer is impossible, and a second signal so close behind the first is its reflection"},
        "max_range_m": {"$ref": "#/$defs/positive", "description": "farther is impossible"},
        "triangle": {"type": "boolean", "default": true, "description": "Kleeman's inequality between two beacons with known places"}
      }
    },
    "scene": {
      "description": "what plans show of the place, for surveys (also in a file of its own: octant schema scene)",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {)json") + std::string(scene_properties()) +
                                  R"json(
      }
    },
    "tolerance": {
      "description": "what the site must reach",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {"beacon_m": {"$ref": "#/$defs/positive"}, "fix_m": {"$ref": "#/$defs/positive"}}
    },
    "validity": {
      "description": "for how long a calibration may be trusted: localize, verify and monitor say when the next one is due",
      "type": ["object", "null"],
      "additionalProperties": false,
      "properties": {"months": {"$ref": "#/$defs/positive"}, "beacon_drift_m_per_month": {"$ref": "#/$defs/positive"}}
    }
  },
  "$defs": {
    "id": {"type": ["string", "number", "boolean"], "description": "taken as it is written"},
    "positive": {"type": "number", "exclusiveMinimum": 0},
    "not_negative": {"type": "number", "minimum": 0},
    "vector": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}},
    "coordinates_or_null": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": ["number", "null"]}},
    "point": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}},
    "rail": {
      "description": "line that the vehicle runs on, its heading along it: straight, or an arc run counter-clockwise",
      "type": "object",
      "oneOf": [{"required": ["from_m", "to_m"]}, {"required": ["centre_m", "radius_m"]}],
      "additionalProperties": false,
      "properties": {
        "from_m": {"$ref": "#/$defs/point"},
        "to_m": {"$ref": "#/$defs/point"},
        "centre_m": {"$ref": "#/$defs/point"},
        "radius_m": {"$ref": "#/$defs/positive"}
      }
    },
    "receiver_sigma": {
      "description": "one for all axes or one each; 0 or absent: held fixed",
      "oneOf": [{"$ref": "#/$defs/not_negative"}, {"$ref": "#/$defs/vector"}]
    },
    "prior": {
      "oneOf": [
        {"$ref": "#/$defs/not_negative"},
        {
          "type": "object",
          "required": ["value", "sigma"],
          "additionalProperties": false,
          "properties": {"value": {"$ref": "#/$defs/not_negative"}, "sigma": {"$ref": "#/$defs/not_negative"}}
        }
      ]
    }
  }
}
)json";
  return text;
}

}  // namespace octant::io

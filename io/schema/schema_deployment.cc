// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view deployment_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:deployment:1",
  "title": "Octant deployment file (deployment.json)",
  "description": "What a localizer needs to know of a calibrated site. SI units, radians, degrees Celsius; map: z up; vehicle: x forward, y left, z up. An arrival's delay is the beacon's plus the receiver's delay_s.",
  "type": "object",
  "required": ["type", "version", "site", "created", "motion", "datum", "medium", "timing", "noise", "attenuation", "beacons", "vehicles",
               "covariance", "statistics", "validity", "inputs", "program"],
  "properties": {
    "type": {"const": "octant_deployment"},
    "version": {"const": 1},
    "site": {"type": "string"},
    "created": {"type": "string", "description": "ISO 8601, UTC"},
    "motion": {"enum": ["planar", "spatial"]},
    "datum": {
      "description": "how position, orientation and scale were fixed",
      "type": "object",
      "properties": {
        "description": {"type": "string"},
        "position": {"type": "string"},
        "orientation": {"type": "string"},
        "scale": {"type": "string"},
        "control_points": {"type": "array", "items": {"type": "string"}}
      }
    },
    "medium": {
      "type": "object",
      "required": ["model", "speed_mps", "sigma_mps", "reference_temperature_degC"],
      "properties": {
        "model": {"enum": ["cramer1993", "linear_temperature", "constant"]},
        "speed_mps": {"$ref": "#/$defs/positive", "description": "calibrated, at the reference temperature: the model's and offset_mps"},
        "sigma_mps": {"$ref": "#/$defs/not_negative"},
        "reference_temperature_degC": {"type": "number"},
        "relative_humidity": {"type": "number"},
        "pressure_pa": {"type": "number"},
        "constant_speed_mps": {"type": "number", "description": "of the constant model, without the offset"},
        "offset_mps": {"type": "number", "description": "added to the model's speed at any temperature"}
      }
    },
    "timing": {
      "type": "object",
      "required": ["clock", "delay_per"],
      "properties": {
        "clock": {"enum": ["synchronised", "cycle_offset"]},
        "ranging": {"enum": ["one_way", "two_way"]},
        "turnaround_s": {"type": "number"},
        "delay_per": {
          "oneOf": [
            {"enum": ["beacon", "receiver", "site", "none"]},
            {"type": "array", "items": {"enum": ["beacon", "receiver", "site"]}}
          ]
        },
        "delay_s": {"type": "number"},
        "delay_sigma_s": {"type": "number"},
        "drift_ppm": {"type": "number"},
        "drift_sigma_ppm": {"type": "number"}
      }
    },
    "noise": {
      "type": "object",
      "required": ["tof_sigma_s"],
      "properties": {
        "tof_sigma_s": {"$ref": "#/$defs/positive"},
        "amplitude_relative_sigma": {"type": "number"},
        "pair_sigma_s": {"type": ["number", "null"]},
        "correlated": {
          "description": "The part of the errors that is not white, as the residuals of the calibration show it; left out where there is none.",
          "type": "object",
          "properties": {
            "sigma_s": {"$ref": "#/$defs/not_negative", "description": "standard deviation of the part that a beacon-receiver pair keeps for about time_s"},
            "time_s": {"$ref": "#/$defs/not_negative", "description": "correlation time: two errors of a pair that lie t apart share exp(-t / time_s) of sigma_s squared"},
            "pair_sigma_s": {"$ref": "#/$defs/not_negative", "description": "standard deviation of the part that a pair keeps for good: it does not average out"}
          }
        },
        "bearing_sigma_rad": {"type": "number"},
        "range_sigma_m": {"type": "number"}
      }
    },
    "attenuation": {
      "description": "null: no time-walk",
      "type": ["object", "null"],
      "required": ["amplitude_1m_v", "absorption_np_per_m", "threshold_v", "rise_time_s"],
      "properties": {
        "amplitude_1m_v": {"$ref": "#/$defs/positive"},
        "absorption_np_per_m": {"type": "number"},
        "threshold_v": {"$ref": "#/$defs/not_negative"},
        "rise_time_s": {"$ref": "#/$defs/not_negative", "description": "time constant of the envelope"},
        "half_power_angle_rad": {"type": ["number", "null"], "exclusiveMinimum": 0, "description": "off a receiver's axis, where the amplitude is 3 dB down; null: all round alike"},
        "saturation_v": {"type": ["number", "null"], "exclusiveMinimum": 0, "description": "logged amplitudes from here on are not used"}
      }
    },
    "beacons": {
      "type": "array",
      "items": {
        "type": "object",
        "required": ["id", "position_m", "covariance_m2", "delay_s", "delay_sigma_s", "status"],
        "properties": {
          "id": {"type": "string", "minLength": 1},
          "position_m": {"$ref": "#/$defs/vector"},
          "covariance_m2": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"$ref": "#/$defs/vector"}},
          "delay_s": {"type": "number"},
          "delay_sigma_s": {"$ref": "#/$defs/not_negative"},
          "gain": {"$ref": "#/$defs/positive", "description": "of its amplitude over the attenuation's, where dirt or age dampen it; 1 where left out"},
          "status": {"enum": ["calibrated", "control_point", "undetermined"], "description": "localizers leave undetermined ones out"}
        }
      }
    },
    "vehicles": {
      "type": "array",
      "minItems": 1,
      "items": {
        "type": "object",
        "required": ["id", "receivers"],
        "properties": {
          "id": {"type": "string", "minLength": 1},
          "clock_drift_ppm": {"type": "number", "description": "cycle_offset: rate of its clock against the beacons', less one"},
          "clock_drift_sigma_ppm": {"type": "number"},
          "motion": {"type": "object", "description": "how it usually moves, as in the site file"},
          "receivers": {
            "type": "array",
            "items": {
              "type": "object",
              "required": ["id", "position_m", "sigma_m", "delay_s"],
              "properties": {
                "id": {"type": "string", "minLength": 1},
                "position_m": {"$ref": "#/$defs/vector", "description": "in the vehicle frame"},
                "sigma_m": {"$ref": "#/$defs/vector"},
                "delay_s": {"type": "number"},
                "delay_sigma_s": {"type": "number"},
                "axis": {"oneOf": [{"$ref": "#/$defs/vector"}, {"type": "null"}]},
                "hearing_cosine": {"type": ["number", "null"]}
              }
            }
          },
          "rail": {"oneOf": [{"$ref": "#/$defs/rail"}, {"type": "null"}]}
        }
      }
    },
    "covariance": {
      "description": "joint covariance of all calibrated parameters, upper triangle row by row; both empty beyond 600 parameters, where each beacon's own has to do",
      "type": "object",
      "required": ["parameters", "upper_triangle"],
      "properties": {
        "parameters": {"type": "array", "items": {"type": "string"}, "examples": [["beacon/B1/x_m", "beacon/B1/delay_s", "medium/speed_mps"]]},
        "upper_triangle": {"type": "array", "items": {"type": "number"}}
      }
    },
    "statistics": {
      "type": "object",
      "required": ["arrivals", "rejected", "unknowns", "redundancy", "variance_factor", "chi2_p", "rms_s", "converged"],
      "properties": {
        "arrivals": {"$ref": "#/$defs/count"},
        "rejected": {"$ref": "#/$defs/count"},
        "unknowns": {"$ref": "#/$defs/count"},
        "redundancy": {"type": "number"},
        "variance_factor": {"type": "number"},
        "chi2_p": {"type": "number", "description": "two-sided p value of the variance factor's chi-square test"},
        "rms_s": {"type": "number"},
        "converged": {"type": "boolean"}
      }
    },
    "tolerance": {
      "type": "object",
      "properties": {"beacon_m": {"type": ["number", "null"]}, "fix_m": {"type": ["number", "null"]}}
    },
    "validity": {
      "type": "object",
      "properties": {
        "temperature_degC": {
          "oneOf": [{"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}, {"type": "null"}]
        },
        "area": {
          "description": "convex hull of the calibrated poses [m], counter-clockwise",
          "type": "array",
          "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
        },
        "reach_m": {"type": "number", "exclusiveMinimum": 0},
        "months": {"type": ["number", "null"]},
        "beacon_drift_m_per_month": {"type": ["number", "null"]},
        "until": {"type": ["string", "null"]}
      }
    },
    "inputs": {
      "type": "array",
      "items": {
        "type": "object",
        "required": ["path", "sha256"],
        "properties": {"path": {"type": "string"}, "sha256": {"type": "string"}}
      }
    },
    "program": {
      "type": "object",
      "properties": {"name": {"type": "string"}, "version": {"type": "string"}, "command": {"type": "string"}}
    },
    "warnings": {"type": "array", "items": {"type": "string"}},
    "previous": {
      "description": "only of a recalibration: the deployment that it was made of, and what had changed since",
      "type": "object",
      "required": ["sha256", "created", "drift", "released", "changes"],
      "properties": {
        "sha256": {"type": "string", "description": "digest of the earlier file"},
        "created": {"type": "string"},
        "drift": {
          "description": "standard deviations by which things may have drifted without being held to have changed",
          "type": "object",
          "required": ["beacon_m", "delay_s", "receiver_m", "speed_mps", "log_gain", "attenuation"],
          "properties": {
            "beacon_m": {"$ref": "#/$defs/not_negative"},
            "delay_s": {"$ref": "#/$defs/not_negative"},
            "receiver_m": {"$ref": "#/$defs/not_negative"},
            "speed_mps": {"$ref": "#/$defs/not_negative"},
            "log_gain": {"$ref": "#/$defs/not_negative", "description": "of each beacon's amplitude, natural logarithm"},
            "attenuation": {"$ref": "#/$defs/not_negative", "description": "of amplitude, absorption and rise time, relative"}
          }
        },
        "released": {"type": "array", "items": {"type": "string"}, "description": "parameters of which nothing earlier was believed"},
        "changes": {
          "type": "array",
          "items": {
            "type": "object",
            "required": ["kind", "subject", "size", "sigma", "unit", "p"],
            "properties": {
              "kind": {"enum": ["beacon_moved", "delay", "receiver", "speed", "exchanged", "datum", "amplitude"]},
              "subject": {"type": "string", "examples": ["B3", "robot/r0", "B2, B5", "speed"]},
              "size": {"type": "number", "description": "length of a move; new less old of a delay or the speed; factor of an amplitude"},
              "sigma": {"$ref": "#/$defs/not_negative"},
              "unit": {"enum": ["m", "s", "m/s", "1"]},
              "p": {"$ref": "#/$defs/not_negative", "description": "of chance, after all that was tested"}
            }
          }
        }
      }
    },
    "verdict": {
      "description": "only of a calibration that was exported with --accept although its data contradict what its site file states",
      "type": "object",
      "required": ["grade", "contradictions"],
      "properties": {
        "grade": {"const": "Contradicted"},
        "contradictions": {
          "type": "array",
          "minItems": 1,
          "items": {
            "type": "object",
            "required": ["kind", "subject", "stated", "found", "sigmas", "remedy"],
            "properties": {
              "kind": {"enum": ["control_point", "exchanged", "beacon", "speed", "delay", "receiver", "wiring", "attenuation", "distance", "poses",
                                "units", "epochs", "ranging", "repeated", "stop", "log"]},
              "subject": {"type": "string", "examples": ["B3", "robot/fl", "medium"]},
              "stated": {"type": "string"},
              "found": {"type": "string"},
              "sigmas": {"$ref": "#/$defs/not_negative"},
              "remedy": {"type": "string"}
            }
          }
        }
      }
    },
    "digest": {"type": "string", "description": "SHA-256 of the content without this key and signature: keys sorted, no blanks, shortest numbers"},
    "signature": {
      "type": "object", "description": "octant sign: Ed25519 (RFC 8032) of the line 'octant deployment, ed25519, 1', a line feed, and the digest",
      "required": ["algorithm", "public_key", "value"],
      "properties": {
        "algorithm": {"const": "ed25519"},
        "public_key": {"type": "string", "description": "32 bytes, hexadecimal"},
        "value": {"type": "string", "description": "64 bytes, hexadecimal"}
      }
    }
  },
  "$defs": {
    "positive": {"type": "number", "exclusiveMinimum": 0},
    "not_negative": {"type": "number", "minimum": 0},
    "count": {"type": "integer", "minimum": 0},
    "vector": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}},
    "point": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}},
    "rail": {
      "description": "line that the vehicle runs on, its heading along it: straight, or an arc run counter-clockwise",
      "type": "object",
      "oneOf": [{"required": ["from_m", "to_m"]}, {"required": ["centre_m", "radius_m"]}],
      "properties": {
        "from_m": {"$ref": "#/$defs/point"},
        "to_m": {"$ref": "#/$defs/point"},
        "centre_m": {"$ref": "#/$defs/point"},
        "radius_m": {"$ref": "#/$defs/positive"}
      }
    }
  }
}
)json";
}

}  // namespace octant::io

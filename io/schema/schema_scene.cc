// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

// Without references, as it stands within the site's schema too.
std::string_view scene_properties() {
  return R"json(
        "floor_m": {"description": "outline, corners in order; left out: the calibrated area, else the beacons' hull", "type": ["array", "null"],
          "minItems": 3, "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}},
        "walls": {"description": "polylines that stop sound", "type": ["array", "null"], "items": {
          "type": "object", "required": ["points_m"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"]},
            "points_m": {"type": "array", "minItems": 2, "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}},
            "bottom_m": {"type": "number", "default": 0}, "top_m": {"type": "number", "description": "left out: no end"}}}},
        "obstacles": {"description": "closed polygons, solid within", "type": ["array", "null"], "items": {
          "type": "object", "required": ["points_m"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"]},
            "points_m": {"type": "array", "minItems": 3, "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}},
            "bottom_m": {"type": "number", "default": 0}, "top_m": {"type": "number", "description": "left out: no end"},
            "blocks_sound": {"type": "boolean", "default": true}, "blocks_vehicle": {"type": "boolean", "default": true}}}},
        "mounts": {"description": "where beacons may be mounted: along a wall, within a ceiling's polygon, at a pole's one point", "type": ["array", "null"], "items": {
          "type": "object", "required": ["kind", "points_m", "height_m"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"]},
            "kind": {"enum": ["wall", "ceiling", "pole"]},
            "points_m": {"type": "array", "minItems": 1, "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}},
            "height_m": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}, "description": "lowest, highest"},
            "axis": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"},
              "description": "left out: walls look to the left of their polyline, ceilings down, poles all round"}}}},
        "patterns": {"description": "gain of the amplitude by the angle off the axis", "type": ["array", "null"], "items": {
          "type": "object", "required": ["id", "kind"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"]},
            "kind": {"enum": ["cone", "cosine_power", "half_power", "table"]},
            "half_angle_rad": {"type": "number", "exclusiveMinimum": 0},
            "exponent": {"type": "number", "minimum": 0},
            "half_power_angle_rad": {"type": "number", "minimum": 0.02, "maximum": 2.8, "description": "of half_power: off the axis, 3 dB down"},
            "angle_rad": {"type": "array", "items": {"type": "number", "minimum": 0}, "description": "of a table, rising from 0"},
            "gain": {"type": "array", "items": {"type": "number", "minimum": 0, "maximum": 1}}}}},
        "beacon_pattern": {"type": "string", "description": "of all beacons that name none; each needs an axis then"},
        "receiver_pattern": {"type": "string", "description": "of all receivers with an axis; left out: what calibration has seen, else 101 degrees"},
        "beacons": {"type": ["array", "null"], "items": {
          "type": "object", "required": ["id"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"], "description": "of a beacon of the site"},
            "axis": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "description": "in the map"},
            "pattern": {"type": "string"}}}},
        "routes": {"description": "along which vehicles drive", "type": ["array", "null"], "items": {
          "type": "object", "required": ["points_m"], "additionalProperties": false, "properties": {
            "id": {"type": ["string", "number"]},
            "points_m": {"type": "array", "minItems": 2, "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}}}}},
        "acoustics": {"type": ["object", "null"], "additionalProperties": false, "properties": {
          "frequency_hz": {"type": "number", "exclusiveMinimum": 0, "description": "with it the absorption is ISO 9613-1's in the site's medium"},
          "absorption_np_per_m": {"type": "number", "minimum": 0, "description": "goes before the standard's"},
          "amplitude_1m_v": {"type": "number", "exclusiveMinimum": 0, "description": "left out: the site's attenuation's"},
          "threshold_v": {"type": "number", "exclusiveMinimum": 0},
          "range_m": {"type": "number", "exclusiveMinimum": 0, "description": "never heard beyond"}}},
        "noise": {"description": "sigma^2 = (c noise.tof_sigma_s)^2 + (sigma_m_per_m d)^2 + sigma_m_per_sqrt_m^2 d", "type": ["object", "null"],
          "additionalProperties": false, "properties": {
            "sigma_m_per_m": {"type": "number", "minimum": 0, "default": 0}, "sigma_m_per_sqrt_m": {"type": "number", "minimum": 0, "default": 0}}},
        "cell_m": {"type": "number", "exclusiveMinimum": 0, "default": 0.25},
        "headings": {"type": "integer", "minimum": 1, "maximum": 360, "default": 1, "description": "looked at in each cell, evenly from 0; the worst counts"},
        "vehicle_z_m": {"type": "number", "default": 0, "description": "spatial motion only"},
        "temperature_error_degC": {"type": "number", "default": 5, "description": "what-if: the air is warmer by this and nobody says so"},
        "coverage": {"type": "integer", "minimum": 0, "default": 0, "description": "beacons that a cell should hear; 0: one more than a fix needs"},
        "import": {"description": "plans, beside this file", "type": ["array", "null"], "items": {
          "type": "object", "additionalProperties": false, "properties": {
            "dxf": {"type": "string", "description": "ASCII DXF: LINE, LWPOLYLINE, POLYLINE"},
            "ros_map": {"type": "string", "description": "map_server's YAML file; occupied cells stop sound and vehicles, unknown ones vehicles"},
            "unit_m": {"type": "number", "exclusiveMinimum": 0, "description": "of a DXF; left out: its $INSUNITS"},
            "layers": {"type": "array", "items": {"type": "string"}, "description": "of a DXF's walls; left out: all"},
            "obstacle_layers": {"type": "array", "items": {"type": "string"}, "description": "whose closed polylines are solid"},
            "floor_layer": {"type": "string", "description": "whose polyline is the floor's outline"},
            "bottom_m": {"type": "number", "default": 0}, "top_m": {"type": "number"}}}})json";
}

std::string_view scene_schema() {
  static const std::string text = std::string(R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:scene:1",
  "title": "Octant scene file",
  "description": "What plans show of a place: floor, walls, patterns, routes, how far one hears. Also as `scene:` in a site file. SI units, radians; map: z up.",
  "type": "object",
  "required": ["octant_scene"],
  "additionalProperties": false,
  "properties": {
        "octant_scene": {"const": 1, "description": "version of the format"},)json") +
                                  std::string(scene_properties()) + "\n  }\n}\n";
  return text;
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view batch_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:batch:1",
  "title": "Octant list of sites (octant batch)",
  "description": "Sites to calibrate in one go. Paths that are not absolute begin at the folder of the list, those to write at octant batch -o where it is given.",
  "type": "object",
  "required": ["octant_batch", "sites"],
  "additionalProperties": false,
  "properties": {
    "octant_batch": {"const": 1, "description": "version of the format"},
    "sites": {
      "type": "array",
      "minItems": 1,
      "items": {
        "type": "object",
        "required": ["site", "runs", "output"],
        "additionalProperties": false,
        "properties": {
          "name": {"type": ["string", "number", "boolean"], "description": "in messages; the site file where it is left out"},
          "site": {"type": "string", "description": "site file"},
          "runs": {"type": "array", "minItems": 1, "items": {"type": "string"}, "description": "run folders"},
          "output": {"type": "string", "description": "deployment file to write; no two sites write the same file"},
          "report": {"type": "string", "description": "report to write, one HTML page"}
        }
      }
    }
  }
}
)json";
}

}  // namespace octant::io

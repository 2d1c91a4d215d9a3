// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view fixes_schema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "$id": "urn:octant:schema:fixes:1",
  "title": "Octant fixes (octant localize -o fixes.tum --csv fixes.csv)",
  "description": "Where the vehicle was: two files of text, whose columns x-files lists. Neither has keys.",
  "type": "object",
  "x-files": {
    "fixes.csv": {
      "description": "a row for each epoch or instant, fix or no fix; RFC 4180, decimal point",
      "columns": {
        "time_s": "an instant within the epoch, on the clock of the recording",
        "vehicle": "whose fix it is",
        "x_m": "of the vehicle in the map; empty: no fix",
        "y_m": "of the vehicle in the map; empty: no fix",
        "z_m": "of the vehicle in the map; empty: no fix",
        "heading_rad": "counter-clockwise from +x of the map; empty: no fix",
        "sigma_x_m": "standard deviation of x_m, the calibration's part included; empty: not known",
        "sigma_y_m": "standard deviation of y_m, the calibration's part included; empty: not known",
        "sigma_heading_rad": "standard deviation of heading_rad; empty: not known",
        "protection_level_m": "bound that the error in the plane exceeds only once in very many times, undetected echoes included; empty: not told",
        "arrivals_used": "arrivals that the fix was made of",
        "arrivals_rejected": "arrivals that did not agree with it, or are no measurement",
        "status": "ok, or why there is no fix: too_few_arrivals, poor_geometry, ambiguous, no_consensus, not_converged",
        "integrity": "ok: the error is bounded by protection_level_m; degraded: a fix whose error nothing bounds; no_fix",
        "integrity_reason": "of a degraded fix not_protected or beacon_fault, of none its status; empty: ok"
      }
    },
    "fixes.tum": {
      "description": "fixes alone, for tools that read trajectories (evo): a row each, separated by blanks; # begins a comment",
      "columns": {
        "time_s": "an instant within the epoch",
        "x y z": "of the vehicle in the map, metres",
        "qx qy qz qw": "its rotation as a quaternion"
      }
    }
  }
}
)json";
}

}  // namespace octant::io

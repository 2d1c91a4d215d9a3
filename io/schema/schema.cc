// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include "io/schema/schema_scenario.h"
#include "io/schema/schema_texts.h"

namespace octant::io {

std::string_view schema(std::string_view format) {
  if (format == "site") return site_schema();
  if (format == "run") return run_schema();
  if (format == "deployment") return deployment_schema();
  if (format == "scenario") return scenario_schema();
  if (format == "batch") return batch_schema();
  if (format == "scene") return scene_schema();
  if (format == "live") return live_schema();
  if (format == "fixes") return fixes_schema();
  if (format == "survey") return survey_schema();
  if (format == "columns") return columns_schema();
  if (format == "topics") return topics_schema();
  if (format == "defaults") return defaults_schema();
  return {};
}

}  // namespace octant::io

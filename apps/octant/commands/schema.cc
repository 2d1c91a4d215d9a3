// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <memory>

#include <fmt/format.h>

#include "apps/octant/commands.h"

namespace octant::app {

void add_schema(CLI::App& app, CommonOptions& common, Action& action) {
  auto format = std::make_shared<std::string>();
  CLI::App* command = add_command(app, common, "schema", "Print the JSON Schema of a file format",
                                  "octant schema deployment > deployment.schema.json");
  command->add_option("format", *format, "site, run, deployment, scenario, scene, batch or live")
      ->required()
      ->check(CLI::IsMember({"site", "run", "deployment", "scenario", "scene", "batch", "live"}))
      ->type_name("FORMAT");
  command->callback([format, &action] {
    action = [format](Session& session) {
      // It is one JSON object already, so --json changes nothing.
      return session.finish_document(fmt::format("{}\n", io::schema(*format)));
    };
  });
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_words.h"

#include <memory>

#include "apps/octant/commands.h"

namespace octant::app {

void add_schema(CLI::App& app, CommonOptions& common, Action& action) {
  auto format = std::make_shared<std::string>();
  auto page = std::make_shared<bool>(false);
  CLI::App* command =
      add_command(app, common, "schema", "Print the JSON Schema of a file format, with a word on every key",
                  "octant schema deployment > deployment.schema.json");
  command->add_option("format", *format, "site, run, deployment, fixes, scenario, scene, batch or live")
      ->required()
      ->check(CLI::IsMember({"site", "run", "deployment", "scenario", "scene", "batch", "live", "fixes"}))
      ->type_name("FORMAT");
  command->add_flag("--page", *page, "Instead: a page of Markdown, a row for each key and column");
  command->callback([format, page, &action] {
    action = [format, page](Session& session) {
      if (*page && session.options.json)
        return session.fail(
            {"error", "usage", kUsage, "--page is no JSON", "leave out one of --page and --json"});
      if (*page) return session.finish_document(io::schema_page(*format));
      // It is one JSON object already, so --json changes nothing.
      return session.finish_document(io::schema_with_words(*format));
    };
  });
}

}  // namespace octant::app

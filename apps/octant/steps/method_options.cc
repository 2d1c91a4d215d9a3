// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/method_options.h"

#include <map>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "apps/octant/options.h"
#include "apps/octant/session.h"
#include "apps/octant/text/layout.h"
#include "io/run/run_folder.h"
#include "io/text/text.h"

namespace octant::app {

MethodInput method_input(const MethodArgs& args, const Deployment& deployment) {
  MethodInput input;
  input.kleeman_heading = args.heading;
  if (args.map.empty()) return input;
  input.line_map =
      need(build_line_map(need(io::read_run(args.map, names_of(deployment), deployment.timing))));
  return input;
}

void add_method_options(CLI::App& command, MethodArgs& args) {
  const std::string listed = joined(method_names(), ", ", [](const auto& method) { return method.first; });
  command
      .add_option_function<std::string>(
          "--method",
          [&args, listed](const std::string& wanted) {
            const std::string lower = io::lower_case(wanted);
            for (const auto& [name, value] : method_names())
              if (name == lower) return void(args.method = value);
            throw CLI::ValidationError("--method",
                                       "there is no method '" + wanted + "'; expected one of " + listed);
          },
          "One of " + listed + "; auto takes what deployment and log allow, and says so")
      ->type_name("M");
  add_option(command, "--map", args.map, "RUN",
             "line_map: a run with scans and measured poses, from which the map is made");
  const std::map<std::string, KleemanHeading> headings = {{"mean_axes", KleemanHeading::kMeanAxes},
                                                          {"hearing", KleemanHeading::kHearing},
                                                          {"interpolation", KleemanHeading::kInterpolation}};
  add_option(command, "--heading", args.heading, "H",
             "kleeman: from which receivers hear, averaged as published (mean_axes) or, with which are "
             "louder, as sectors (hearing), "
             "or from differences of arrival times and amplitudes (interpolation, the default)")
      ->transform(CLI::CheckedTransformer(headings, CLI::ignore_case).description(""));
}

}  // namespace octant::app

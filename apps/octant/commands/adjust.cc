// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/commands.h"
#include "apps/octant/outputs.h"
#include "apps/octant/text/network_text.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct AdjustArgs {
  std::string network, output;
};

int fail_adjustment(const char* status, Exit exit, std::string message, std::string advice,
                    Session& session) {
  return session.fail({.status = status,
                       .code = status,
                       .exit = exit,
                       .message = std::move(message),
                       .advice = std::move(advice)});
}

int adjust(const AdjustArgs& args, Session& session) {
  check_outputs({args.network}, {{"-o", args.output}}, session);
  AdjustedNetwork adjusted{need(io::read_gama(args.network)), {}};
  session.warn(adjusted.file.warnings);
  adjusted.solved =
      need(calib::solve_network(std::move(adjusted.file.network),
                                {.adjustment = {.sigma_unit = adjusted.file.sigma_unit,
                                                .sigmas_a_posteriori = adjusted.file.sigmas_a_posteriori,
                                                .datum_follows = adjusted.file.datum_follows},
                                 .outlier_limit_m = adjusted.file.outlier_limit_m}),
           args.network);
  const calib::SolvedNetwork& solved = adjusted.solved;
  session.warn(left_out_in_words(adjusted));
  if (solved.solution.status == calib::NetworkStatus::kUndetermined && solved.undetermined.empty())
    return fail_adjustment(
        "undetermined", kUndetermined,
        fmt::format("The observations do not locate {}.", fmt::join(solved.unlocated, ", ")),
        "give approximate coordinates in <point>, or add observations to located points", session);
  if (solved.solution.status == calib::NetworkStatus::kUndetermined)
    return fail_adjustment(
        "undetermined", kUndetermined,
        fmt::format("The observations and the datum do not determine {}.",
                    fmt::join(solved.undetermined, ", ")),
        "fix points, mark datum points with capital letters (adj=\"XY\"), or add observations", session);
  if (solved.solution.status == calib::NetworkStatus::kNotConverged)
    return fail_adjustment(
        "not_converged", kNotConverged,
        fmt::format("The adjustment did not converge in {} iterations.", solved.solution.iterations),
        "check the approximate coordinates and the observations for blunders", session);
  session.warn(suspicious_observations(adjusted));
  const Json object = network_json(adjusted);
  if (!args.output.empty()) need(io::write_file(args.output, object.dump(2) + "\n"));
  session.result(network_text(adjusted, session.options.verbose > 0));
  return session.finish(object);
}

}  // namespace

void add_adjust(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<AdjustArgs>(
      app, common, action, "adjust", "Adjust a survey network: directions, angles, distances, heights",
      "octant adjust network.gkf -o network.json", adjust);
  add_required_option(*command, "network", args->network, "NET.gkf",
                      "Network, in the XML format of GNU Gama");
  add_option(*command, "-o,--output", args->output, "RESULT.json",
             "Coordinates, covariance and residuals to write; - is standard output");
}

}  // namespace octant::app

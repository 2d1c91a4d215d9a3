// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/text/network_text.h"
#include "calib/network/range_network.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "io/tof/run_parts.h"
#include "models/network/unweighted_ranges.h"

namespace octant::app {
namespace {

struct AdjustArgs {
  std::string network, output;
  std::vector<std::string> runs;
};

int fail_adjustment(const char* status, Exit exit, std::string message, std::string advice,
                    Session& session) {
  return session.fail({.status = status,
                       .code = status,
                       .exit = exit,
                       .message = std::move(message),
                       .advice = std::move(advice)});
}

AdjustedNetwork solved_network(const std::string& path, Session& session) {
  AdjustedNetwork adjusted{need(io::read_network(path)), {}};
  const io::NetworkFile& file = adjusted.file;
  session.warn(file.warnings);
  adjusted.solved =
      need(calib::solve_network(file.network, {.adjustment = {.sigma_unit = file.sigma_unit,
                                                              .sigmas_a_posteriori = file.sigmas_a_posteriori,
                                                              .datum_follows = file.datum_follows},
                                               .outlier_limit_m = file.outlier_limit_m}),
           path);
  return adjusted;
}

/// Recordings with the temperature of their run.yaml alone.
std::vector<MeasurementLog> temperatures_of(const std::vector<std::string>& folders) {
  std::vector<MeasurementLog> runs(folders.size());
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const std::filesystem::path file = std::filesystem::path(folders[i]) / "run.yaml";
    std::error_code status;
    if (!std::filesystem::exists(file, status)) continue;
    need(io::parse_run_yaml(need(io::read_document(file.string())), file.string(), runs[i]));
  }
  return runs;
}

/// Beacons of a site from the ranges between them in recordings.
AdjustedNetwork solved_ranges(const AdjustArgs& args, Session& session) {
  const Site site = need(io::read_site(args.network));
  session.warn(site.warnings);
  const std::vector<BeaconFlight> flights = read_beacon_flights(args.runs, names_of(site), session).flights;
  calib::SolvedRangeNetwork ranges =
      need(calib::solve_range_network(site, unweighted_ranges(site, flights, temperatures_of(args.runs))));
  if (ranges.mirror_is_equal)
    session.warn(
        "The mirror image of the result agrees equally well with the ranges: give approximate positions "
        "of at least three beacons that are not in line (four in space).");
  if (!ranges.ambiguous.empty())
    session.warn(
        fmt::format("Beacons left out because another position agrees equally well with the ranges (their "
                    "mirror image behind their neighbours, or another range is wrong than the one left out): "
                    "{}. Give their approximate positions with sigmas, or add ranges.",
                    fmt::join(ranges.ambiguous, ", ")));
  AdjustedNetwork adjusted{{}, std::move(ranges.solved)};
  adjusted.file.description = site.name;
  adjusted.file.sigma_unit = 1.0;
  adjusted.file.sigmas_a_posteriori = false;
  adjusted.file.outlier_limit_m = 0.0;
  return adjusted;
}

int undetermined_network(const calib::SolvedNetwork& solved, bool ranges, Session& session) {
  const bool unlocated = solved.undetermined.empty();
  const std::vector<std::string>& names = unlocated ? solved.unlocated : solved.undetermined;
  const std::string message =
      names.empty() ? "The observations and the datum do not determine any point."
                    : fmt::format("The observations {} {}.",
                                  unlocated ? "do not locate" : "and the datum do not determine",
                                  fmt::join(names, ", "));
  const char* advice = "fix points, mark datum points (datum: xy; in XML adj=\"XY\"), or add observations";
  if (ranges)
    advice = "give positions of beacons in the site file, or add ranges between more pairs of beacons";
  else if (unlocated)
    advice = "give approximate coordinates of a point, or add observations to located points";
  return fail_adjustment("undetermined", kUndetermined, message, advice, session);
}

int adjust(const AdjustArgs& args, Session& session) {
  std::vector<std::string> inputs = args.runs;
  inputs.push_back(args.network);
  check_outputs(inputs, {{"-o", args.output}}, session);
  std::optional<ExitAtOnce> nothing_written_yet(std::in_place);
  const AdjustedNetwork adjusted =
      args.runs.empty() ? solved_network(args.network, session) : solved_ranges(args, session);
  nothing_written_yet.reset();
  const calib::SolvedNetwork& solved = adjusted.solved;
  session.warn(left_out_in_words(adjusted));
  if (solved.solution.status == calib::NetworkStatus::kUndetermined)
    return undetermined_network(solved, !args.runs.empty(), session);
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
      app, common, action, "adjust",
      "Adjust a survey network, or the ranges between the beacons of a site, without a vehicle",
      "octant adjust survey.yaml -o network.json", adjust);
  add_required_option(*command, "network", args->network, "NETWORK",
                      "Network: survey.yaml, or the XML format of GNU Gama; with recordings: the site file");
  add_option(*command, "run", args->runs, "RUN", "Run folders with ranges between beacons (beacon_tof.csv)");
  add_option(*command, "-o,--output", args->output, "RESULT.json",
             "Coordinates, covariance and residuals to write; - is standard output");
}

}  // namespace octant::app

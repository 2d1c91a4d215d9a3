// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/exchange/firmware.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/deployment/deployment_json.h"
#include "io/export/exported.h"
#include "io/run/run_folder.h"
#include "io/run/run_ids.h"
#include "io/run/tum.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct ExportArgs {
  std::vector<std::string> inputs;
  std::string output, origin, c_folder;
  double north_deg = 90.0;
  FirmwareOptions firmware;
};

/// Context for reading a run: names, clock, and the speed of a medium with constant speed.
struct RunContext {
  NameTable names;
  Timing timing;
  double constant_speed_mps = 0.0;
};

enum class InputKind { kRun, kDeployment, kSite, kFixes };

InputKind kind_of_input(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return InputKind::kRun;
  if (path.ends_with(".json")) return InputKind::kDeployment;
  return path.ends_with(".yaml") || path.ends_with(".yml") ? InputKind::kSite : InputKind::kFixes;
}

void add_deployment(const std::string& path, io::ExportedContent& content,
                    std::optional<RunContext>& context) {
  const Deployment deployment = need(io::read_deployment(path));
  content.site = deployment.site;
  for (const DeploymentBeacon& b : deployment.beacons)
    if (b.status != BeaconStatus::kUndetermined)
      content.beacons.push_back(
          {b.name, b.position_m, std::sqrt(std::max({b.covariance_m2(0, 0), b.covariance_m2(1, 1), 0.0}))});
  context = RunContext{names_of(deployment), deployment.timing, constant_speed_mps(deployment.medium)};
}

void add_site(const std::string& path, io::ExportedContent& content, std::optional<RunContext>& context,
              Session& session) {
  const Site site = need(io::read_site(path));
  session.warn(site.warnings);
  content.site = site.name;
  for (const SiteBeacon& b : site.beacons)
    if (b.position_m[0] && b.position_m[1] && b.position_m[2])
      content.beacons.push_back({b.name, {*b.position_m[0], *b.position_m[1], *b.position_m[2]}, 0.0});
  context = RunContext{names_of(site), site.timing, constant_speed_mps(site.medium)};
}

/// Names from the run itself, if neither site nor deployment is given.
RunContext context_of_run(const std::string& folder) {
  const io::RunIds ids = need(io::read_run_ids(folder));
  RunContext context;
  context.names.beacons = ids.beacons;
  for (const auto& vehicle : ids.vehicles) {
    const VehicleId id(context.names.vehicles.size());
    context.names.vehicles.push_back(vehicle.name);
    for (const std::string& receiver : vehicle.receivers) context.names.receivers.push_back({receiver, id});
    if (vehicle.receivers.empty()) context.names.receivers.push_back({"r0", id});
  }
  return context;
}

void add_run(const std::string& folder, const std::optional<RunContext>& known, io::ExportedContent& content,
             Session& session) {
  const RunContext context = known ? *known : context_of_run(folder);
  MeasurementLog log =
      need(io::read_run(folder, context.names, context.timing,
                        {.read_truth = true, .constant_speed_mps = context.constant_speed_mps}));
  session.warn(log.warnings);
  if (!log.bearings.empty() || !log.scans.empty())
    session.warn(folder + ": bearings and scans are not exported");
  content.runs.push_back({std::move(log), context.names});
}

/// All fixes and references as one trajectory.
std::string to_tum(const io::ExportedContent& content) {
  std::vector<TimedPose> poses;
  for (const auto& track : content.tracks)
    for (const Fix& fix : track.fixes)
      if (fix.ok()) poses.push_back({fix.time_s, fix.T_map_vehicle});
  if (poses.empty())
    for (const auto& run : content.runs) {
      const auto& track = run.log.truth.empty() ? run.log.poses : run.log.truth;
      poses.insert(poses.end(), track.begin(), track.end());
    }
  std::ranges::stable_sort(poses, {}, &TimedPose::time_s);
  // TUM files have one pose for each time.
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const TimedPose& a, const TimedPose& b) { return a.time_s == b.time_s; }),
              poses.end());
  if (!poses.empty()) return io::poses_to_tum(poses);
  fail_with({.code = Errc::kUsage,
             .found = "no fix and no pose to make a trajectory of",
             .expected = "fixes (.csv, .tum) or a run with poses or truth"});
}

/// Writes the sources of the firmware edition with the tables of a deployment.
int run_firmware(const ExportArgs& args, Session& session) {
  if (!args.output.empty() || args.inputs.size() != 1)
    fail_usage("--c needs one deployment and no -o", "write octant export DEPLOYMENT.json --c DIR");
  std::vector<std::string> outputs;
  for (const char* name : {"octant_fix.h", "octant_fix.c", "octant_site.h", "octant_site.c"})
    outputs.push_back((std::filesystem::path(args.c_folder) / name).string());
  check_no_overwriting({.inputs = args.inputs, .outputs = outputs});
  const Deployment deployment = need(io::read_deployment(args.inputs.front()));
  std::size_t bytes = 0;
  std::error_code error;
  const auto files = need(firmware_files(deployment, args.firmware));
  std::filesystem::create_directories(args.c_folder, error);
  if (error) fail_output(args.c_folder, error.message());
  for (const FirmwareFile& file : files) {
    need(io::write_file((std::filesystem::path(args.c_folder) / file.name).string(), file.text));
    bytes += file.text.size();
  }
  session.result(
      fmt::format("{:<17}{}: octant_fix.c, octant_fix.h, octant_site.c, octant_site.h for {} beacons\n",
                  "written", args.c_folder, deployment.beacons.size()));
  return session.finish(
      {{"output", args.c_folder}, {"beacons", deployment.beacons.size()}, {"bytes", bytes}});
}

int run(const ExportArgs& args, Session& session) {
  if (!args.c_folder.empty()) return run_firmware(args, session);
  if (args.output.empty()) fail_usage("-o or --c is required", "state what to write");
  check_no_overwriting({.inputs = args.inputs, .outputs = {args.output}});
  const bool mcap = args.output.ends_with(".mcap"), geojson = args.output.ends_with(".geojson"),
             tum = args.output.ends_with(".tum");
  if (!mcap && !geojson && !tum)
    fail_with({.code = Errc::kUsage,
               .found = "-o " + args.output,
               .expected = "a name in .mcap, .geojson or .tum, which says what to write"});
  io::EarthOrigin origin;
  if (geojson) origin = need(io::origin_from_words(args.origin, args.north_deg));
  io::ExportedContent content;
  std::optional<RunContext> context;
  for (const std::string& path : args.inputs) {
    const InputKind kind = kind_of_input(path);
    if (kind == InputKind::kSite) add_site(path, content, context, session);
    if (kind == InputKind::kDeployment) add_deployment(path, content, context);
  }
  for (const std::string& path : args.inputs) {
    const InputKind kind = kind_of_input(path);
    if (kind == InputKind::kRun) add_run(path, context, content, session);
    if (kind == InputKind::kFixes) content.tracks.push_back(need(io::read_fixes(path)));
  }
  const std::string text = mcap      ? need(io::to_mcap(content))
                           : geojson ? io::to_geojson(content, origin)
                                     : to_tum(content);
  need(io::write_file(args.output, text));
  std::size_t arrivals = 0, fixes = 0;
  for (const auto& run : content.runs) arrivals += run.log.arrivals.size();
  for (const auto& track : content.tracks) fixes += track.fixes.size();
  session.result(fmt::format("{:<17}{}: {} beacons, {} arrivals, {} fixes\n", "written", args.output,
                             content.beacons.size(), arrivals, fixes));
  return session.finish({{"output", args.output},
                         {"beacons", content.beacons.size()},
                         {"arrivals", arrivals},
                         {"fixes", fixes},
                         {"bytes", text.size()}});
}

}  // namespace

void add_export(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] =
      add_command<ExportArgs>(app, common, action, "export",
                              "Write runs, fixes and beacons for other programs: MCAP, GeoJSON, TUM, C",
                              "octant export hall/deployment.json hall/run hall/fixes.csv -o hall.mcap", run);
  add_required_option(
      *command, "inputs", args->inputs, "INPUT",
      "Deployment (.json) or site file (.yaml), run folders, fixes (fixes.csv or a .tum trajectory)");
  add_option(*command, "-o,--output", args->output, "OUT",
             "What to write: NAME.mcap (Foxglove, PlotJuggler; octant convert reads it again), "
             "NAME.geojson (maps, WGS 84) or NAME.tum (evo)");
  add_option(*command, "--origin", args->origin, "PLACE",
             "geojson: where the map's origin is, LATITUDE,LONGITUDE[,ALTITUDE] in degrees and metres");
  add_option(*command, "--c", args->c_folder, "DIR",
             "write C sources for a microcontroller, with the deployment as a table (no -o)");
  command->add_flag("--float", args->firmware.single_precision, "c: single precision");
  add_option(*command, "--vehicle", args->firmware.vehicle, "NAME", "c: vehicle that the firmware is for");
  command
      ->add_option("--north-deg", args->north_deg,
                   "geojson: direction of north in the map, counter-clockwise from +x [deg]")
      ->capture_default_str();
  for (const char* option : {"--origin", "--north-deg"}) command->get_option(option)->excludes("--c");
  for (const char* option : {"--float", "--vehicle"}) command->get_option(option)->needs("--c");
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <random>

#include <fmt/format.h>

#include "apps/octant/cockpit/commissioning.h"
#include "apps/octant/cockpit/web_server.h"
#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "io/deployment/deployment_json.h"
#include "io/run/run_files.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::app {
namespace {

struct CockpitArgs {
  std::string input, source = "stdin", run, listen = "127.0.0.1:8740", token, run_yaml;
  double speed = 1.0, lateness_s = 0.2;
  bool finish = false, accept = false;
};

/// A site file or, as JSON without octant_site, a deployment.
CommissioningInput read_cockpit_input(const CockpitArgs& args, Session& session) {
  CommissioningInput input;
  input.path = args.input;
  input.lateness_s = args.lateness_s;
  if (args.input.empty()) return input;
  const std::string text = need(io::read_document(args.input));
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && text[first] == '{' && text.find("\"octant_site\"") == std::string::npos) {
    input.deployment = need(io::deployment_from_json(text, args.input));
  } else {
    input.site = need(io::read_site(args.input));
    session.warn(input.site->warnings);
  }
  return input;
}

/// Name of a new run folder from the local time.
std::string run_by_time() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char text[32];
  return std::string(text, std::strftime(text, sizeof text, "run-%Y%m%d-%H%M%S", &local));
}

/// The run is written row by row, so it must be a new folder.
void check_run_folder(const std::string& run) {
  std::error_code missing;
  if (std::filesystem::exists(run, missing) &&
      !(std::filesystem::is_directory(run, missing) && std::filesystem::is_empty(run, missing)))
    fail_usage(fmt::format("'{}' is there already", run),
               "name a new folder by -o; recordings are not overwritten");
}

std::string random_token() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

/// A secret that cannot be guessed, of characters that an address and a cookie may have.
void check_token(const std::string& token) {
  constexpr std::size_t kFewest = 16;
  const bool is_plain = std::ranges::all_of(
      token, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
  if (token.empty() || token == "new" || (is_plain && token.size() >= kFewest)) return;
  fail_usage("--token is too short or has other characters",
             fmt::format("{} or more of A-Z, a-z, 0-9, _ and -, or new for a random one", kFewest));
}

template <class SiteOrDeployment>
std::unique_ptr<RowSource> open_row_source(const CockpitArgs& args, const SiteOrDeployment& of,
                                           CommissioningInput& input, Session& session) {
  if (!std::filesystem::is_directory(args.source))
    return open_line_source(args.source, names_of(of), constant_speed_mps(of.medium), session);
  auto runs = read_runs({args.source}, of, {.read_poses = false}, session);
  const std::string yaml = args.source + "/run.yaml";
  if (args.run_yaml.empty() && std::filesystem::exists(yaml)) input.run_yaml = need(io::read_file(yaml));
  for (const char* other : {"bearings.csv", "scans.csv", "poses.tum", "points.csv", "beacon_tof.csv"})
    if (std::filesystem::exists(args.source + "/" + other))
      session.warn(fmt::format("{}/{} is not replayed: arrivals and odometry are", args.source, other));
  return replay_source(std::move(runs.front()), args.speed);
}

/// Reads the source until a signal or, with --finish, until its end.
int operate(const CockpitArgs& args, RowSource& source, Commissioning& commissioning, const WebServer& server,
            Session& session) {
  bool is_over = false;
  while (!interrupted() && !(args.finish && is_over))
    is_over = commissioning.advance(source) == RowSource::Event::kEnd;
  commissioning.close();
  if (args.finish && !interrupted()) commissioning.finish(args.accept);
  const Json finished = commissioning.finished();
  const RecorderCounts counts = commissioning.counts();
  Json result = {{"url", server.urls().front()},
                 {"run", commissioning.run()},
                 {"arrivals", counts.arrivals},
                 {"odometry_rows", counts.odometry},
                 {"finished", finished}};
  session.result(fmt::format("{:<17}{} ({} arrivals, {} odometry rows)\n", "recording", commissioning.run(),
                             counts.arrivals, counts.odometry));
  if (!finished.is_object()) return session.finish(result);
  if (finished["deployment"].is_string())
    session.result(fmt::format("{:<17}{}\n", "deployment", finished["deployment"].get<std::string>()));
  const auto exit = static_cast<Exit>(finished["exit"].get<int>());
  if (exit == kDone) return session.finish(result);
  const std::string status = finished["status"].get<std::string>();
  return session.fail({status, status, exit, finished["message"].get<std::string>(), ""}, result);
}

int run_cockpit(const CockpitArgs& args, Session& session) {
  session.result_to_stderr();
  CommissioningInput input = read_cockpit_input(args, session);
  input.run = !args.run.empty() || input.deployment ? args.run : run_by_time();
  if (!input.run.empty()) check_run_folder(input.run);
  check_no_overwriting({.inputs = {args.input}, .run_outputs = {input.run}});
  input.run_yaml = args.run_yaml.empty() ? "octant_run: 1\n" : need(io::read_document(args.run_yaml));
  check_token(args.token);
  WebServer listening = need(WebServer::listen(args.listen));
  const std::string token = args.token == "new" ? random_token() : args.token;
  if (!listening.is_loopback() && token.empty())
    fail_usage(fmt::format("--listen {} without --token", args.listen),
               "other machines can reach this address: add --token new, or a secret of your own");
  if (args.input.empty() && std::filesystem::is_directory(args.source))
    fail_usage("a recording is replayed without a site file", "octant init RUN -o SITE.yaml begins one");
  std::unique_ptr<RowSource> source =
      input.site         ? open_row_source(args, Site(*input.site), input, session)
      : input.deployment ? open_row_source(args, Deployment(*input.deployment), input, session)
                         : open_nameless_source(args.source, session);
  const NoExitAtOnce recording;
  std::signal(SIGPIPE, SIG_IGN);
  Commissioning commissioning(std::move(input), session);
  WebServer server(std::move(listening));  // stops before the commissioning that it serves is destroyed
  server.start(
      HttpGuard(token, server.port()),
      [&](const HttpRequest& request) { return commissioning.answer(request); },
      [&] { return commissioning.next_event(); });
  for (const std::string& url : server.urls())
    session.result(fmt::format("{:<17}{}{}\n", "cockpit", url, token.empty() ? "" : "?token=" + token));
  return operate(args, *source, commissioning, server, session);
}

}  // namespace

void add_cockpit(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<CockpitArgs>(
      app, common, action, "cockpit", "Calibrate a site while it is recorded, on a page in the browser",
      "octant cockpit hall/site.yaml --source tcp:7070 -o hall/run2", run_cockpit);
  add_option(*command, "input", args->input, "SITE.yaml|DEPLOYMENT.json",
             "Site file to commission, or a deployment to monitor; without one the page asks for the site");
  add_option(*command, "-o,--output", args->run, "RUN",
             "Run folder to write; without it run-DATE-TIME, or none for a deployment");
  add_option(
      *command, "--source", args->source, "S",
      "Live lines (octant schema live) from stdin, tcp:PORT, udp:PORT or serial:DEVICE[:BAUD], or a run "
      "folder to replay");
  add_option(*command, "--speed", args->speed, "N", "Replay so many times faster than recorded; 0: at once")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  add_option(
      *command, "--listen", args->listen, "ADDRESS:PORT",
      "Address of the page; port 0: any free port. Addresses other than this machine's own need --token");
  add_option(*command, "--token", args->token, "SECRET", "Secret in the page's address; new: a random one");
  add_option(*command, "--lateness", args->lateness_s, "S",
             "Rows may come in any order within so many seconds")
      ->check(CLI::Range(0.0, 10.0));
  add_option(*command, "--run-yaml", args->run_yaml, "RUN.yaml",
             "The run's run.yaml, for example with the accuracy of the odometry");
  command->add_flag("--finish", args->finish,
                    "When the source ends: write site, deployment and report into the run folder, and exit "
                    "as octant calibrate does");
  command->add_flag(
      "--accept", args->accept,
      "With --finish: write the deployment, marked, although the data contradict the site file");
}

}  // namespace octant::app

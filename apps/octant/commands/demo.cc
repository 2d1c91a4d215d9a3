// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"
#include "io/run/tum.h"
#include "io/site/scenario_yaml.h"
#include "io/text/atomic_file.h"
#include "survey/drawing/site_plan.h"

namespace octant::app {
namespace {

/// Largest errors that the bundled hall may have for the demo to pass.
constexpr double kBeaconLimit_m = 0.010, kFixLimit_m = 0.010;

/// Files in the folder of the demo.
struct Places {
  explicit Places(std::string f) : folder(std::move(f)) {}
  std::string folder;
  [[nodiscard]] std::string in(const char* name) const {
    return (std::filesystem::path(folder) / name).string();
  }
  std::string site = in("site.yaml"), run = in("run"), heldout = in("heldout"),
              deployment = in("deployment.json"), fixes = in("fixes.tum"), csv = in("fixes.csv"),
              plan = in("plan.svg"), report = in("report.html");
};

Deployment simulate_hall(const Places& at, Session& session) {
  const World world =
      simulated(need(io::scenario_from_yaml(io::bundled_scenario(), "the bundled scenario")), session);
  write_world(at.folder, world, io::bundled_scenario(),
              {"deployment.json", "fixes.tum", "fixes.csv", "plan.svg", "report.html"});
  session.result(fmt::format(
      "$ octant simulate {} --seed {} -o {}\n{} beacons, {} arrivals to calibrate with, {} held out\n\n",
      at.in("scenario.yaml"), session.options.seed, at.folder, world.site.beacons.size(),
      world.run.arrivals.size(), world.heldout.arrivals.size()));
  return world.truth;
}

struct Checked {
  survey::Evaluation evaluation;
  Localization found;
};

Checked localize_and_verify(const Places& at, Session& session) {
  // Reads the file back, as a robot would.
  const Deployment deployment = need(io::read_deployment(at.deployment));
  const auto runs = read_runs({at.heldout}, deployment, {.read_truth = true, .read_poses = false}, session);
  Checked checked{{}, need(localize_runs(deployment, runs, Method::kAuto))};
  const Localization& found = checked.found;
  need(io::write_file(at.fixes, io::fixes_to_tum(found.fixes)));
  need(io::write_file(at.csv, io::fixes_to_csv(found.fixes, names_of(deployment))));
  session.result(fmt::format("$ octant localize {} {} -o {} --csv {}\n{} fixes, {} times no fix\n\n",
                             at.deployment, at.heldout, at.fixes, at.csv, found.ok, found.no_fix));
  checked.evaluation = verify_fixes(deployment, runs, found);
  session.result(fmt::format("$ octant verify {} {}\n{}\n", at.deployment, at.heldout,
                             evaluation_text(checked.evaluation, found)));
  return checked;
}

/// Checks against the simulated truth, which real sites do not have.
std::vector<survey::Gate> gates_of(const Deployment& found, const Deployment& truth,
                                   const survey::Evaluation& evaluation) {
  double worst_m = 0.0;
  const auto errors = survey::beacon_errors(found, truth);
  for (const auto& beacon : errors) worst_m = std::max(worst_m, beacon.error_m);
  return {{"largest beacon error", kBeaconLimit_m, worst_m, !errors.empty() && worst_m <= kBeaconLimit_m},
          {"fix RMSE", kFixLimit_m, evaluation.position_rmse_m,
           evaluation.matched > 0 && evaluation.position_rmse_m <= kFixLimit_m}};
}

int close(const Places& at, const std::vector<survey::Gate>& gates, Session& session) {
  std::string text = "Against the simulated truth:\n", broken;
  for (const auto& gate : gates) {
    text += fmt::format("  {:<22}{:7.2f} mm   limit {:.0f} mm   {}\n", gate.name, 1e3 * gate.value,
                        1e3 * gate.limit, gate.pass ? "kept" : "NOT KEPT");
    if (!gate.pass)
      broken += (broken.empty() ? "" : "; ") + fmt::format("{} is {:.2f} mm", gate.name, 1e3 * gate.value);
  }
  text += "\nOutputs:\n";
  const std::vector<std::string> outputs = {at.site, at.run,  at.heldout, at.fixes,
                                            at.csv,  at.plan, at.report,  at.deployment};
  for (const auto& path : outputs) text += "  " + path + "\n";
  session.result(text);
  Json object = {{"gates", gates_json(gates)}, {"outputs", outputs}, {"seed", session.options.seed}};
  if (!broken.empty()) return session.fail({"gate_failed", "gate_failed", kGateFailed, broken, ""}, object);
  return session.finish(object);
}

int run(const std::string& folder, Session& session) {
  const Places at(folder);
  const Deployment truth = simulate_hall(at, session);
  const Calibration calibration = calibrate_files(at.site, {at.run}, {}, session);
  if (const auto failure = failure_of(calibration)) return session.fail(*failure);
  need(io::write_deployment(at.deployment, *calibration.deployment));
  session.result(fmt::format("$ octant calibrate {} {} -o {} --report {}\n{}\n", at.site, at.run,
                             at.deployment, at.report,
                             calibration_summary(calibration, report_input(calibration, session))));

  const Checked checked = localize_and_verify(at, session);
  stop_if_interrupted();
  survey::ReportInput report = report_input(calibration, session);
  add_stops(calibration, report);
  add_verification(report, checked.found, checked.evaluation);
  survey::add_geometry(report, session.threads());
  add_words(report);
  need(io::write_file(at.plan, survey::site_plan_svg(report.plan)));
  need(io::write_file(at.report, survey::report_html(report)));
  session.result(verdict_text(report) + "\n");
  return close(at, gates_of(*calibration.deployment, truth, checked.evaluation), session);
}

}  // namespace

void add_demo(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, folder] = add_command<std::string>(
      app, common, action, "demo",
      "Simulate a hall, calibrate it, localize in it, verify against truth, write a report",
      "octant demo -o /tmp/hall", run);
  *folder = "octant-demo";
  add_option(*command, "-o,--output", *folder, "DIR", "Folder to make");
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "apps/octant/commands/plan.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/progress.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/layout.h"
#include "io/site/site_beacons.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "survey/page/proof_sheet.h"

namespace octant::app {
namespace {

/// Largest number of rows in the table of beacon counts.
constexpr std::size_t kProofRows = 12;

struct BeaconPlan {
  survey::Placement placement;
  std::vector<survey::ProofRow> proof;
  bool reached = true;  ///< true if the tolerance is reached
};

survey::PlacementOptions options_of(const PlanArgs& args, ProgressReporter& reporter, Session& session) {
  survey::PlacementOptions o;
  o.goal = survey::placement_goal(args.goal).value_or(o.goal);
  o.global = survey::global_algorithm(args.algorithm).value_or(o.global);
  o.local = survey::local_algorithm(args.local).value_or(o.local);
  o.seed = session.options.seed;
  o.keep = args.keep;
  o.coverage = args.coverage;
  o.evaluations = static_cast<std::size_t>(args.evaluations);
  o.restarts = args.restarts;
  o.threads = session.threads();
  o.on_progress = [&reporter](double fraction) {
    reporter.show("placement", 0, 0.0, fraction);
    return !interrupted();
  };
  return o;
}

BeaconPlan plan_of(const PlanArgs& args, const SurveyInput& input, const survey::PlacementOptions& options) {
  BeaconPlan plan;
  if (args.tolerance_m && !args.beacons) {
    auto smallest = need(survey::smallest_placement(input.model, input.scene, *args.tolerance_m,
                                                    static_cast<std::size_t>(args.most), options));
    plan.placement = std::move(smallest.placement);
    plan.reached = smallest.reached;
  } else {
    plan.placement = need(
        survey::place_beacons(input.model, input.scene, static_cast<std::size_t>(*args.beacons), options));
    plan.reached = !args.tolerance_m || plan.placement.figures.objective_m <= *args.tolerance_m;
  }
  const std::size_t own = plan.placement.beacons.size(),
                    most = std::max<std::size_t>(own, static_cast<std::size_t>(args.proof));
  const std::size_t kept = args.keep ? input.model.beacons.size() : 0;
  for (std::size_t n = std::max(kept + 1, most > kProofRows ? most - kProofRows + 1 : 1);
       args.proof > 0 && n <= most && !plan.placement.interrupted; ++n) {
    if (n < static_cast<std::size_t>(input.model.unknowns.position) && n != own) continue;
    const survey::Placement row =
        n == own ? plan.placement : need(survey::place_beacons(input.model, input.scene, n, options));
    plan.placement.interrupted = plan.placement.interrupted || row.interrupted;
    plan.proof.push_back(survey::proof_row(row));
  }
  if (plan.proof.empty()) plan.proof.push_back(survey::proof_row(plan.placement));
  return plan;
}

Json figures_json(const survey::LayoutFigures& f) {
  return {{"objective_m", f.covers_all() ? Json(f.objective_m) : Json(nullptr)},
          {"worst_m", f.worst_m},
          {"p95_m", f.p95_m},
          {"mean_m", f.mean_m},
          {"covered_fraction", f.covered_fraction}};
}

Json plan_json(const PlanArgs& args, const BeaconPlan& plan, const Session& session) {
  Json beacons = Json::array(), proof = Json::array();
  for (const auto& b : plan.placement.beacons)
    beacons.push_back({{"id", b.beacon.name},
                       {"position_m", b.beacon.p_map_m},
                       {"axis", b.beacon.axis.isZero() ? Json(nullptr) : Json(b.beacon.axis)},
                       {"mount", b.mount.empty() ? Json(nullptr) : Json(b.mount)},
                       {"kept", b.mount.empty()}});
  for (const auto& row : plan.proof)
    proof.push_back({{"beacons", row.beacons},
                     {"plan", figures_json(row.plan)},
                     {"greedy", figures_json(row.greedy)},
                     {"regular", figures_json(row.regular)},
                     {"random", figures_json(row.random)}});
  return {{"plan", "beacons"},
          {"goal", args.goal},
          {"algorithm", args.algorithm},
          {"local", args.local},
          {"seed", session.options.seed},
          {"coverage", args.coverage},
          {"tolerance_m", args.tolerance_m},
          {"reached", plan.reached},
          {"poses", plan.placement.cells},
          {"evaluations", plan.placement.evaluations},
          {"figures", figures_json(plan.placement.figures)},
          {"beacons", beacons},
          {"proof", proof},
          {"seconds", session.seconds()}};
}

std::string figure(const survey::LayoutFigures& f) {
  return f.covers_all() ? length_text(f.objective_m)
                        : fmt::format("{:.1f} % covered", 100 * f.covered_fraction);
}

std::string plan_text(const PlanArgs& args, const BeaconPlan& plan, const std::string& site,
                      const Session& session) {
  const survey::Placement& p = plan.placement;
  std::string text = fmt::format("{}: {} beacons, {:.1f} s\n\n", site, p.beacons.size(), session.seconds());
  Table table{"lrrrl", {{"beacon", "x [m]", "y [m]", "z [m]", "mount"}}};
  for (const auto& b : p.beacons)
    table.rows.push_back({b.beacon.name, fmt::format("{:.2f}", b.beacon.p_map_m.x()),
                          fmt::format("{:.2f}", b.beacon.p_map_m.y()),
                          fmt::format("{:.2f}", b.beacon.p_map_m.z()), b.mount.empty() ? "kept" : b.mount});
  text += table.text() + "\n";
  text += fmt::format("{:<17}worst {}, 95 % {}, mean {}; {:.1f} % of {} poses covered\n", "expected error",
                      length_text(p.figures.worst_m), length_text(p.figures.p95_m),
                      length_text(p.figures.mean_m), 100 * p.figures.covered_fraction, p.cells);
  text += fmt::format("{:<17}{}: NLopt {} and {}, seed {}, {} layouts looked at\n\n", "goal", args.goal,
                      args.algorithm, args.local, session.options.seed, p.evaluations);
  Table proof{"rrrrr", {{"beacons", "plan", "greedy", "regular", "random"}}};
  for (const auto& row : plan.proof)
    proof.rows.push_back({fmt::format("{}", row.beacons), figure(row.plan), figure(row.greedy),
                          figure(row.regular), figure(row.random)});
  return text + proof.text();
}

std::string new_site(const PlanArgs& args, const BeaconPlan& plan, Session& session) {
  const std::string old = need(io::read_document(args.input));
  std::vector<io::SiteBeaconEntry> entries;
  for (const auto& b : plan.placement.beacons) {
    if (b.mount.empty()) continue;
    entries.push_back({b.beacon.name, b.beacon.p_map_m, args.mount_sigma_m, {}});
    if (!b.beacon.axis.isZero()) entries.back().axis = b.beacon.axis;
  }
  io::SiteBeaconsText site = need(io::with_beacons(old, args.input, entries, args.keep));
  session.warn(site.warnings);
  return std::move(site.text);
}

Json write_plan_outputs(const PlanArgs& args, const SurveyInput& input, const BeaconPlan& plan,
                        Session& session) {
  Json written = Json::array();
  const auto write = [&](const std::string& path, const std::string& content) {
    need(io::write_file(path, content));
    if (path != "-") written.push_back(path);
  };
  if (!args.output.empty()) write(args.output, new_site(args, plan, session));
  if (!args.report.empty()) {
    const survey::ProofSheetInput sheet{
        .name = input.model.name,
        .settings = fmt::format("goal {}, NLopt {} and {}, seed {}", args.goal, args.algorithm, args.local,
                                session.options.seed),
        .created = created_now(),
        .program = "octant " OCTANT_VERSION,
        .rows = plan.proof,
        .placement = plan.placement,
        .floor_m = input.model.floor_m,
        .walls = input.model.walls,
        .tolerance_m = args.tolerance_m};
    write(args.report, survey::proof_sheet_html(sheet));
  }
  return written;
}

}  // namespace

int plan_beacons(const PlanArgs& args, Session& session) {
  check_outputs({args.input, args.scene}, {{"-o", args.output}, {"--report", args.report}}, session);
  const SurveyInput input = read_survey_input(args.input, args.scene, args.vehicle, {}, session,
                                              args.keep ? BeaconPlaces::kStated : BeaconPlaces::kNone);
  check_no_overwriting({.inputs = input.scene.imported, .outputs = {args.output, args.report}});
  if (!input.site)
    fail_with({.file = args.input,
               .found = "a deployment",
               .expected = "a site file: beacons are planned before they are calibrated"});
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  const BeaconPlan plan = plan_of(args, input, options_of(args, reporter, session));
  reporter.finish();
  stop_if_interrupted(plan.placement.interrupted);
  const Json written = write_plan_outputs(args, input, plan, session);
  session.result(plan_text(args, plan, input.model.name, session));
  for (const auto& file : written)
    session.result(fmt::format("{:<17}{}\n", "written", file.get<std::string>()));
  Json object = plan_json(args, plan, session);
  object["written"] = written;
  if (plan.reached) return session.finish(object);
  return session.fail({"gate_failed", "gate_failed", kGateFailed,
                       fmt::format("{} beacons reach {}, the tolerance is {}", plan.placement.beacons.size(),
                                   figure(plan.placement.figures), length_text(*args.tolerance_m)),
                       "allow more beacons (--most), more mounts, or a larger tolerance"},
                      object);
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/steps.h"
#include "apps/octant/table.h"
#include "io/deployment_json.h"

namespace octant::app {
namespace {

struct Words {
  std::string deployment;
  std::vector<std::string> runs;
};

std::string gates_in_words(const survey::Evaluation& evaluation) {
  std::string words;
  for (const auto& gate : evaluation.gates) {
    if (gate.pass) continue;
    if (!words.empty()) words += "; ";
    words += gate.name == "matched" ? "no fix has a reference at its time"
                                    : fmt::format("{}: {} is beyond the limit of {}", gate.name, length_text(gate.value), length_text(gate.limit));
  }
  return words;
}

int run(const Words& words, Session& session) {
  const auto deployment = io::read_deployment(words.deployment);
  if (!deployment) return session.fail(deployment.error());
  const auto runs = read_runs(words.runs, names_of(*deployment), deployment->timing, {.read_truth = true, .read_poses = false}, session);
  if (!runs) return session.fail(runs.error());
  // Before the long computation: is there a reference at all?
  for (const auto& log : *runs) {
    if (!log.truth.empty()) continue;
    Localization none;
    none.fixes.resize(runs->size());
    return session.fail(verify_fixes(*deployment, *runs, none).error());
  }
  const Localization found = localize_runs(*deployment, *runs, Method::kAuto);
  if (interrupted()) return session.interrupted();
  const auto evaluation = verify_fixes(*deployment, *runs, found);
  if (!evaluation) return session.fail(evaluation.error());

  session.result(evaluation_text(*evaluation));
  Json object = evaluation_json(*evaluation);
  if (!evaluation->pass()) return session.fail({"gate_failed", "gate_failed", kGateFailed, gates_in_words(*evaluation), ""}, object);
  return session.finish(object);
}

}  // namespace

void add_verify(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<Words>();
  CLI::App* command = add_command(app, common, "verify", "Localize held-out recordings and hold the fixes against truth.tum and the tolerance",
                                  "octant verify hall/deployment.json hall/heldout");
  command->add_option("deployment", words->deployment, "Deployment file, from calibrate")->required()->type_name("DEPLOYMENT.json");
  command->add_option("run", words->runs, "Run folders with truth.tum")->required()->type_name("RUN");
  command->callback([words, &action] { action = [words](Session& session) { return run(*words, session); }; });
}

}  // namespace octant::app

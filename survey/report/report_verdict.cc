// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "models/support/enum_names.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

struct BeaconCounts {
  std::size_t calibrated = 0, control = 0, undetermined = 0;
  double worst_m = 0.0;
  std::string worst;
};

BeaconCounts count(const Deployment& d) {
  BeaconCounts n;
  for (const auto& beacon : d.beacons) {
    n.undetermined += beacon.status == BeaconStatus::kUndetermined;
    n.control += beacon.status == BeaconStatus::kControlPoint;
    if (beacon.status != BeaconStatus::kCalibrated) continue;
    ++n.calibrated;
    if (const double r = radius95_m(beacon); r >= n.worst_m) {
      n.worst_m = r;
      n.worst = beacon.name;
    }
  }
  return n;
}

std::vector<ReportGate> gates_of(const ReportInput& input, const BeaconCounts& n) {
  const Deployment& d = input.plan.deployment;
  std::vector<ReportGate> gates;
  const bool converged = input.outcome == Outcome::kCalibrated && d.statistics.converged;
  gates.push_back({"adjustment",
                   input.outcome == Outcome::kRefused ? "the data cannot tell"
                   : converged                        ? "converged"
                                                      : "did not converge",
                   "converged", converged});
  if (!d.beacons.empty()) {
    gates.push_back({"beacons determined",
                     fmt::format("{} of {}", n.calibrated + n.control, d.beacons.size()), "all",
                     n.undetermined == 0});
  }
  if (d.tolerance.beacon_m && n.calibrated > 0) {
    gates.push_back({"largest error of a beacon in the plane (95 %)",
                     fmt::format("{} ({})", length_text(n.worst_m), n.worst),
                     length_text(*d.tolerance.beacon_m), n.worst_m <= *d.tolerance.beacon_m});
  }
  for (const Contradiction& c : d.contradictions)
    gates.push_back({fmt::format("agrees with the data: {}", c.subject), in_words(c), "as stated", false});
  if (!input.evaluation) return gates;
  for (const auto& gate : input.evaluation->gates) {
    if (gate.name == "matched") {
      gates.push_back({"held-out fixes with a reference", fmt::format("{:.0f}", gate.value),
                       fmt::format("at least {:.0f}", gate.limit), gate.pass});
    } else {
      gates.push_back({gate.name == "fix_m" ? "position error of the held-out fixes (RMSE)" : gate.name,
                       length_text(gate.value), length_text(gate.limit), gate.pass});
    }
  }
  return gates;
}

/// A refusal has words of its own, and they weigh more.
bool is_contradicted(const ReportInput& input) {
  return input.outcome != Outcome::kRefused && !input.plan.deployment.contradictions.empty();
}

/// The first contradictions, the others counted.
std::string contradictions_in_words(const std::vector<Contradiction>& all) {
  constexpr std::size_t kMostTold = 4;
  std::string text = "The data contradict what was stated. ";
  for (std::size_t i = 0; i < all.size() && i < kMostTold; ++i) text += in_words(all[i]) + ". ";
  if (all.size() > kMostTold) text += fmt::format("And {} more. ", all.size() - kMostTold);
  return text;
}

std::string sentence_of(const ReportInput& input, const BeaconCounts& n) {
  const Deployment& d = input.plan.deployment;
  if (is_contradicted(input))
    return contradictions_in_words(d.contradictions) +
           "The result depends on these assumptions: do not use it before the contradictions are resolved.";
  if (input.outcome != Outcome::kCalibrated) {
    const std::string why = !input.message.empty() ? input.message
                            : input.outcome == Outcome::kRefused
                                ? "the data do not determine what is asked for"
                                : "the adjustment did not converge";
    // The solver may have said so already.
    const bool said = why.find("nothing is exported") != std::string::npos;
    return (said ? as_sentence(why) : as_sentence("nothing was exported: " + why));
  }
  std::string text = d.statistics.converged ? "" : "The adjustment did not converge. ";
  text += n.calibrated == 0 ? std::string("No beacon was asked for")
                            : fmt::format("{} beacon{} calibrated, the worst within {} in the plane (95 %)",
                                          n.calibrated, n.calibrated == 1 ? "" : "s", length_text(n.worst_m));
  if (d.tolerance.beacon_m && n.calibrated > 0) {
    text += fmt::format(", {} the tolerance of {}", n.worst_m <= *d.tolerance.beacon_m ? "inside" : "outside",
                        length_text(*d.tolerance.beacon_m));
  }
  if (n.undetermined > 0) text += fmt::format("; {} could not be determined", n.undetermined);
  if (input.evaluation) {
    const Evaluation& e = *input.evaluation;
    text += e.fixes == 0
                ? fmt::format("; there is no fix to hold against the reference ({} failed)", e.no_fix)
            : e.matched == 0
                ? fmt::format("; none of {} fixes has a reference at its time", e.fixes)
                : fmt::format("; fixes are {} RMSE off the reference", length_text(e.position_rmse_m));
    if (e.matched > 0 && !e.gates.empty())
      text += e.pass() ? ", inside their tolerance" : ", outside their tolerance";
  }
  return text + ".";
}

}  // namespace

const char* to_string(Grade grade) {
  static constexpr auto kNames =
      enum_names<Grade>("Good", "Not judged", "Not good enough", "Contradicted", "Refused");
  return kNames[grade];
}

Tone tone_of(Grade grade) {
  return grade == Grade::kGood ? Tone::kGood : grade == Grade::kUnjudged ? Tone::kAttention : Tone::kBad;
}

Verdict verdict(const ReportInput& input) {
  const BeaconCounts n = count(input.plan.deployment);
  Verdict v;
  v.gates = gates_of(input, n);
  v.sentence = sentence_of(input, n);
  const bool kept = std::ranges::all_of(v.gates, [](const ReportGate& g) { return g.pass; });
  const bool judged =
      input.plan.deployment.tolerance.beacon_m || (input.evaluation && !input.evaluation->gates.empty());
  v.grade = is_contradicted(input)                  ? Grade::kContradicted
            : input.outcome != Outcome::kCalibrated ? Grade::kRefused
            : !kept                                 ? Grade::kPoor
            : judged                                ? Grade::kGood
                                                    : Grade::kUnjudged;
  if (v.grade == Grade::kUnjudged)
    v.sentence += input.plan.deployment.tolerance.fix_m
                      ? fmt::format(
                            " The site's tolerance of {} is one of fixes: octant verify holds them "
                            "against it.",
                            length_text(*input.plan.deployment.tolerance.fix_m))
                      : " The site states no tolerance to hold that against.";
  return v;
}

std::optional<ReportSection> verdict_section(const ReportInput& input) {
  const Verdict v = verdict(input);
  ReportSection section{"verdict", "What the verdict rests on"};
  ReportTable table{"gates", "What must hold", {{"gate", true}, {"found"}, {"limit"}, {"verdict", true}}};
  for (const auto& gate : v.gates)
    table.rows.push_back({{gate.name},
                          {gate.value},
                          {gate.limit},
                          {gate.pass ? "kept" : "not kept", gate.pass ? Tone::kGood : Tone::kBad}});
  section.blocks.emplace_back(std::move(table));
  if (const auto& contradictions = input.plan.deployment.contradictions; !contradictions.empty()) {
    ReportTable found{"contradictions",
                      "What the data speak against",
                      {{"what", true}, {"stated", true}, {"found", true}, {"sigmas"}, {"what to do", true}}};
    for (const Contradiction& c : contradictions)
      found.rows.push_back({{c.subject, Tone::kBad},
                            {c.stated},
                            {c.found},
                            {c.sigmas > 0 ? fmt::format("{:.1f}", c.sigmas) : "-"},
                            {c.remedy}});
    section.blocks.emplace_back(std::move(found));
  }
  return section;
}

}  // namespace octant::survey

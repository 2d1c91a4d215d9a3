// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/commands/batch_sites.h"

#include <algorithm>
#include <exception>
#include <mutex>

#include <fmt/format.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/steps/reporting.h"
#include "models/support/parallel.h"

namespace octant::app {
namespace {

void end_with(const Failure& failure, SiteOutcome& outcome) {
  outcome.exit = failure.exit;
  outcome.message = failure.exit == kInterrupted ? "interrupted" : failure.words();
  outcome.object.update(failure.object());
}

void calibrate_site(const io::BatchSite& site, const CalibrateOptions& how, Session& session,
                    SiteOutcome& outcome) {
  ReportArgs report;
  if (!site.report.empty()) report.paths.push_back(site.report);
  stop_if_interrupted();
  check_output(site.output);
  check_report(report);
  const Calibration calibration = calibrate_files(site.site, site.runs, how, session);
  outcome.object.update(calibration_json(calibration, session));
  for (const char* of_arrivals : {"left_out", "reliability"}) outcome.object.erase(of_arrivals);
  const survey::ReportInput input = calibration_report(calibration, report, session);
  write_calibration(site.output, report, calibration, input);
  outcome.object["verdict"] = verdict_json(input);
  if (const auto failure = failure_of(calibration)) return end_with(*failure, outcome);
  outcome.object["status"] = "ok";
}

SiteOutcome outcome_of(const io::BatchSite& site, std::size_t number, const CalibrateOptions& how,
                       Session session) {
  SiteOutcome outcome;
  outcome.number = number;
  outcome.object = {{"name", site.name},
                    {"site", site.site},
                    {"runs", site.runs},
                    {"output", site.output},
                    {"report", site.report.empty() ? Json(nullptr) : Json(site.report)},
                    {"status", "ok"},
                    {"exit", 0}};
  try {
    calibrate_site(site, how, session, outcome);
  } catch (const CommandFailed& ended) {
    end_with(ended.failure, outcome);
  } catch (const std::exception& error) {
    const std::string message = fmt::format("a fault of octant: {}", error.what());
    end_with({"error", "internal", kFault, message, "please report it with the site"}, outcome);
  }
  outcome.object["exit"] = static_cast<int>(outcome.exit);
  outcome.object["seconds"] = session.seconds();
  outcome.object["warnings"] = session.warnings();
  return outcome;
}

}  // namespace

std::vector<SiteOutcome> calibrate_sites(const io::Batch& batch, Shard shard, const CalibrateOptions& how,
                                         const Session& session,
                                         const std::function<void(const SiteOutcome&)>& on_done) {
  // A signal must not terminate the program in this thread while another thread writes the results of a site.
  const NoExitAtOnce others_may_write;
  std::vector<SiteOutcome> outcomes;
  for (std::size_t i = 0; i < batch.sites.size(); ++i)
    if (shard.has(i)) outcomes.emplace_back().number = i;

  const auto threads = static_cast<std::size_t>(session.threads());
  const std::size_t workers = std::clamp<std::size_t>(threads, 1, std::max<std::size_t>(1, outcomes.size()));
  std::mutex one_at_a_time;
  for_each_parallel(outcomes.size(), session.threads(), [&](std::size_t i) {
    const std::size_t number = outcomes[i].number;
    outcomes[i] =
        outcome_of(batch.sites[number], number, how, session.part(static_cast<int>(threads / workers)));
    const std::lock_guard lock(one_at_a_time);
    on_done(outcomes[i]);
  });
  return outcomes;
}

}  // namespace octant::app

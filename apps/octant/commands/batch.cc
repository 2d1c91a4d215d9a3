// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/commands/batch_sites.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/ranks.h"
#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

struct BatchArgs {
  std::string list, folder, shard;
  CalibrateOptions how;
};

/// Parses "2/10", the second of ten shards.
std::optional<Shard> shard_of(const std::string& text) {
  std::size_t i = 0, count = 0;
  const char* end = text.data() + text.size();
  const auto [slash, bad_i] = std::from_chars(text.data(), end, i);
  if (bad_i != std::errc() || slash == end || *slash != '/') return std::nullopt;
  const auto [stop, bad_count] = std::from_chars(slash + 1, end, count);
  if (bad_count != std::errc() || stop != end || i < 1 || i > count) return std::nullopt;
  return Shard{i - 1, count};
}

std::string summary(const io::Batch& batch, const std::vector<SiteOutcome>& outcomes) {
  Table table{"llrrrl", {{"site", "status", "arrivals", "time [s]", "variance", "undetermined"}}};
  for (const auto& outcome : outcomes) {
    const Json& o = outcome.object;
    const bool adjusted = o.contains("arrivals");
    std::string undetermined;
    if (adjusted)
      for (const auto& name : o["undetermined"])
        undetermined += (undetermined.empty() ? "" : ", ") + name.get<std::string>();
    table.rows.push_back({batch.sites[outcome.number].name, o["status"].get<std::string>(),
                          adjusted ? fmt::format("{}", o["arrivals"].get<std::size_t>()) : "-",
                          fmt::format("{:.2f}", o["seconds"].get<double>()),
                          adjusted ? fmt::format("{:.3f}", o["variance_factor"].get<double>()) : "-",
                          undetermined});
  }
  return table.text();
}

/// Outcomes of all ranks in the order of the list, on the first rank.
std::vector<SiteOutcome> gathered(const std::vector<SiteOutcome>& mine, const Job& job) {
  Json told = Json::array();
  for (const auto& outcome : mine)
    told.push_back({{"number", outcome.number},
                    {"exit", static_cast<int>(outcome.exit)},
                    {"message", outcome.message},
                    {"object", outcome.object}});
  std::vector<SiteOutcome> all;
  for (const std::string& text : job.gather(dump(told)))
    for (const Json& one : Json::parse(text))
      all.push_back({one["number"].get<std::size_t>(), static_cast<Exit>(one["exit"].get<int>()),
                     one["message"].get<std::string>(), one["object"]});
  std::ranges::sort(all, {}, &SiteOutcome::number);
  return all;
}

/// Ends the command after all sites have been processed, and summarises their outcomes.
int end(const io::Batch& batch, const std::vector<SiteOutcome>& outcomes, const Json& object,
        Session& session) {
  std::size_t failed = 0, unfinished = 0;
  const SiteOutcome* first = nullptr;
  for (const auto& outcome : outcomes) {
    unfinished += outcome.exit == kInterrupted;
    failed += outcome.exit != kDone && outcome.exit != kInterrupted;
    if (outcome.exit != kDone && first == nullptr) first = &outcome;
  }
  if (unfinished > 0) {
    const std::string message =
        fmt::format("interrupted; {} of {} sites were done before, nothing is half-written",
                    outcomes.size() - unfinished, outcomes.size());
    return session.fail({"interrupted", "interrupted", kInterrupted, message, ""}, object);
  }
  if (first == nullptr) return session.finish(object);
  const std::string message = fmt::format("{} of {} sites failed, the first is {}", failed, outcomes.size(),
                                          batch.sites[first->number].name);
  return session.fail({first->object["status"].get<std::string>(), "sites_failed", first->exit, message, ""},
                      object);
}

CommandFiles files_of(const BatchArgs& args, const io::Batch& batch) {
  CommandFiles files{.inputs = {args.list}, .outputs = {}};
  for (const io::BatchSite& site : batch.sites) {
    files.inputs.push_back(site.site);
    files.inputs.insert(files.inputs.end(), site.runs.begin(), site.runs.end());
    files.outputs.insert(files.outputs.end(), {site.output, site.report});
  }
  return files;
}

int report_all(const io::Batch& batch, const Shard& shard, const std::vector<SiteOutcome>& outcomes,
               Session& session) {
  std::vector<std::string> warnings;
  Json sites = Json::array();
  std::size_t good = 0;
  for (const auto& outcome : outcomes) {
    good += outcome.exit == kDone;
    for (const auto& warning : outcome.object["warnings"])
      warnings.push_back(fmt::format("{}: {}", batch.sites[outcome.number].name, warning.get<std::string>()));
    sites.push_back(outcome.object);
  }
  session.warn(warnings);
  session.result(summary(batch, outcomes));
  const Json object = {
      {"sites", sites},
      {"calibrated", good},
      {"failed", outcomes.size() - good},
      {"seconds", session.seconds()},
      {"shard", {{"index", shard.index + 1}, {"count", shard.count}, {"sites_in_list", batch.sites.size()}}}};
  return end(batch, outcomes, object, session);
}

int run(const BatchArgs& args, Session& session) {
  Shard shard;
  if (!args.shard.empty()) {
    const auto given = shard_of(args.shard);
    if (!given)
      fail_usage(fmt::format("--shard is '{}'", args.shard), "i/N with i from 1 to N, such as 1/10");
    shard = *given;
  }
  const calib::Ranks* ranks = session.job != nullptr ? session.job->ranks() : nullptr;
  if (ranks != nullptr) {
    // The shard of this job is divided among the ranks.
    shard.index += shard.count * static_cast<std::size_t>(ranks->index());
    shard.count *= static_cast<std::size_t>(ranks->count());
  }
  const io::Batch batch = need(io::read_batch(args.list, args.folder));
  check_no_overwriting(files_of(args, batch));
  session.warn(batch.warnings);
  if (!args.folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(args.folder,
                                        error);  // another job of the array may have created it
    if (error)
      fail_with({.code = Errc::kOutput,
                 .file = args.folder,
                 .found = "the folder cannot be made: " + error.message()});
  }

  std::size_t done = 0;
  const bool silent = session.options.progress == "none";
  auto outcomes = calibrate_sites(batch, shard, args.how, session, [&](const SiteOutcome& outcome) {
    const std::string& name = batch.sites[outcome.number].name;
    const std::string what = outcome.message.empty() ? "calibrated" : outcome.message;
    ++done;
    if (!silent) session.note(fmt::format("{}: {}: {}", done, name, what));
  });
  if (ranks != nullptr) {
    outcomes = gathered(outcomes, *session.job);
    if (!session.job->is_first()) return kDone;  // the first rank reports for all
    shard.index %= shard.count / static_cast<std::size_t>(ranks->count());
    shard.count /= static_cast<std::size_t>(ranks->count());
  }
  return report_all(batch, shard, outcomes, session);
}

}  // namespace

void add_batch(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<BatchArgs>(
      app, common, action, "batch", "Calibrate many sites; one that fails does not stop the others",
      "octant batch fleet/sites.yaml -o calibrated --shard $SLURM_ARRAY_TASK_ID/10", run);
  add_required_option(*command, "sites", args->list, "SITES.yaml",
                      "List of sites, with their runs and outputs (octant schema batch)");
  add_option(*command, "-o,--output", args->folder, "DIR",
             "Folder at which outputs and reports begin, made if it is not there; else the list's");
  add_option(*command, "--shard", args->shard, "i/N",
             "Only every N-th site, from the i-th on (i from 1 to N): a job of an array");
  command->add_flag("--strict", args->how.strict, "A single undetermined beacon is a site's exit 5");
  command->add_flag("--accept", args->how.accept,
                    "Write deployments that the data contradict all the same, marked (exit 6)");
  command->footer(
      "Example:\n  octant batch fleet/sites.yaml -o calibrated --shard $SLURM_ARRAY_TASK_ID/10\n\n"
      "Exit code: 0 if all sites are calibrated, else that of the first site in the list that is not (the "
      "table and --json tell each).");
}

}  // namespace octant::app

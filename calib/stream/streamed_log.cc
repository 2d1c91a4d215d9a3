// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/streamed_log.h"

#include <optional>
#include <utility>

#include "calib/problem/thin.h"
#include "calib/stream/drives/drive_part.h"
#include "calib/stream/drives/drive_passes.h"
#include "calib/stream/long_log.h"

namespace octant::calib {

StreamedLog::StreamedLog(const Site& site, ArrivalSource& source, const StreamPlan& plan)
    : site_(site),
      source_(source),
      stops_(site.vehicles.size(), site.beacons.size(), plan.chunk_arrivals),
      drives_(source, site),
      piece_bytes_(plan.piece_bytes) {}

Result<void> StreamedLog::scan() {
  const auto read = source_.scan([&](std::size_t run, const std::vector<Arrival>& block) {
    if (is_drive(source_.log(run))) {
      drives_.take(run, block);
    } else {
      stops_.take(run, block);
    }
    return true;
  });
  if (!read) return read;
  stops_.end(source_.runs());
  drives_.end(piece_bytes_);
  return {};
}

Result<Problem> StreamedLog::part(int threads) const {
  std::vector<MeasurementLog> runs;
  for (std::size_t run = 0; run < source_.runs(); ++run) {
    auto few = is_drive(source_.log(run)) ? part_of_drives(run, site_, source_, drives_)
                                          : part_of_stops(run, site_, source_, stops_, threads);
    if (!few) return fail(few.error());
    runs.push_back(std::move(*few));
  }
  return make_problem(site_, std::move(runs), threads);
}

std::vector<std::string> StreamedLog::warnings(const Problem& part) const {
  if (drives_.pieces().empty()) return part.warnings;
  std::vector<std::string> words;
  for (const DriveChain& chain : drives_.chains())
    if (chain.stateless_count > 0)
      words.push_back(
          stateless_in_words(source_.log(chain.run), chain.stateless_line, chain.stateless_count));
  return words;
}

void StreamedLog::begin(const Problem& frame, const SolveOptions& options, int workers, Course& course) {
  const ReadingTask task{frame, source_, options, course, workers, stops_.arrivals() + drives_.arrivals()};
  if (stops_.arrivals() > 0 || drives_.pieces().empty())
    readings_.push_back(std::make_unique<LogPasses>(task, stops_));
  if (!drives_.pieces().empty()) readings_.push_back(std::make_unique<DrivePasses>(task, drives_));
}

Result<LogReadings::Placed> StreamedLog::place(const Estimate& estimate, double suspect_sigmas, bool mark) {
  Placed all;
  for (const auto& some : readings_) {
    auto placed = some->place(estimate, suspect_sigmas, mark && readings_.size() == 1);
    if (!placed) return placed;
    all.residuals.insert(all.residuals.end(), placed->residuals.begin(), placed->residuals.end());
    all.ranges_m.insert(all.ranges_m.end(), placed->ranges_m.begin(), placed->ranges_m.end());
    all.sum = std::move(placed->sum);
  }
  return all;
}

Result<PassSum> StreamedLog::pass(const Estimate& estimate, MarkPolicy marks) {
  std::optional<PassSum> sum;
  for (const auto& some : readings_) {
    auto next = some->pass(estimate, marks);
    if (!next) return next;
    if (sum) {
      sum->add(*next);
    } else {
      sum = std::move(*next);
    }
  }
  return std::move(*sum);
}

void StreamedLog::accept() {
  for (const auto& some : readings_) some->accept();
}

Result<void> StreamedLog::tell(const Estimate& estimate, FindingsGatherer& gatherer) {
  for (const auto& some : readings_)
    if (auto ok = some->tell(estimate, gatherer); !ok) return ok;
  return {};
}

}  // namespace octant::calib

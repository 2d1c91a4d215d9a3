// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/stream_source.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "apps/octant/interrupt.h"
#include "calib/streamed.h"

namespace octant::app {

Result<std::unique_ptr<StreamSource>> StreamSource::open(const std::vector<std::string>& folders,
                                                         const NameTable& names, const Timing& timing,
                                                         Session& session, double constant_speed_mps) {
  std::unique_ptr<StreamSource> source(new StreamSource(folders, names, timing, session));
  source->constant_speed_mps_ = constant_speed_mps;
  for (const auto& folder : folders) {
    // One thread for each recording, so that reading starts only when it is needed.
    auto stream = io::RunStream::open(folder, source->names_, timing,
                                      {.constant_speed_mps = constant_speed_mps, .threads = 1});
    if (!stream) return fail(stream.error());
    source->streams_.push_back(std::move(*stream));
  }
  return source;
}

std::vector<const MeasurementLog*> StreamSource::logs() const {
  std::vector<const MeasurementLog*> logs;
  for (const auto& stream : streams_) logs.push_back(&stream.log());
  return logs;
}

Result<void> StreamSource::scan(const Visit& visit) {
  const ExitAtOnce nothing_written_yet;
  for (std::size_t run = 0; run < streams_.size(); ++run) {
    auto stream =
        io::RunStream::open(folders_[run], names_, timing_,
                            {.constant_speed_mps = constant_speed_mps_, .threads = session_.threads()});
    if (!stream) return fail(stream.error());
    streams_[run] = std::move(*stream);
    std::vector<Arrival> block;
    std::size_t arrivals = 0;
    for (;;) {
      const auto more = streams_[run].next(block);
      if (!more) return fail(more.error());
      if (!*more) break;
      arrivals += block.size();
      if (!visit(run, block)) return {};
    }
    const MeasurementLog& log = streams_[run].log();
    session_.warn(log.warnings);
    session_.detail(
        fmt::format("{}: {} arrivals, {} rows that are none", folders_[run], arrivals, log.rejected.size()));
  }
  return {};
}

std::size_t StreamSource::rows_estimate() const {
  std::size_t rows = 0;
  for (const auto& stream : streams_) rows += stream.rows_estimate();
  return rows;
}

std::size_t StreamSource::odometry_rows() const {
  std::size_t rows = 0;
  for (const auto& stream : streams_) rows += stream.log().odometry.size();
  return rows;
}

bool fits_for_sure(const std::vector<std::string>& folders, std::size_t memory_bytes) {
  constexpr std::size_t kShortestRow = 10;
  std::size_t arrivals = 0, odometry = 0;
  const auto rows_of = [](const std::string& folder, const char* file) {
    std::error_code none;  // the reader will report this error
    const auto size = std::filesystem::file_size(std::filesystem::path(folder) / file, none);
    return none ? 0 : static_cast<std::size_t>(size) / kShortestRow;
  };
  for (const auto& folder : folders) {
    arrivals += rows_of(folder, "tof.csv");
    odometry += rows_of(folder, "odometry.csv");
  }
  return calib::memory_of_held(arrivals, odometry) <= memory_bytes;
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_stream.h"

#include <utility>

#include "io/run/run_reader.h"

namespace octant::io {

RunStream::RunStream(std::unique_ptr<RunReader> reader) : reader_(std::move(reader)) {}
RunStream::RunStream(RunStream&&) noexcept = default;
RunStream& RunStream::operator=(RunStream&&) noexcept = default;
RunStream::~RunStream() = default;

Result<RunStream> RunStream::open(const std::string& folder, const NameTable& names, const Timing& timing,
                                  const ReadRunOptions& options) {
  auto reader = std::make_unique<RunReader>(folder, names, timing, options);
  if (auto ok = reader->begin(); !ok) return fail(ok.error());
  if (auto ok = reader->read_others(); !ok) return fail(ok.error());
  return RunStream(std::move(reader));
}

Result<bool> RunStream::next(std::vector<Arrival>& block) {
  block.clear();
  if (ended_) return false;
  const TofPosition begin = reader_->position();
  const auto more = reader_->next_arrivals(block);
  ended_ = !more || !*more;
  if (!ended_) begins_.push_back(begin);
  if (more && ended_)
    if (auto ok = reader_->finish(); !ok) return fail(ok.error());
  return more;
}

std::size_t RunStream::blocks() const { return begins_.size(); }

Result<void> RunStream::read_blocks(std::size_t first, std::size_t last,
                                    std::vector<Arrival>& arrivals) const {
  if (first >= last) return {};
  return reader_->read_again(begins_[first], last < begins_.size() ? begins_[last] : reader_->position(),
                             arrivals);
}

std::size_t RunStream::rows_estimate() const { return reader_->rows_estimate(); }

const MeasurementLog& RunStream::log() const { return reader_->log(); }

}  // namespace octant::io

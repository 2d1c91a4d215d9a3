// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_stream.h"

#include <algorithm>
#include <utility>

#include "io/run/run_reader.h"

namespace octant::io {

RunStream::RunStream(std::unique_ptr<RunReader> reader, std::size_t block_rows)
    : reader_(std::move(reader)), block_rows_(std::max<std::size_t>(1, block_rows)) {}
RunStream::RunStream(RunStream&&) noexcept = default;
RunStream& RunStream::operator=(RunStream&&) noexcept = default;
RunStream::~RunStream() = default;

Result<RunStream> RunStream::open(const std::string& folder, const NameTable& names, const Timing& timing,
                                  const ReadRunOptions& options, std::size_t block_rows) {
  auto reader = std::make_unique<RunReader>(folder, names, timing, options);
  if (auto ok = reader->begin(); !ok) return fail(ok.error());
  if (auto ok = reader->read_others(); !ok) return fail(ok.error());
  return RunStream(std::move(reader), block_rows);
}

Result<bool> RunStream::next(std::vector<Arrival>& block) {
  block.clear();
  while (!ended_ && block.size() < block_rows_) {
    if (taken_ == held_.size()) {
      taken_ = 0;
      const auto more = reader_->next_arrivals(held_);
      ended_ = !more || !*more;
      if (!more) return more;
      if (!ended_) continue;
      if (auto ok = reader_->finish(); !ok) return fail(ok.error());
    }
    const auto from = held_.begin() + static_cast<std::ptrdiff_t>(taken_);
    const std::size_t count = std::min(block_rows_ - block.size(), held_.size() - taken_);
    block.insert(block.end(), from, from + static_cast<std::ptrdiff_t>(count));
    taken_ += count;
  }
  return !block.empty();
}

Result<bool> RunStream::next_piece(std::vector<Arrival>& block) {
  const TofPosition begin = reader_->position();
  auto more = reader_->next_arrivals(block);
  if (more && *more) begins_.push_back(begin);
  if (more && !*more) {
    if (auto ok = reader_->finish(); !ok) return fail(ok.error());
  }
  return more;
}

std::size_t RunStream::pieces() const { return begins_.size(); }

Result<void> RunStream::read_pieces(std::size_t first, std::size_t last,
                                    std::vector<Arrival>& arrivals) const {
  if (first >= last) return {};
  return reader_->read_again(begins_[first], last < begins_.size() ? begins_[last] : reader_->position(),
                             arrivals);
}

std::size_t RunStream::rows_estimate() const { return reader_->rows_estimate(); }

const MeasurementLog& RunStream::log() const { return reader_->log(); }

}  // namespace octant::io

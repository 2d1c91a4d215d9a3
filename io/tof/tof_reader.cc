// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/tof_reader.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "io/text/bounds.h"
#include "models/support/parallel.h"

namespace octant::io {
namespace {

constexpr std::size_t kDigestBytes = std::size_t{1} << 20;  // at once
constexpr std::size_t kNoSeam = std::string_view::npos;
constexpr std::size_t kMostReserved = std::size_t{1} << 25;  // rows; a file of newlines seems to hold many
constexpr std::size_t kBlockRows = 4096;                     // of the general way
constexpr std::size_t kPiecesAThread = 8;                    // of a window

}  // namespace

TofReader::TofReader(std::shared_ptr<const MappedFile> map, std::string file, const NameLookup& names,
                     Clock clock, TofReaderOptions options)
    : map_(std::move(map)),
      text_(map_->text().substr(0, options.to)),
      file_(std::move(file)),
      names_(names),
      clock_(clock),
      options_(options),
      csv_(text_, file_, true) {}

Result<void> TofReader::read_header() {
  columns_.emplace(csv_, options_.distance);
  if (csv_.error()) return fail(text_error(*csv_.error()));
  order_.emplace(names_.names().vehicles.size(), columns_->time, columns_->epoch);
  general_ = options_.general_way || !is_utf8(text_.substr(0, csv_.offset()));
  if (options_.from) {
    csv_.go_to(options_.from->offset, options_.from->line);
    order_->go_on(options_.from->times);
    general_ = general_ || clock().offset_s() != 0.0;  // the parser of pieces does not continue clocks
  }
  body_ = offset_ = given_back_ = csv_.offset();
  line_ = csv_.next_line();
  if (general_) {
    if (auto ok = check_text(); !ok) return ok;
  }
  start();
  return {};
}

/// Checks that the text is UTF-8 without loading all of it into memory.
Result<void> TofReader::check_text() const {
  if (options_.from) return {};
  for (std::size_t begin = 0, end = 0; begin < text_.size(); begin = end) {
    end = seam(std::max(begin, body_) + kDigestBytes);
    if (end == kNoSeam || !is_utf8(text_.substr(begin, end - begin))) {
      auto error = check_lines(text_.substr(begin), file_).error();
      error.line += position_of(text_, begin).line - 1;
      return fail(error);
    }
    map_->release(begin, end);
  }
  return {};
}

/// Returns the error of a text that is not UTF-8 if there is one, as it precedes all other errors.
Error TofReader::text_error(const Error& otherwise) const {
  const auto ok = check_text();
  return ok ? otherwise : ok.error();
}

/// Offset of the first line that begins at or after an offset of the body; kNoSeam within a line without an
/// end.
std::size_t TofReader::seam(std::size_t offset) const {
  if (offset <= body_) return body_;
  if (offset >= text_.size()) return text_.size();
  const std::string_view near = text_.substr(offset - 1, kLongestLine);
  const std::size_t newline = near.find('\n');
  if (newline != std::string_view::npos) return offset + newline;
  return offset - 1 + near.size() == text_.size() ? text_.size() : kNoSeam;
}

void TofReader::start() {
  pieces_ = chunk_count(text_.size() - body_, options_.chunk_bytes);
  const std::size_t window =
      options_.threads > 1 ? kPiecesAThread * static_cast<std::size_t>(options_.threads) : 1;
  chunks_.resize(std::clamp<std::size_t>(pieces_, 1, window));
  parsers_.assign(chunks_.size(), TofChunkParser(csv_.header().size(), *columns_, names_, clock_));
}

/// Parses the next pieces, up to the size of the window, and computes the digest of their text in parallel.
void TofReader::parse_window() {
  const std::size_t count = std::min(chunks_.size(), pieces_ - piece_);
  for_each_parallel(count + 1, options_.threads, [&](std::size_t i) {
    if (i > 0) return parse(piece_ + i - 1, i - 1);
    const std::size_t end = seam(body_ + (piece_ + count) * options_.chunk_bytes);
    if (!options_.from && end != kNoSeam) digest_to(end);
  });
}

void TofReader::parse(std::size_t piece, std::size_t slot) {
  const std::size_t begin = seam(body_ + piece * options_.chunk_bytes),
                    end = seam(body_ + (piece + 1) * options_.chunk_bytes);
  if (chunks_.size() > 1) chunks_[slot].arrivals.clear();
  if (begin == kNoSeam || end == kNoSeam) {
    chunks_[slot].regular = false;
    return;
  }
  parsers_[slot].parse(text_.substr(begin, end - begin), chunks_[slot]);
}

Result<bool> TofReader::append(std::vector<Arrival>& all) {
  const std::size_t before = all.size();
  auto more = append_as_written(all);
  if (more && *more)
    for (const int line : repeated_.drop(all, before)) refusals_.add(Refusal::kRepeated, line, "");
  if (columns_->distance)
    for (std::size_t i = before; i < all.size(); ++i)
      all[i].tof_s = options_.distance.per_m_s * all[i].tof_s + options_.distance.offset_s;
  return more;
}

Result<bool> TofReader::append_as_written(std::vector<Arrival>& all) {
  if (general_) return next_rows(all);
  if (piece_ == pieces_) return false;
  // A single piece is parsed directly into its final place.
  const bool alone = chunks_.size() == 1;
  const std::size_t first = alone ? all.size() : 0, slot = piece_ % chunks_.size();
  if (alone) chunks_[0].arrivals.swap(all);
  if (slot == 0) parse_window();
  TofChunk& chunk = chunks_[slot];
  const bool taken = take(chunk, first);
  if (alone) {
    if (!taken) chunk.arrivals.resize(first);
    chunk.arrivals.swap(all);
  } else if (taken && all.empty() && all.capacity() <= chunk.arrivals.capacity()) {
    chunk.arrivals.swap(all);  // unless there is room for more to come
  } else if (taken) {
    all.insert(all.end(), chunk.arrivals.begin(), chunk.arrivals.end());
  }
  if (taken) {
    offset_ = seam(body_ + ++piece_ * options_.chunk_bytes);
    give_back(offset_);
    return true;
  }
  if (const auto ok = check_text(); !ok) return fail(ok.error());
  if (out_of_order_) return fail(first_error());
  general_ = true;
  csv_.go_to(offset_, line_);
  return next_rows(all);
}

/// Adds the content of a piece, its arrivals from the first on; false if the general method must read the
/// piece.
bool TofReader::take(TofChunk& chunk, std::size_t first) {
  if (!chunk.regular) return false;
  if (chunk.rows > 0 &&
      !(order_->advance_time(chunk.first_time_s) && order_->advance_time(chunk.last_time_s)))
    return false;
  for (const auto& [vehicle, epoch] : chunk.epochs) {
    if (!order_->advance_epoch(vehicle, epoch)) {
      out_of_order_ = true;
      return false;
    }
  }
  for (std::size_t i = first; i < chunk.arrivals.size(); ++i) chunk.arrivals[i].line += line_;
  for (const auto& [line, refusal, text] : chunk.refused) refusals_.add(refusal, line_ + line, text);
  line_ += std::min(chunk.lines, std::numeric_limits<int>::max() - line_);
  rows_ += chunk.rows;
  return true;
}

Result<bool> TofReader::next_rows(std::vector<Arrival>& block) {
  const std::size_t first = block.size();
  while (block.size() < first + kBlockRows && csv_.next_row()) {
    Arrival arrival;
    if (!read_tof_row(csv_, *columns_, names_, *order_, arrival)) break;
    ++rows_;
    const std::string_view text = csv_.field(columns_->tof);
    const Refusal refusal = refusal_of(text, arrival.tof_s, clock_);
    if (refusal == Refusal::kNone) {
      block.push_back(arrival);
    } else {
      refusals_.add(refusal, arrival.line, text);
    }
  }
  if (csv_.error()) return fail(*csv_.error());
  give_back(csv_.offset());
  return block.size() > first;
}

/// First error in the order of the rows, found by reading the file from its beginning.
Error TofReader::first_error() const {
  CsvReader csv(text_, file_, true);
  const TofColumns columns(csv, options_.distance);
  OrderWatch order(names_.names().vehicles.size(), columns.time, columns.epoch);
  Arrival arrival;
  while (csv.next_row()) {
    arrival = {};
    if (!read_tof_row(csv, columns, names_, order, arrival)) break;
  }
  if (!csv.error()) throw std::logic_error("the two ways of reading tof.csv disagree");
  return *csv.error();
}

std::vector<std::string> TofReader::warnings() const {
  std::vector<std::string> warnings;
  if (const auto unknown = csv_.unknown_columns()) warnings.push_back(*unknown);
  if (const auto restarts = clock().note(file_)) warnings.push_back(*restarts);
  refusals_.warn(file_, warnings);
  return warnings;
}

std::string TofReader::sha256() {
  const std::size_t size = map_->text().size();
  while (digested_ < size) {
    const std::size_t begin = digested_;
    digest_to(std::min(size, begin + kDigestBytes));
    map_->release(begin, digested_);
  }
  return digest_.hex();
}

void TofReader::digest_to(std::size_t offset) {
  digest_.add(map_->text().substr(digested_, offset - digested_));
  digested_ = offset;
}

void TofReader::give_back(std::size_t offset) {
  map_->release(given_back_, offset);
  given_back_ = offset;
}

std::size_t TofReader::rows_estimate() const {
  constexpr std::size_t kSamples = 16, kSampleBytes = 8192;
  const std::string_view body = text_.substr(body_);
  std::size_t sampled = 0, lines = 0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const std::string_view sample = body.substr(body.size() / kSamples * i, kSampleBytes);
    sampled += sample.size();
    lines += static_cast<std::size_t>(std::ranges::count(sample, '\n'));
  }
  const double density =
      sampled == 0 ? 0.0 : static_cast<double>(lines + kSamples) / static_cast<double>(sampled);
  return std::min(kMostReserved,
                  static_cast<std::size_t>(1.02 * density * static_cast<double>(body.size())) + 1);
}

}  // namespace octant::io

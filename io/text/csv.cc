// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/csv.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/text/bounds.h"
#include "io/text/csv_scan.h"
#include "io/text/time_text.h"
#include "io/tof_columns.h"
#include "models/support/largest.h"

namespace octant::io {
namespace {

struct ColumnNames {
  std::string_view name;
  std::vector<std::string_view> others;  ///< lower case; without a unit behind them
};

/// Returns true if loggers of other programs use the name for our column; a unit may follow the name.
bool may_be_called(std::string_view ours, std::string_view theirs) {
  static const std::vector<ColumnNames> all = {
      {"time_s", {"time", "t", "timestamp", "stamp", "ts", "sec", "secs", "seconds", "date"}},
      {"beacon",
       {"anchor", "beacon_id", "anchor_id", "beaconid", "anchorid", "transmitter", "speaker", "source",
        "node", "id", "tx"}},
      {"tof_s",
       {"tof", "time_of_flight", "toa", "delay", "flight_time", "range", "distance", "dist", "tdoa"}},
  };
  const std::string name = lower_case(theirs);
  for (const ColumnNames& c : all) {
    if (c.name != ours) continue;
    for (const std::string_view other : c.others) {
      if (name == other) return true;
      const bool unit_behind = name.size() > other.size() + 1 && name.starts_with(other) &&
                               name[other.size()] == '_' && name.size() <= other.size() + 4;
      if (unit_behind && other.size() > 2) return true;
    }
  }
  return suggestion(ours, {std::string(theirs)}).starts_with("did");
}

}  // namespace

namespace {

constexpr std::size_t kMostColumns = 65536;
constexpr std::ptrdiff_t kMostRow = kLongestLine;
constexpr std::size_t kSpareFields = 64;  // fields too many in a row that an error message still counts

}  // namespace

CsvReader::CsvReader(std::string_view text, std::string file, bool checked)
    : file_(std::move(file)),
      begin_(text.data()),
      at_(without_bom(text).data()),
      end_(text.data() + text.size()) {
  if (!checked)
    if (auto ok = check_lines(text, file_); !ok) error_ = ok.error();
  if (!error_) read_header();
}

bool CsvReader::fail_at(int column, std::string found, std::string expected, std::string advice) {
  if (error_) return false;
  int character = 0;
  if (column >= 0) {
    const auto i = static_cast<std::size_t>(column);
    for (const auto& [field, at] : quoted_columns_) {
      if (field == i) character = at;
    }
    if (character == 0) character = column_in_line(fields_[i].data());
  }
  error_ = Error{.file = file_,
                 .line = row_line_,
                 .column = character,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .advice = std::move(advice)};
  return false;
}

void CsvReader::fail_file(int line, std::string found, std::string expected, std::string advice) {
  if (error_) return;
  error_ = Error{.file = file_,
                 .line = line,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .advice = std::move(advice)};
}

/// From 1, of a place in the current row, which runs over several lines if a quoted field does.
int CsvReader::column_in_line(const char* at) const {
  const std::string_view before(row_, static_cast<std::size_t>(at - row_));
  const std::size_t newline = before.rfind('\n');
  return static_cast<int>(before.size() - (newline == std::string_view::npos ? 0 : newline + 1)) + 1;
}

bool CsvReader::fail_long(int line) {
  fail_file(line, fmt::format("a row of more than {} bytes", kMostRow), "rows of some hundreds",
            "a newline or a closing quote is missing, or the file is of another kind");
  return false;
}

std::string CsvReader::place() const { return fmt::format("{}:{}", file_, row_line_); }

void CsvReader::skip_comments() {
  while (at_ != end_) {
    const char* last = end_ - at_ > kMostRow ? at_ + kMostRow : end_;
    const char* stop = std::find(at_, last, '\n');
    if (stop == last && last != end_) return (void)fail_long(line_);
    const std::string_view line = trimmed(at_, stop);
    if (!line.empty() && line[0] != '#') return;
    at_ = stop == end_ ? end_ : stop + 1;
    if (stop != end_) next_line_of_file();
  }
}

namespace {

/// A table of arrivals need not be exported again.
std::string separator_advice(const std::string& file, std::string_view header, char separator) {
  constexpr std::string_view kTof = "tof.csv",
                             kAgain = "export it again as comma-separated values in English notation";
  if (!file.ends_with(kTof)) return std::string(kAgain);
  std::size_t own = 0;
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(separator), header.size());
    own += static_cast<std::size_t>(std::ranges::any_of(
        kTofColumns, [&](const TofColumn& known) { return header.substr(0, end) == known.name; }));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return fmt::format("octant convert {} {}-o RUN reads it as it is; or {}", file,
                     own >= 3 ? "" : "--columns time=COLUMN,beacon=COLUMN,tof=COLUMN ", kAgain);
}

}  // namespace

void CsvReader::check_separator(std::string_view line) {
  if (line.find(',') != std::string_view::npos) return;
  for (const auto& [c, name] : {std::pair{';', "semicolons"}, {'\t', "tabs"}}) {
    if (line.find(c) == std::string_view::npos) continue;
    fail_file(line_, fmt::format("the fields are separated by {}", name),
              "commas, and points in numbers (1.5)", separator_advice(file_, line, c));
  }
}

void CsvReader::read_header() {
  skip_comments();
  if (error_) return;
  if (at_ == end_) return fail_file(0, "the file is empty", "a header row with the names of the columns");
  check_separator(trimmed(at_, std::find(at_, end_, '\n')));
  if (error_ || !read_fields()) return;
  std::unordered_set<std::string_view> seen;
  for (const std::string_view name : fields_) {
    if (!name.empty() && !seen.insert(name).second) {
      return fail_file(row_line_, fmt::format("column {} is there twice", in_quotes(name)),
                       "each column once");
    }
    header_.emplace_back(name);
    known_.push_back(false);
  }
}

int CsvReader::find(std::string_view name) {
  asked_.emplace_back(name);
  const auto found = std::ranges::find(header_, name);
  if (found == header_.end()) return -1;
  const auto i = found - header_.begin();
  known_[static_cast<std::size_t>(i)] = true;
  return static_cast<int>(i);
}

int CsvReader::require(std::string_view name) {
  const int column = find(name);
  if (column >= 0 || (error_ && missing_.empty())) return column;
  missing_.emplace_back(name);
  double value = 0.0;
  const bool headless = !header_.empty() && std::ranges::all_of(header_, [&](const std::string& text) {
    return parse_number(text, value) == NumberText::kNumber;
  });
  std::vector<std::string> quoted;
  for (const std::string& m : missing_) quoted.push_back(in_quotes(m));
  const bool many = quoted.size() > 1;
  error_.reset();
  fail_file(row_line_,
            fmt::format("column{} {} {} missing (columns: {})", many ? "s" : "", fmt::join(quoted, ", "),
                        many ? "are" : "is", listed(header_, 12)),
            many ? "a header row that names them" : "a header row that names it",
            headless
                ? "the header row itself seems to be missing" + convert_advice("time=#1,beacon=#2,tof=#3")
                : renamed_columns());
  return column;
}

/// Columns of the file that may be the missing ones under another name.
std::string CsvReader::renamed_columns() const {
  std::vector<std::string> guesses;
  for (const std::string& name : missing_)
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (known_[i] || !may_be_called(name, header_[i])) continue;
      guesses.push_back(fmt::format("{} for {}", in_quotes(header_[i]), in_quotes(name)));
      break;
    }
  return guesses.empty()
             ? ""
             : fmt::format("is it {}? Rename the columns, and mind the units that the names state{}",
                           fmt::join(guesses, ", "), convert_advice("time=COLUMN,beacon=COLUMN,tof=COLUMN"));
}

/// Advice for a table of arrivals with other columns; empty for other files.
std::string CsvReader::convert_advice(std::string_view columns) const {
  if (!file_.ends_with("tof.csv")) return "";
  return fmt::format("; octant convert {} --columns {} -o RUN reads the table as it is", file_, columns);
}

std::optional<std::string> CsvReader::unknown_columns() const {
  std::vector<std::string> unknown;
  for (std::size_t i = 0; i < header_.size(); ++i) {
    if (!known_[i]) unknown.push_back(header_[i]);
  }
  if (unknown.empty()) return std::nullopt;
  const std::string hint = suggestion(unknown.front(), asked_);
  return fmt::format("{}: {} unknown column{} ignored: {}{}", file_, unknown.size(),
                     unknown.size() == 1 ? " is" : "s are", listed(unknown),
                     hint.starts_with("did") ? "; " + hint : "");
}

bool CsvReader::next_row() {
  if (error_) return false;
  // Blank lines are no rows.
  while (at_ != end_ && (*at_ == '\n' || is_blank(*at_))) {
    const char* p = at_;
    while (p != end_ && is_blank(*p)) ++p;
    if (p != end_ && *p != '\n') break;
    at_ = p == end_ ? end_ : p + 1;
    next_line_of_file();
  }
  if (at_ == end_) return false;
  return read_fields() && check_count();
}

/// Splits the row at at_ into fields_ and moves at_ behind its newline.
bool CsvReader::read_fields() {
  fields_.clear();
  quoted_columns_.clear();
  if (!unquoted_.empty()) unquoted_.clear();
  row_line_ = line_;
  row_ = at_;
  const std::size_t most = header_.empty() ? kMostColumns : header_.size() + kSpareFields;
  for (const char* p = at_;;) {
    const char* begin = p;
    while (begin != end_ && (*begin == ' ' || *begin == '\t')) ++begin;
    if (begin != end_ && *begin == '"') {
      p = read_quoted(begin);
      if (p == nullptr) return false;
    } else {
      const char* stop = end_ - row_ > kMostRow ? row_ + kMostRow : end_;
      p = find_separator(std::min(begin, stop), stop);
      if (p == stop && stop != end_) return fail_long(row_line_);
      fields_.push_back(trimmed(begin, p));
    }
    if (fields_.size() > most) {
      fail_file(row_line_, fmt::format("more than {} fields", most),
                header_.empty() ? "a header row" : fmt::format("{}, as in the header", header_.size()));
      return false;
    }
    if (p != end_ && *p == ',') {
      ++p;
      continue;
    }
    if (p != end_) next_line_of_file();
    at_ = p == end_ ? end_ : p + 1;
    return true;
  }
}

/// Reads the field that begins with the quote at `at`; returns the separator behind it, null on error.
const char* CsvReader::read_quoted(const char* at) {
  const int opened = line_;
  const char* piece = at + 1;
  std::string* joined = nullptr;
  for (const char* p = piece;; ++p) {
    if (p == end_) {
      fail_file(opened, "a quote that is not closed", "a closing \" behind the field",
                "the file may be cut off");
      return nullptr;
    }
    if (p - row_ > kMostRow) {
      fail_long(opened);
      return nullptr;
    }
    if (*p == '\n') next_line_of_file();
    if (*p != '"') continue;
    if (p + 1 != end_ && p[1] == '"') {  // a doubled quote stands for one
      if (joined == nullptr) joined = &unquoted_.emplace_back();
      joined->append(piece, p + 1);
      piece = ++p + 1;
      continue;
    }
    if (joined != nullptr) joined->append(piece, p);
    fields_.push_back(joined != nullptr ? std::string_view(*joined)
                                        : std::string_view(piece, static_cast<std::size_t>(p - piece)));
    quoted_columns_.emplace_back(fields_.size() - 1, column_in_line(at));
    for (++p; p != end_ && is_blank(*p);) ++p;
    if (p == end_ || *p == ',' || *p == '\n') return p;
    fail_file(opened, "text behind a closing quote", "a comma, or \"\" for a quote within a quoted field");
    return nullptr;
  }
}

bool CsvReader::check_count() {
  if (fields_.size() == header_.size()) return true;
  // A comma at the end of each row is a habit of some programs.
  if (fields_.size() == header_.size() + 1 && fields_.back().empty()) {
    fields_.pop_back();
    return true;
  }
  const bool last = at_ == end_;
  const bool fewer = fields_.size() < header_.size();
  return fail_at(-1, fmt::format("{} field{}", fields_.size(), fields_.size() == 1 ? "" : "s"),
                 fmt::format("{}, as in the header", header_.size()),
                 fewer ? (last ? "the last row is cut off: copy the file again, or delete the row"
                               : "complete or delete the row")
                       : "are there decimal commas, or commas in a name without quotes?");
}

std::size_t CsvReader::rows_left_estimate() const {
  constexpr std::ptrdiff_t kSample = 16384;
  const char* stop = end_ - at_ > kSample ? at_ + kSample : end_;
  const auto lines = static_cast<std::size_t>(std::count(at_, stop, '\n')) + 1;
  const auto sampled = static_cast<std::size_t>(stop - at_);
  return sampled == 0
             ? 0
             : static_cast<std::size_t>(1.02 * static_cast<double>(lines) * static_cast<double>(end_ - at_) /
                                        static_cast<double>(sampled)) +
                   1;
}

bool CsvReader::not_a_number(int column, const char* expected) {
  const std::string_view text = field(column);
  const bool comma = text.find(',') != std::string_view::npos;
  const bool is_time = header_[static_cast<std::size_t>(column)] == "time_s" && time_of_text(text);
  return fail_at(column,
                 fmt::format("{} is {}", header_[static_cast<std::size_t>(column)],
                             text.empty() ? "empty" : in_quotes(text)),
                 expected,
                 is_time
                     ? file_.ends_with("tof.csv")
                           ? fmt::format("octant convert {} -o RUN turns dates and times into seconds", file_)
                           : "seconds, from the same beginning as in the other files of the recording"
                 : comma ? "decimal points, not commas"
                         : "");
}

bool CsvReader::number_or_nan(int column, double& value) {
  switch (parse_number(field(column), value)) {
    case NumberText::kNumber: return true;
    case NumberText::kEmpty: value = std::numeric_limits<double>::quiet_NaN(); return true;
    case NumberText::kNotNumber: break;
  }
  return not_a_number(column, "a number");
}

bool CsvReader::number(int column, double& value) {
  if (parse_number(field(column), value) == NumberText::kNumber && std::isfinite(value)) return true;
  return not_a_number(column, "a finite number");
}

bool CsvReader::length(int column, double& metres) {
  if (!number(column, metres)) return false;
  return std::abs(metres) <= kLargestLength_m || not_a_number(column, kExpectedLength);
}

bool CsvReader::check_angle(int column, double angle_rad) {
  if (!(std::abs(angle_rad) > 2 * M_PI + 1e-6)) return true;
  return fail_at(column, fmt::format("{} is {}", header_[static_cast<std::size_t>(column)], exact(angle_rad)),
                 "radians, at most one turn", "degrees? multiply by pi / 180");
}

bool CsvReader::integer(int column, std::int64_t& value) {
  if (parse_integer(field(column), value)) return true;
  return not_a_number(column, "a whole number");
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_reader.h"

#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "io/clocks/clock_files.h"
#include "io/run/last_row.h"
#include "io/run/run_clock.h"
#include "io/run/run_files.h"
#include "io/run/tum.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::io {
namespace {

/// Requests large pages from the system for long lists, which saves a fifth of the time to read a file.
void prefer_large_pages(void* data, std::size_t bytes) {
  constexpr std::size_t kLarge = std::size_t{1} << 21;
  const auto at = reinterpret_cast<std::uintptr_t>(data);
  const auto begin = (at + kLarge - 1) / kLarge * kLarge, end = (at + bytes) / kLarge * kLarge;
  if (end > begin) (void)::madvise(static_cast<std::byte*>(data) + (begin - at), end - begin, MADV_HUGEPAGE);
}

}  // namespace

RunReader::RunReader(const std::string& folder, const NameTable& names, const Timing& timing,
                     const ReadRunOptions& options)
    : lookup_(names), clock_(timing.clock), options_(options) {
  log_.path = folder;
  if (!(options.constant_speed_mps > 0.0)) return;
  const bool two_way = timing.ranging == Ranging::kTwoWay;
  distance_ = {(two_way ? 2.0 : 1.0) / options.constant_speed_mps, two_way ? timing.turnaround_s : 0.0};
}

Result<void> RunReader::begin() {
  if (auto ok = check_folder(); !ok) return ok;
  if (auto ok = read_header(); !ok) return ok;
  return open_tof();
}

std::string RunReader::path(const char* name) const {
  return log_.path.ends_with('/') ? log_.path + name : log_.path + "/" + name;
}

Result<void> RunReader::check_folder() const { return check_run_folder(log_.path); }

/// Returns true if the name exists. A broken link exists and leads to an error later.
bool RunReader::is_there(const std::string& file) const {
  struct stat status {};
  return ::lstat(file.c_str(), &status) == 0 || errno != ENOENT;
}

/// Content of a file of the folder; no value if the file does not exist.
Result<std::optional<RunReader::RunFileText>> RunReader::load(const char* name) {
  const std::string file = path(name);
  if (!is_there(file)) return std::nullopt;
  auto map = MappedFile::open(file);
  if (!map) return fail(map.error());
  if (auto ok = check_lines(map->text(), file); !ok) return fail(ok.error());
  log_.sha256[file] = sha256_hex(map->text());
  const bool table = !file.ends_with(".yaml");
  const std::size_t size = (table ? without_cut_row(map->text(), file, log_.warnings) : map->text()).size();
  return RunFileText{std::move(*map), size};
}

Result<void> RunReader::read_header() {
  const auto text = load("run.yaml");
  if (!text) return fail(text.error());
  if (lookup_.names().vehicles.empty()) {
    return fail({.file = log_.path, .found = "the site has no vehicle", .expected = "at least one"});
  }
  log_.vehicle = lookup_.default_vehicle;
  if (!*text) return {};
  const auto header = parse_run_yaml((*text)->text(), path("run.yaml"), log_);
  if (!header) return fail(header.error());
  range_max_m_ = header->range_max_m;
  if (header->vehicle.empty()) return {};
  log_.vehicle = lookup_.default_vehicle = lookup_.vehicle(header->vehicle);
  if (log_.vehicle.valid()) return {};
  return fail({.file = path("run.yaml"),
               .found = fmt::format("vehicle {} is not in the site", in_quotes(header->vehicle)),
               .expected = "a vehicle's id",
               .advice = suggestion(header->vehicle, lookup_.names().vehicles)});
}

Result<void> RunReader::open_tof() {
  const std::string file = path("tof.csv");
  if (!is_there(file)) {
    has_clocks_ = has_clock_log(log_.path);
    return {};
  }
  auto map = MappedFile::open(file);
  if (!map) return fail(map.error());
  tof_map_ = std::make_shared<const MappedFile>(std::move(*map));
  const std::string_view whole = without_cut_row(tof_map_->text(), file, log_.warnings);
  tof_ = std::make_unique<TofReader>(
      tof_map_, file, lookup_, clock_,
      TofReaderOptions{.threads = options_.threads, .to = whole.size(), .distance = distance_});
  if (auto ok = tof_->read_header(); !ok) return ok;
  has_tof_ = true;
  log_.has_epochs = log_.has_epochs || tof_->has_epochs();
  return {};
}

Result<bool> RunReader::next_arrivals(std::vector<Arrival>& block) {
  block.clear();
  return append_arrivals(block);
}

Result<bool> RunReader::append_arrivals(std::vector<Arrival>& all) {
  if (!tof_) return false;
  const std::size_t before = all.size();
  auto more = tof_->append(all);
  if (!more) return more;
  auto refused = tof_->refusals().take();
  log_.rejected.insert(log_.rejected.end(), std::make_move_iterator(refused.begin()),
                       std::make_move_iterator(refused.end()));
  log_.rows = tof_->rows();
  if (arrivals_ == 0 && all.size() > before) {
    first_vehicle_ = all[before].vehicle;
    first_time_s_ = all[before].time_s;
  }
  for (std::size_t i = before; i < all.size(); ++i) time_unit_.add(all[i].time_s);
  arrivals_ += all.size() - before;
  if (*more) return true;
  const auto warnings = tof_->warnings();
  log_.warnings.insert(log_.warnings.end(), warnings.begin(), warnings.end());
  if (const auto unit = time_unit_.note(path("tof.csv"))) log_.warnings.push_back(*unit);
  clock_of_tof_ = tof_->clock();
  log_.sha256[path("tof.csv")] = tof_->sha256();
  end_ = tof_->position();
  tof_.reset();
  return false;
}

Result<void> RunReader::read_again(TofPosition from, TofPosition to, std::vector<Arrival>& arrivals) const {
  TofReader again(tof_map_, path("tof.csv"), lookup_, clock_,
                  {.from = from, .to = to.offset, .distance = distance_});
  if (auto ok = again.read_header(); !ok) return ok;
  for (;;) {
    const auto more = again.append(arrivals);
    if (!more) return fail(more.error());
    if (!*more) return {};
  }
}

/// Time differences as arrivals with an unknown offset in each epoch.
Result<void> RunReader::read_differences() {
  if (clock_ != Clock::kCycleOffset)
    return fail({.file = is_there(path("tdoa.csv")) ? path("tdoa.csv") : path("toa.csv"),
                 .found = "timing.clock of the site is synchronised, which has times of flight",
                 .expected = "clock: free, or cycle_offset where the beacons share one clock"});
  std::vector<InputDigest> inputs;
  auto clocks = read_clock_log(log_.path, lookup_.names(), &inputs);
  if (!clocks) return fail(clocks.error());
  for (const InputDigest& input : inputs) log_.sha256[input.path] = input.sha256;
  log_.warnings.insert(log_.warnings.end(), clocks->warnings.begin(), clocks->warnings.end());
  std::size_t left_out = 0;
  log_.arrivals = arrivals_of(clocks->differences, left_out);
  log_.rows = clocks->differences.size();
  log_.has_epochs = true;
  arrivals_ = log_.arrivals.size();
  if (log_.arrivals.empty()) return {};
  first_vehicle_ = log_.arrivals.front().vehicle;
  first_time_s_ = log_.arrivals.front().time_s;
  return {};
}

Result<void> RunReader::read_arrivals() {
  if (has_clocks_) return read_differences();
  if (tof_) {
    log_.arrivals.reserve(tof_->rows_estimate());
    prefer_large_pages(log_.arrivals.data(), log_.arrivals.capacity() * sizeof(Arrival));
  }
  for (;;) {
    const auto more = append_arrivals(log_.arrivals);
    if (!more) return fail(more.error());
    if (!*more) return {};
  }
}

Result<void> RunReader::read_others() {
  for (const auto part : {&RunReader::read_bearings, &RunReader::read_scans, &RunReader::read_odometry}) {
    if (auto ok = (this->*part)(); !ok) return ok;
  }
  align_periods(log_.bearings, first_time_s_, clock_of_tof_);
  align_periods(log_.scans, first_time_s_, clock_of_tof_);
  align_periods(log_.odometry, first_time_s_, clock_of_tof_);
  if (options_.read_poses) {
    if (auto ok = read_track("poses.tum", log_.poses); !ok) return ok;
    if (auto ok = read_points("points.csv", "poses.tum", log_.poses, log_.pose_accuracy); !ok) return ok;
  }
  if (!options_.read_truth) return {};
  if (auto ok = read_track("truth.tum", log_.truth); !ok) return ok;
  return read_points("truth.csv", "truth.tum", log_.truth, log_.truth_accuracy);
}

Result<void> RunReader::read_points(const char* name, const char* instead_of, std::vector<TimedPose>& poses,
                                    PoseAccuracy& accuracy) {
  const auto text = load(name);
  if (!text) return fail(text.error());
  if (!*text) return {};
  if (tof_) {
    // The arrivals of a stream have not been read, so only the existence of measured poses is known.
    poses.resize(1);
    return {};
  }
  if (!poses.empty())
    return fail({.file = path(name),
                 .found = fmt::format("there is {} too", instead_of),
                 .expected = "one of them: poses by time, or points by epoch"});
  auto points = parse_points((*text)->text(), path(name), lookup_, log_, accuracy);
  if (!points) return fail(points.error());
  poses = std::move(*points);
  return {};
}

Result<void> RunReader::read_bearings() {
  const auto text = load("bearings.csv");
  if (!text) return fail(text.error());
  return *text ? parse_bearings((*text)->text(), path("bearings.csv"), lookup_, log_) : Result<void>{};
}

Result<void> RunReader::read_scans() {
  const auto text = load("scans.csv");
  if (!text) return fail(text.error());
  return *text ? parse_scans((*text)->text(), path("scans.csv"), range_max_m_, log_) : Result<void>{};
}

Result<void> RunReader::read_odometry() {
  const auto text = load("odometry.csv");
  if (!text) return fail(text.error());
  if (*text)
    if (auto ok = parse_odometry((*text)->text(), path("odometry.csv"), lookup_, log_); !ok) return ok;
  std::vector<TimedPose> track;
  if (auto ok = read_track("odometry.tum", track); !ok || track.empty()) return ok;
  if (!log_.odometry.empty())
    return fail({.file = path("odometry.tum"),
                 .found = "odometry.csv is there too",
                 .expected = "one of them",
                 .advice = "remove the other one"});
  log_.odometry = steps_between(track, log_.vehicle.valid() ? log_.vehicle : VehicleId(0));
  return {};
}

Result<void> RunReader::read_track(const char* name, std::vector<TimedPose>& poses) {
  const auto text = load(name);
  if (!text) return fail(text.error());
  if (!*text) return {};
  ContinuedClock clock;
  auto track = tum_from_text((*text)->text(), path(name), &clock);
  if (!track) return fail(track.error());
  if (const auto restarts = clock.note(path(name))) log_.warnings.push_back(*restarts);
  poses = std::move(*track);
  align_periods(poses, first_time_s_, clock.period_s() > 0.0 ? clock : clock_of_tof_);
  if (poses.empty() || log_.vehicle.valid()) return {};
  return fail({.file = path(name),
               .found = fmt::format("the vehicle of these poses is not stated: the site has {} vehicles",
                                    lookup_.names().vehicles.size()),
               .expected = "'vehicle: ...' in run.yaml"});
}

Result<void> RunReader::finish() {
  if (!log_.vehicle.valid()) {
    log_.vehicle = arrivals_ > 0           ? first_vehicle_
                   : log_.bearings.empty() ? VehicleId(0)
                                           : log_.bearings.front().vehicle;
  }
  restore_sorted_restart(log_, path("tof.csv"));
  if (arrivals_ > 0 || has_clocks_ || !log_.bearings.empty() || !log_.scans.empty()) return {};
  if (!log_.rejected.empty()) {
    return fail({.file = path("tof.csv"),
                 .line = log_.rejected.front().line,
                 .found = fmt::format("no arrival is left: all {} were rejected, here because {}",
                                      log_.rejected.size(), log_.rejected.front().reason),
                 .expected = "times of flight in seconds"});
  }
  return fail({.file = has_tof_ ? path("tof.csv") : log_.path,
               .found = has_tof_
                            ? "no arrivals: there are no rows under the header"
                            : "the folder holds none of tof.csv, tdoa.csv, toa.csv, bearings.csv, scans.csv",
               .expected = has_tof_ ? "at least one row here, in bearings.csv or in scans.csv"
                                    : "at least one of them",
               .advice = has_tof_ ? "" : advice_where_no_run_is(log_.path)});
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/recorder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "io/text/atomic_file.h"
#include "io/text/text.h"

namespace octant::app {
namespace {

/// Consecutive late rows after which the sender's clock was set back; as in Follower.
constexpr std::size_t kRowsOfSetClock = 20;
constexpr std::size_t kMostListedStops = 5000;  ///< that are shown; the run has all of them
constexpr const char* kEpochHeader =
    "time_s,epoch,tof_s,beacon,vehicle,receiver,amplitude_v,temperature_degC\n";
constexpr const char* kDriveHeader = "time_s,tof_s,beacon,vehicle,receiver,amplitude_v,temperature_degC\n";
constexpr const char* kUnusedHeader =
    "time_s,epoch,tof_s,beacon,vehicle,receiver,amplitude_v,temperature_degC,reason\n";

tl::unexpected<Error> not_now(std::string found, std::string expected) {
  return fail({.code = Errc::kUsage, .found = std::move(found), .expected = std::move(expected)});
}

/// Epoch of a row of our own tof.csv: its second field.
std::optional<std::int64_t> epoch_of_row(std::string_view row) {
  const std::size_t comma = row.find(',');
  std::int64_t epoch = 0;
  if (comma == std::string_view::npos ||
      std::from_chars(row.data() + comma + 1, row.data() + row.size(), epoch).ec != std::errc())
    return std::nullopt;
  return epoch;
}

}  // namespace

RunRecorder::RunRecorder(std::string folder, NameTable names, Motion motion, double lateness_s)
    : folder_(std::move(folder)), motion_(motion), lateness_s_(lateness_s) {
  set_names(std::move(names));
}

void RunRecorder::set_names(NameTable names) {
  names_ = std::move(names);
  for (auto* fields : {&beacon_fields_, &vehicle_fields_, &receiver_fields_}) fields->clear();
  for (const auto& name : names_.beacons) beacon_fields_.push_back(io::csv_field(name));
  for (const auto& name : names_.vehicles) vehicle_fields_.push_back(io::csv_field(name));
  for (const auto& receiver : names_.receivers) receiver_fields_.push_back(io::csv_field(receiver.name));
}

Result<void> RunRecorder::begin(const std::string& run_yaml) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) return fail({.code = Errc::kOutput, .file = folder_, .found = error.message()});
  odometry_ = std::make_unique<AppendFile>(
      folder_ + "/odometry.csv",
      std::string(motion_ == Motion::kPlanar ? "time_s,dx_m,dy_m,dheading_rad,vehicle\n"
                                             : "time_s,dx_m,dy_m,dz_m,qx,qy,qz,qw,vehicle\n"));
  unused_ = std::make_unique<AppendFile>(folder_ + "/unused.csv", kUnusedHeader);
  return io::write_file(folder_ + "/run.yaml", run_yaml);
}

template <class Row>
bool RunRecorder::insert(Waiting<Row>& waiting, Row& row) {
  row.time_s += offset_s_;
  if (row.time_s < std::max(waiting.written_s, waiting.newest_s - lateness_s_)) {
    if (++waiting.behind < kRowsOfSetClock) return false;
    // Readers refuse times that decrease, so the old clock is continued.
    const double step_s = newest_s_ + lateness_s_ - row.time_s;
    offset_s_ += step_s;
    row.time_s += step_s;
    ++counts_.clock_steps;
  }
  waiting.behind = 0;
  waiting.newest_s = std::max(waiting.newest_s, row.time_s);
  newest_s_ = std::max(newest_s_, row.time_s);
  auto at = waiting.rows.end();
  while (at != waiting.rows.begin() && std::prev(at)->time_s > row.time_s) --at;
  waiting.rows.insert(at, row);
  return true;
}

void RunRecorder::choose_mode(const Arrival& arrival) {
  const bool has_epoch = arrival.epoch != kNoEpoch;
  if (mode_ == StopMode::kUndecided) mode_ = has_epoch ? StopMode::kRows : StopMode::kDrive;
  if (mode_ == StopMode::kDrive && has_epoch && counts_.odometry == 0 && leave_drive())
    mode_ = StopMode::kRows;
  if (tof_) return;
  tof_ = std::make_unique<AppendFile>(folder_ + "/tof.csv",
                                      mode_ == StopMode::kDrive ? kDriveHeader : kEpochHeader);
}

/// A run has epochs in all of its rows or in none: rows before the first stop remain in a file of their own.
Result<void> RunRecorder::leave_drive() {
  if (!tof_) return {};
  if (auto flushed = flush(true); !flushed) return flushed;
  const std::string moving = folder_ + "/moving.csv";
  std::error_code error;
  std::filesystem::rename(tof_->path(), moving, error);
  if (error && counts_.arrivals > 0)
    return fail({.code = Errc::kOutput, .file = moving, .found = error.message()});
  tof_.reset();
  counts_.between_stops += std::exchange(counts_.arrivals, 0);
  arrivals_ = {};
  return {};
}

/// A sender that begins again with a clock that was set back also counts its stops from the beginning.
void RunRecorder::continue_epochs(Arrival& arrival) {
  if (mode_ != StopMode::kRows || arrival.epoch == kNoEpoch) return;
  Epochs& of = epochs_[static_cast<std::uint32_t>(arrival.vehicle.index())];
  if (std::exchange(of.clock_steps, counts_.clock_steps) != counts_.clock_steps)
    of.offset = arrival.epoch <= of.largest ? of.largest + 1 : 0;
  std::int64_t continued = 0;
  if (!__builtin_add_overflow(arrival.epoch, of.offset, &continued)) arrival.epoch = continued;
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max() - 1;
  of.largest = std::clamp(arrival.epoch, of.largest, kLargest);
}

void RunRecorder::add(Arrival arrival) {
  choose_mode(arrival);
  if (mode_ == StopMode::kMarked) arrival.epoch = open_stop_.value_or(kNoEpoch);
  if (!insert(arrivals_, arrival)) {
    ++counts_.late;
    return write_unused(arrival, "late");
  }
  auto at = std::prev(arrivals_.rows.end());
  while (at->time_s > arrival.time_s) --at;
  continue_epochs(*at);
}

void RunRecorder::add_unknown(const Arrival& arrival, const char* reason) {
  ++counts_.unknown;
  write_unused(arrival, reason);
}

void RunRecorder::add(OdometryStep step) {
  if (insert(steps_, step)) return;
  ++counts_.late_odometry;
  Pose& late = late_step_[static_cast<std::uint32_t>(step.vehicle.index())];
  late = late * step.pose();
}

void RunRecorder::add(OdometryPose pose) {
  if (!insert(poses_, pose)) ++counts_.late_odometry;
}

bool RunRecorder::append(AppendFile& file, const std::string& row) {
  const bool has_room = file.add(row);
  if (!has_room) ++counts_.lost;
  return has_room;
}

std::string RunRecorder::row_of(const Arrival& a, bool with_epoch) const {
  const std::string epoch = a.epoch == kNoEpoch ? "" : fmt::format("{}", a.epoch);
  return fmt::format("{},{}{}{},{},{},{},{},{}", a.time_s, epoch, with_epoch ? "," : "", a.tof_s,
                     beacon_fields_[a.beacon.index()], vehicle_fields_[a.vehicle.index()],
                     receiver_fields_[a.receiver.index()], io::number_field(a.amplitude_v),
                     io::number_field(a.temperature_degC));
}

void RunRecorder::write_unused(const Arrival& arrival, const char* reason) {
  append(*unused_, row_of(arrival, true) + fmt::format(",{}\n", reason));
}

void RunRecorder::write(const Arrival& arrival) {
  arrivals_.written_s = arrival.time_s;
  if (mode_ == StopMode::kDrive) {
    Arrival moving = arrival;
    moving.epoch = kNoEpoch;
    if (append(*tof_, row_of(moving, false) + "\n")) ++counts_.arrivals;
    return;
  }
  const auto vehicle = static_cast<std::uint32_t>(arrival.vehicle.index());
  if (arrival.epoch == kNoEpoch || finished_epochs_.contains({vehicle, arrival.epoch})) {
    const bool is_between = arrival.epoch == kNoEpoch;
    ++(is_between ? counts_.between_stops : counts_.stop_is_over);
    return write_unused(arrival, is_between ? "between_stops" : "stop_is_over");
  }
  const auto current = current_epoch_.try_emplace(vehicle, arrival.epoch).first;
  if (current->second != arrival.epoch) {
    finished_epochs_.insert({vehicle, current->second});
    current->second = arrival.epoch;
  }
  if (!append(*tof_, row_of(arrival, true) + "\n")) return;
  ++counts_.arrivals;
  RecordedStop& stop = stops_[arrival.epoch];
  if (stop.arrivals++ == 0) stop.first_s = arrival.time_s;
  if (stop.arrivals == 1 && points_.contains(arrival.epoch)) (void)set_points();
  stop.last_s = arrival.time_s;
  stop.beacons.insert(static_cast<std::uint32_t>(arrival.beacon.index()));
  if (stops_.size() > kMostListedStops) stops_.erase(stops_.begin());
}

void RunRecorder::write(const OdometryPose& pose) {
  poses_.written_s = pose.time_s;
  const auto vehicle = static_cast<std::uint32_t>(pose.vehicle.index());
  OdometryStep step{.time_s = pose.time_s, .vehicle = pose.vehicle};
  if (const auto last = last_pose_.find(vehicle); last != last_pose_.end())
    step.set_pose(last->second.inverse() * pose.T_odometry_vehicle);
  last_pose_[vehicle] = pose.T_odometry_vehicle;
  write_step(step);
}

void RunRecorder::write_step(OdometryStep step) {
  steps_.written_s = step.time_s;
  const auto vehicle = static_cast<std::uint32_t>(step.vehicle.index());
  const bool is_first = anchored_.insert(vehicle).second;
  if (is_first) step.set_pose(Pose());
  if (const auto late = late_step_.find(vehicle); late != late_step_.end()) {
    if (!is_first) step.set_pose(late->second * step.pose());
    late_step_.erase(late);
  }
  std::string row = fmt::format("{},{},{},", step.time_s, step.dx_m, step.dy_m);
  if (motion_ == Motion::kPlanar) {
    row += fmt::format("{}", step.dheading_rad);
  } else {
    const Eigen::Quaterniond q = step.pose().rotation;
    row += fmt::format("{},{},{},{},{}", step.dz_m, q.x(), q.y(), q.z(), q.w());
  }
  if (append(*odometry_, row + "," + vehicle_fields_[step.vehicle.index()] + "\n")) ++counts_.odometry;
}

Result<void> RunRecorder::flush(bool all) {
  const double until_s = all ? std::numeric_limits<double>::infinity() : newest_s_ - lateness_s_;
  const auto write_until = [until_s](auto& waiting, auto&& write_row) {
    for (; !waiting.rows.empty() && waiting.rows.front().time_s <= until_s; waiting.rows.pop_front())
      write_row(waiting.rows.front());
  };
  write_until(steps_, [this](const OdometryStep& step) { write_step(step); });
  write_until(poses_, [this](const OdometryPose& pose) { write(pose); });
  write_until(arrivals_, [this](const Arrival& arrival) { write(arrival); });
  for (AppendFile* file : {odometry_.get(), tof_.get(), unused_.get()})
    if (file != nullptr)
      if (auto done = file->flush(); !done) {
        written_counts_.lost = counts_.lost;
        return done;
      }
  written_counts_ = counts_;
  return {};
}

std::vector<int> RunRecorder::descriptors() const {
  std::vector<int> copies;
  for (const AppendFile* file : {odometry_.get(), tof_.get(), unused_.get()})
    if (const int copy = file != nullptr ? file->duplicate() : -1; copy >= 0) copies.push_back(copy);
  return copies;
}

Result<std::int64_t> RunRecorder::begin_stop() {
  if (mode_ == StopMode::kRows)
    return not_now("the rows carry the epoch of their stop", "no stops that are marked by hand");
  if (counts_.odometry > 0)
    return not_now("the stream has odometry, so the run is a drive", "a drive has no stops");
  if (open_stop_) return not_now(fmt::format("stop {} is open", *open_stop_), "end it first");
  if (mode_ == StopMode::kDrive)
    if (auto left = leave_drive(); !left) return fail(left.error());
  mode_ = StopMode::kMarked;
  open_stop_ = next_stop_++;
  return *open_stop_;
}

Result<void> RunRecorder::end_stop() {
  if (!open_stop_) return not_now("no stop is open", "begin a stop first");
  if (auto flushed = flush(true); !flushed) return flushed;
  if (points_.contains(*open_stop_) && !stops_.contains(*open_stop_))
    return not_now(fmt::format("stop {} has a control point and no arrival", *open_stop_),
                   "wait for arrivals here, or delete the stop");
  open_stop_.reset();
  return {};
}

Result<void> RunRecorder::delete_stop(std::int64_t epoch) {
  if (auto flushed = flush(true); !flushed) return flushed;
  if (!stops_.contains(epoch) && open_stop_ != epoch)
    return not_now(fmt::format("there is no stop {}", epoch), "a stop of the list");
  if (!tof_) return forget_stop(epoch, 0);
  auto text = io::read_file(tof_->path());
  if (!text) return fail(text.error());
  std::string kept;
  std::size_t deleted = 0;
  for (std::string_view rest = *text; !rest.empty();) {
    const std::string_view row = rest.substr(0, std::min(rest.find('\n'), rest.size() - 1) + 1);
    rest.remove_prefix(row.size());
    if (epoch_of_row(row) == epoch) {
      append(*unused_, fmt::format("{},deleted\n", row.substr(0, row.size() - 1)));
      ++deleted;
    } else {
      kept += row;
    }
  }
  // First the rows in unused.csv, then the new table: whatever happens, no row is lost.
  if (auto flushed = unused_->flush(); !flushed) return flushed;
  if (auto written = io::write_file(tof_->path(), kept); !written) return written;
  tof_->reopen();
  return forget_stop(epoch, deleted);
}

Result<void> RunRecorder::forget_stop(std::int64_t epoch, std::size_t deleted) {
  if (open_stop_ == epoch) open_stop_.reset();
  for (const auto& [vehicle, current] : current_epoch_) finished_epochs_.insert({vehicle, epoch});
  counts_.arrivals -= deleted;
  counts_.deleted += deleted;
  written_counts_ = counts_;
  stops_.erase(epoch);
  if (points_.erase(epoch) == 0) return {};
  return set_points();
}

Result<void> RunRecorder::set_point(std::int64_t epoch, const ControlPoint& point) {
  if (!stops_.contains(epoch) && open_stop_ != epoch)
    return not_now(fmt::format("there is no stop {}", epoch), "a stop of the list");
  points_[epoch] = point;
  return set_points();
}

Result<void> RunRecorder::set_points() {
  std::string text = "epoch,x_m,y_m,sigma_m\n";
  bool is_empty = true;
  for (const auto& [epoch, point] : points_) {
    if (epoch == open_stop_ && !stops_.contains(epoch)) continue;  // it has no arrival yet
    text += fmt::format("{},{},{},{}\n", epoch, point.x_m, point.y_m, point.sigma_m);
    is_empty = false;
  }
  const std::string path = folder_ + "/points.csv";
  if (!is_empty) return io::write_file(path, text);
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  return {};
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/foreign_logs.h"

#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "io/text/bounds.h"
#include "io/text/csv.h"
#include "io/text/open_file.h"
#include "io/text/text.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

constexpr double kNothingSeen_m =
    80.0;  ///< CARMEN's lasers write 81.83 and similar values when a beam has no return
constexpr std::size_t kMostBeams = 4096;

/// Words of one line of a CARMEN log, read from its beginning.
class CarmenLine {
 public:
  CarmenLine(std::string_view line, const std::string& file, int number)
      : line_(line), file_(file), number_(number) {}

  std::string_view word() {
    at_ = line_.find_first_not_of(" \t\r", at_);
    if (at_ == std::string_view::npos) {
      at_ = begin_ = line_.size();
      return {};
    }
    const std::size_t end = std::min(line_.find_first_of(" \t\r", at_), line_.size());
    const std::string_view word = line_.substr(at_, end - at_);
    begin_ = at_;
    at_ = end;
    return word;
  }
  bool number(const char* what, double& value) {
    const std::string_view text = word();
    if (parse_number(text, value) == NumberText::kNumber && std::isfinite(value)) return true;
    if (!error_)
      error_ = Error{.code = Errc::kBadInput,
                     .file = file_,
                     .line = number_,
                     .column = static_cast<int>(begin_) + 1,
                     .found = text.empty() ? fmt::format("the line ends before {}", what) : in_quotes(text),
                     .expected = fmt::format("{}, a number", what),
                     .advice = "is this a CARMEN log, and whole?"};
    return false;
  }
  bool count(const char* what, std::size_t& value) {
    double number_read = 0.0;
    if (!number(what, number_read)) return false;
    if (number_read >= 0 && number_read <= static_cast<double>(kMostBeams) &&
        number_read == std::floor(number_read)) {
      value = static_cast<std::size_t>(number_read);
      return true;
    }
    error_ = Error{.code = Errc::kBadInput,
                   .file = file_,
                   .line = number_,
                   .column = static_cast<int>(begin_) + 1,
                   .found = fmt::format("{} of {}", what, number_read),
                   .expected = fmt::format("a whole number from 0 to {}", kMostBeams),
                   .advice = "is this a CARMEN log?"};
    return false;
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  std::string_view line_;
  const std::string& file_;
  int number_;
  std::size_t at_ = 0, begin_ = 0;
  std::optional<Error> error_;
};

struct CarmenPose {
  double x_m = 0.0, y_m = 0.0, heading_rad = 0.0;
};

class CarmenReader {
 public:
  explicit CarmenReader(const std::string& path) { log_.path = path; }

  Result<MeasurementLog> read(std::string_view text) {
    for (int number = 1; !text.empty(); ++number) {
      CarmenLine words(take_line(text), log_.path, number);
      line(words);
      if (words.error()) return fail(*words.error());
    }
    if (log_.scans.empty() && log_.odometry.empty())
      return fail({.code = Errc::kBadInput,
                   .file = log_.path,
                   .found = "neither scans nor odometry",
                   .expected = "lines that begin with FLASER, ROBOTLASER1 or ODOM",
                   .advice = "is this a CARMEN log?"});
    for (const auto& [name, count] : passed_over_)
      log_.warnings.push_back(fmt::format("{}: {} {} lines are passed over", log_.path, count, name));
    if (backwards_ > 0)
      log_.warnings.push_back(
          fmt::format("{}: {} lines go back in time and are left out", log_.path, backwards_));
    log_.vehicle = VehicleId(0);
    return std::move(log_);
  }

 private:
  void line(CarmenLine& words) {
    const std::string name(words.word());
    if (name.empty() || name.front() == '#' || name == "PARAM") return;
    if (name == "ODOM") return odometry(words);
    if (name == "FLASER") return scan_ahead(words);
    if (name == "ROBOTLASER1") return scan_with_angles(words);
    ++passed_over_[name];
  }

  /// ODOM x y theta tv rv accel ipc_time host logger_time
  void odometry(CarmenLine& words) {
    CarmenPose pose;
    double skipped = 0.0, time_s = 0.0;
    if (!read_pose(words, pose)) return;
    for (const char* what : {"tv", "rv", "accel"})
      if (!words.number(what, skipped)) return;
    if (read_time(words, time_s)) moved(time_s, pose);
  }

  /// FLASER n range... x y theta odom_x odom_y odom_theta ipc_time host logger_time
  void scan_ahead(CarmenLine& words) {
    Scan scan;
    if (!ranges(words, "the number of readings", scan)) return;
    const auto beams = static_cast<double>(scan.range_m.size());
    scan.angle_min_rad = -std::numbers::pi / 2;
    scan.angle_increment_rad = std::numbers::pi / (scan.range_m.size() % 2 == 1 ? beams - 1 : beams);
    CarmenPose laser, robot;
    if (!read_pose(words, laser) || !read_pose(words, robot) || !read_time(words, scan.time_s)) return;
    take(std::move(scan), robot);
  }

  /// ROBOTLASER1 type start fov resolution max_range accuracy mode n range... m remission... laser pose,
  /// robot pose, tv rv forward_safety side_safety turn_axis ipc_time host logger_time
  void scan_with_angles(CarmenLine& words) {
    Scan scan;
    double skipped = 0.0, longest_m = 0.0;
    if (!words.number("the laser's type", skipped) || !words.number("the start angle", scan.angle_min_rad) ||
        !words.number("the field of view", skipped) ||
        !words.number("the angular resolution", scan.angle_increment_rad) ||
        !words.number("the maximum range", longest_m) || !words.number("the accuracy", skipped) ||
        !words.number("the remission mode", skipped) || !ranges(words, "the number of readings", scan))
      return;
    for (double& r : scan.range_m)
      if (r >= longest_m) r = NAN;
    std::size_t remissions = 0;
    if (!words.count("the number of remissions", remissions)) return;
    for (std::size_t i = 0; i < remissions; ++i)
      if (!words.number("a remission", skipped)) return;
    CarmenPose laser, robot;
    if (!read_pose(words, laser) || !read_pose(words, robot)) return;
    for (const char* what : {"tv", "rv", "forward_safety_dist", "side_safety_dist", "turn_axis"})
      if (!words.number(what, skipped)) return;
    if (read_time(words, scan.time_s)) take(std::move(scan), robot);
  }

  static bool ranges(CarmenLine& words, const char* what, Scan& scan) {
    std::size_t beams = 0;
    if (!words.count(what, beams)) return false;
    scan.range_m.resize(beams);
    for (double& r : scan.range_m) {
      if (!words.number("a range", r)) return false;
      if (r >= kNothingSeen_m || r <= 0) r = NAN;
    }
    return true;
  }

  static bool read_pose(CarmenLine& words, CarmenPose& pose) {
    return words.number("x", pose.x_m) && words.number("y", pose.y_m) &&
           words.number("theta", pose.heading_rad);
  }
  static bool read_time(CarmenLine& words, double& time_s) {
    double sent_s = 0.0;
    if (!words.number("the time of sending", sent_s)) return false;
    static_cast<void>(words.word());  // the host
    return words.number("the logger's time", time_s);
  }

  void take(Scan scan, const CarmenPose& robot) {
    if (!moved(scan.time_s, robot)) return;
    log_.scans.push_back(std::move(scan));
  }

  /// Adds the pose of the odometry at a time; false if the time precedes that of an earlier line.
  bool moved(double time_s, const CarmenPose& now) {
    if (!log_.odometry.empty() && time_s < log_.odometry.back().time_s) {
      ++backwards_;
      return false;
    }
    if (!log_.odometry.empty() && time_s == log_.odometry.back().time_s) return true;
    OdometryStep step;
    step.time_s = time_s;
    step.vehicle = VehicleId(0);
    if (!log_.odometry.empty()) {
      const double c = std::cos(before_.heading_rad), s = std::sin(before_.heading_rad);
      const double dx = now.x_m - before_.x_m, dy = now.y_m - before_.y_m;
      step.dx_m = c * dx + s * dy;
      step.dy_m = -s * dx + c * dy;
      step.dheading_rad = wrap_angle(now.heading_rad - before_.heading_rad);
    }
    log_.odometry.push_back(step);
    before_ = now;
    return true;
  }

  MeasurementLog log_;
  CarmenPose before_;
  std::map<std::string, std::size_t> passed_over_;
  std::size_t backwards_ = 0;
};

}  // namespace

bool is_carmen_log(const std::string& path) {
  constexpr std::size_t kHead = std::size_t{1} << 16;  // bytes in which a message follows the parameters
  const auto map = MappedFile::open(path);
  if (!map) return false;
  std::string_view head = map->text().substr(0, kHead);
  while (!head.empty()) {
    const std::string_view line = take_line(head);
    for (const char* message : {"FLASER ", "ROBOTLASER1 ", "ODOM ", "PARAM ", "RLASER "})
      if (line.starts_with(message)) return true;
  }
  return false;
}

Result<MeasurementLog> read_carmen_log(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (auto ok = check_lines(map->text(), path); !ok) return fail(ok.error());
  return CarmenReader(path).read(map->text());
}

Result<std::vector<CounterReading>> read_counter_log(const std::string& path, const NameTable& names) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  CsvReader csv(map->text(), path);
  const int time = csv.require("time_s"), beacon = csv.require("beacon"), counts = csv.require("counts"),
            epoch = csv.find("epoch"), receiver = csv.find("receiver");
  const auto index_of = [&csv](int column, const std::vector<std::string>& known, const char* what,
                               std::size_t& index) {
    const std::string_view name = csv.field(column);
    for (index = 0; index < known.size(); ++index)
      if (known[index] == name) return true;
    return csv.fail_at(column, in_quotes(name), fmt::format("a {} of the site file", what),
                       suggestion(name, known));
  };
  std::vector<std::string> receivers;
  for (const auto& r : names.receivers) receivers.push_back(r.name);
  std::vector<CounterReading> readings;
  while (csv.next_row()) {
    CounterReading r;
    std::int64_t whole = 0;
    std::size_t index = 0;
    if (!csv.number(time, r.time_s) || !csv.integer(counts, whole) ||
        !index_of(beacon, names.beacons, "beacon", index))
      break;
    r.beacon = BeaconId(index);
    if (whole < 0 && !csv.fail_at(counts, fmt::format("{}", whole),
                                  "counts of the clock since the pulse was sent, not negative"))
      break;
    r.counts = static_cast<std::uint64_t>(whole);
    if (epoch >= 0 && !csv.integer(epoch, r.epoch)) break;
    if (receiver >= 0) {
      if (!index_of(receiver, receivers, "receiver", index)) break;
      r.receiver = ReceiverId(index);
    } else if (receivers.size() > 1) {
      csv.fail_at(-1, "no column 'receiver'", "one, as the site file has several receivers");
      break;
    }
    r.line = csv.line();
    readings.push_back(r);
  }
  if (csv.error()) return fail(*csv.error());
  return readings;
}

Result<std::vector<PulseArrival>> read_pulse_log(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  CsvReader csv(map->text(), path);
  const int time = csv.require("time_s"), channel = csv.require("channel"),
            duration = csv.require("duration_s"), amplitude = csv.require("amplitude_v");
  std::vector<PulseArrival> pulses;
  while (csv.next_row()) {
    PulseArrival p;
    std::int64_t number = 0;
    if (!csv.number(time, p.time_s) || !csv.integer(channel, number) || !csv.number(duration, p.duration_s) ||
        !csv.number(amplitude, p.amplitude_v))
      break;
    if ((number < 0 || number >= PulseSync::kChannels) &&
        !csv.fail_at(channel, fmt::format("{}", number),
                     fmt::format("a channel from 0 to {}", PulseSync::kChannels - 1)))
      break;
    p.channel = static_cast<int>(number);
    if (!(p.duration_s > 0) &&
        !csv.fail_at(duration, exact(p.duration_s), "the length of the pulse, more than 0"))
      break;
    pulses.push_back(p);
  }
  if (csv.error()) return fail(*csv.error());
  return pulses;
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/live/follow.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/live/bad_lines.h"
#include "apps/octant/live/byte_source.h"
#include "apps/octant/options.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/steps/validity_words.h"
#include "io/live/live_fixes.h"
#include "io/live/live_rows.h"
#include "io/live/mavlink.h"
#include "io/run/run_folder.h"
#include "models/live/follower.h"

namespace octant::app {
namespace {

constexpr int kQuiet_ms = 50;         ///< quiet time after which an open pose is complete
constexpr int kQuietEpoch_ms = 2000;  ///< quiet time for an epoch, in which beacons send in turn

constexpr double kNorth_deg = 90.0;  ///< direction of north in the map by default: y points north

volatile std::sig_atomic_t hangups = 0;
extern "C" void on_hangup(int) { hangups = hangups + 1; }

/// Objects that belong to one deployment.
struct Engine {
  Engine(Deployment deployment, const FollowOptions& options)
      : names(names_of(deployment)),
        reader(names, constant_speed_mps(deployment.medium)),
        follower(std::move(deployment), options) {}
  NameTable names;
  io::LiveReader reader;
  Follower follower;
};

class FollowLoop {
 public:
  FollowLoop(const FollowArgs& args, std::string deployment, std::string trusted_key, FollowOptions options,
             Session& session)
      : args_(args),
        deployment_(std::move(deployment)),
        trusted_key_(std::move(trusted_key)),
        options_(options),
        session_(session) {}

  void start() {
    const bool gps = args_.format == "mavlink" && args_.mavlink_message == "gps";
    if (!args_.origin.empty() || args_.format == "nmea" || gps) read_origin();
    mavlink_ = io::MavlinkWriter(gps                                 ? io::MavlinkMessage::kGps
                                 : args_.mavlink_message == "vision" ? io::MavlinkMessage::kVision
                                                                     : io::MavlinkMessage::kOdometry,
                                 origin_, args_.north_deg.has_value());
    engine_ = need(load());
  }

  Result<void> run(ByteSource& source) {
    using Event = ByteSource::Event;
    for (Event event = Event::kQuiet; event != Event::kEnd && !interrupted();) {
      if (reloads_ != hangups) reload();
      event = source.wait(kQuiet_ms);
      const auto line = [this](std::string_view text) { take(text); };
      const auto too_long = [this] { bad_.add("a line of more than 65536 bytes", ++lines_, session_); };
      if (event == Event::kBytes) cutter_.feed(source.bytes(), line, too_long);
      if (event == Event::kBreak || event == Event::kEnd || event == Event::kFailed)
        cutter_.end(line, too_long);
      quiet_ms_ = event == Event::kQuiet ? std::min(quiet_ms_ + kQuiet_ms, kQuietEpoch_ms) : 0;
      if (quiet_ms_ > 0) engine_->follower.flush_pings();
      if (quiet_ms_ == kQuietEpoch_ms || event == Event::kEnd || event == Event::kFailed)
        engine_->follower.flush();
      if (event == Event::kEnd) doubt_what_came();
      if (!write_out()) return fail({.code = Errc::kOutput, .found = "standard output could not be written"});
      if (event == Event::kFailed)
        return fail({.code = Errc::kBadInput, .file = args_.from, .found = source.why()});
    }
    return {};
  }

  [[nodiscard]] std::string summary() const {
    const FollowCounts& c = engine_->follower.counts();
    std::string text =
        fmt::format("{:<17}{}, {} times no fix\n{:<17}{} used, {} left out\n{:<17}{}\n", "fixes", c.fixes,
                    c.no_fix, "arrivals", c.used, c.rejected, "odometry rows", c.odometry_rows);
    if (c.refused > 0)
      text += fmt::format("{:<17}{} rows that repeat another or say no number\n", "refused", c.refused);
    if (c.late > 0)
      text += fmt::format("{:<17}{} rows more than {:g} s behind later ones\n", "late", c.late,
                          options_.lateness_s);
    if (c.restarts > 0)
      text += fmt::format("{:<17}{} times, as a clock was set back or had jumped ahead\n", "began anew",
                          c.restarts);
    if (c.dropped > 0)
      text += fmt::format("{:<17}{} arrivals from before the first odometry\n", "dropped", c.dropped);
    if (bad_.total() > 0) text += fmt::format("{:<17}{}: {}\n", "bad lines", bad_.total(), bad_.text());
    if (options_.watch) text += fmt::format("{:<17}{}\n", "alarms", c.alarms);
    return text;
  }

 private:
  Result<std::unique_ptr<Engine>> load() {
    auto deployment = read_trusted_deployment(deployment_, trusted_key_);
    if (!deployment) return fail(deployment.error());
    if (auto fits = follow_fits(*deployment, options_.method); !fits) return fail(fits.error());
    warn_if_contradicted(*deployment, deployment_, session_);
    warn_if_overdue(*deployment, session_);
    return engine_of(std::move(*deployment));
  }

  std::unique_ptr<Engine> engine_of(Deployment deployment) {
    auto engine = std::make_unique<Engine>(std::move(deployment), options_);
    Engine* e = engine.get();
    e->follower.on_fix = [this, e](const Fix& fix) {
      out_ += args_.format == "nmea"      ? io::fix_as_nmea(fix, origin_)
              : args_.format == "ros"     ? io::fix_as_ros(fix, e->names)
              : args_.format == "mavlink" ? mavlink_.frame(fix)
                                          : io::fix_as_json(fix, e->names);
    };
    e->follower.on_speed = [this](const RunSpeed& found) { report_speed(found); };
    e->follower.on_alarm = [this, e](const WatchAlarm& alarm) {
      const std::string text = io::alarm_as_json(alarm, e->names);
      session_.note(text.substr(0, text.size() - 1));
      if (args_.format == "nmea") out_ += io::alarm_as_nmea(alarm, e->names);
      if (args_.format == "json") out_ += text;
    };
    return engine;
  }

  void reload() {
    reloads_ = hangups;
    auto engine = load();
    if (!engine) return session_.warn("the deployment that is in use is kept: " + engine.error().message());
    engine_->follower.flush();
    (*engine)->follower.carry_on(engine_->follower);
    engine_ = std::move(*engine);
    mavlink_.lose_track();
    session_.note(fmt::format("{} was read anew", deployment_));
  }

  void report_speed(const RunSpeed& found) {
    session_.note(
        fmt::format("the temperature is not known; from here on the speed is that of {} arrivals: {:+.2f} "
                    "m/s (sigma {:.2f} m/s) from the calibration's",
                    found.arrivals, found.offset_mps, found.sigma_mps));
  }

  /// Reports lost rows, each time their number has doubled.
  void report_drops() {
    const FollowCounts& c = engine_->follower.counts();
    if (c.late + c.dropped < next_drop_report_) return;
    next_drop_report_ = 2 * (c.late + c.dropped);
    session_.warn(
        fmt::format("line {}: {} rows so far were left out because they came more than {:g} s behind later "
                    "ones, or before "
                    "the first row of odometry. Send rows sooner, or allow for more by --lateness",
                    lines_, c.late + c.dropped, options_.lateness_s));
  }

  void take(std::string_view text) {
    ++lines_;
    const auto row = engine_->reader.row(text);
    if (!row) return bad_.add(row.error().message(), lines_, session_);
    if (const auto* arrival = std::get_if<Arrival>(&*row)) {
      if (!doubted_) first_.arrivals.push_back(*arrival);
      if (first_.arrivals.size() == kFirstArrivals) doubt_what_came();
      engine_->follower.hear(*arrival);
    } else if (const auto* step = std::get_if<OdometryStep>(&*row)) {
      if (first_.odometry.empty()) first_.odometry.push_back(*step);
      engine_->follower.move(*step);
    } else if (const auto* pose = std::get_if<OdometryPose>(&*row)) {
      if (first_.odometry.empty())
        first_.odometry.push_back({.time_s = pose->time_s, .vehicle = pose->vehicle});
      engine_->follower.move(*pose);
    } else if (std::holds_alternative<io::LiveFlush>(*row)) {
      engine_->follower.flush();
    }
    report_drops();
    if (out_.size() > kMostWaiting) (void)write_out();
  }

  /// If the first rows give no fix, reports possible causes, once.
  void doubt_what_came() {
    if (doubted_) return;
    doubted_ = true;
    const bool pose_by_pose = options_.method == Method::kAuto || options_.method == Method::kLeastSquares;
    if (engine_->follower.counts().fixes == 0)
      for (const std::string& doubt : doubts_about(engine_->follower.deployment(), first_, pose_by_pose))
        session_.warn("not a single fix so far: " + doubt);
    first_ = {};
  }

  /// Writes the output. A slow reader blocks it, and with it the sender.
  bool write_out() {
    std::string_view rest = out_;
    while (!rest.empty()) {
      const ssize_t written = write(STDOUT_FILENO, rest.data(), rest.size());
      if (written < 0 && errno != EINTR) return false;
      if (written < 0 && interrupted()) break;
      rest.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    out_.clear();
    return true;
  }

  void read_origin() {
    auto origin = io::origin_from_words(args_.origin, args_.north_deg.value_or(kNorth_deg));
    if (!origin && args_.origin.empty())
      origin.error().found = "NMEA and GPS_INPUT need the position of the map on the earth";
    origin_ = need(origin);
  }

  static constexpr std::size_t kMostWaiting = 1 << 16, kFirstArrivals = 300;
  const FollowArgs& args_;
  std::string deployment_, trusted_key_;
  FollowOptions options_;
  Session& session_;
  io::EarthOrigin origin_{.north_rad = args_.north_deg.value_or(kNorth_deg) * std::numbers::pi / 180};
  io::MavlinkWriter mavlink_{io::MavlinkMessage::kVision, origin_, false};
  std::unique_ptr<Engine> engine_;
  std::size_t next_drop_report_ = 1;  ///< number of dropped rows for the next report
  io::LineCutter cutter_;
  BadLines bad_;
  MeasurementLog first_;  ///< first rows, until they have been checked
  bool doubted_ = false;
  std::size_t lines_ = 0;
  int quiet_ms_ = 0;
  std::sig_atomic_t reloads_ = 0;
  std::string out_;
};

}  // namespace

void add_follow_options(CLI::App& command, FollowArgs& args) {
  const OptionGroup group(command, "Live");
  command.add_flag("--follow", args.follow,
                   "Localize as the data come, until they end: arrivals and odometry as JSON lines (octant "
                   "schema live), "
                   "fixes on standard output; SIGHUP reads the deployment anew");
  add_option(command, "--from", args.from, "SOURCE",
             "Where lines come from: - (standard input), /dev/ttyUSB0[:115200], tcp:PORT, udp:PORT (of "
             "this machine)");
  add_option(command, "--format", args.format, "F",
             "Of the fixes: json, nmea (0183), ros (nav_msgs/Odometry as JSON) or mavlink (2, binary); "
             "also as --output F")
      ->check(CLI::IsMember(kLiveFormats));
  add_option(command, "--mavlink-message", args.mavlink_message, "M",
             "mavlink: vision (VISION_POSITION_ESTIMATE), odometry (ODOMETRY) or gps (GPS_INPUT)")
      ->check(CLI::IsMember({"vision", "odometry", "gps"}));
  add_option(command, "--origin", args.origin, "LAT,LON",
             "nmea, gps: where the map's origin is, LATITUDE,LONGITUDE[,ALTITUDE]");
  add_option(command, "--north", args.north_deg, "DEG",
             "nmea, mavlink: direction of north in the map, degrees from +x towards +y (default: 90)");
  add_option(command, "--lateness", args.lateness_s, "S",
             "Arrivals and odometry may come in any order within so many seconds")
      ->check(CLI::Range(0.0, 10.0));
  add_option(command, "--odometry", args.odometry, "RUN.yaml",
             "How good the odometry is: a run.yaml, or a recording's folder, with a block odometry "
             "(octant schema run); left out: as for a recording that says nothing of it");
  command.add_flag("--watch", args.watch,
                   "Say which beacon or receiver no longer fits, with a stated rate of false alarms");
}

int follow(const FollowArgs& args, const std::string& deployment, const std::string& trusted_key,
           Method method, Session& session) {
  session.result_to_stderr();
  FollowOptions options;
  options.method = method;
  options.watch = args.watch;
  options.lateness_s = args.lateness_s;
  if (!args.odometry.empty()) {
    std::vector<std::string> warnings;
    options.odometry = need(io::read_odometry_accuracy(args.odometry, warnings));
    session.warn(warnings);
  }
  FollowLoop loop(args, deployment, trusted_key, options, session);
  loop.start();
  ByteSource source = need(ByteSource::open(args.from));
  struct sigaction hangup = {}, pipe = {};
  hangup.sa_handler = on_hangup;
  pipe.sa_handler = SIG_IGN;  // write() reports a closed reader
  sigemptyset(&hangup.sa_mask);
  sigemptyset(&pipe.sa_mask);
  sigaction(SIGHUP, &hangup, nullptr);
  sigaction(SIGPIPE, &pipe, nullptr);
  if (!source.listens().empty()) session.note(source.listens());
  if (const std::string why = why_no_level(method); !why.empty())
    session.note(fmt::format("fixes of {} have no protection level: {}", to_string(method), why));
  const auto done = loop.run(source);
  if (!session.options.quiet) session.result(loop.summary());
  need(done);
  return kDone;
}

}  // namespace octant::app

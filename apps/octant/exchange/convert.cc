// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/commands.h"
#include "apps/octant/outputs.h"
#include "io/bag/bag_log.h"
#include "io/import/foreign_logs.h"
#include "io/import/pyfg.h"
#include "io/import/vendor_logs.h"
#include "io/network/network_file.h"
#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "io/table/mapping_text.h"
#include "io/table/table_log.h"
#include "io/text/atomic_file.h"
#include "io/text/text.h"

namespace octant::app {
namespace {

/// Formats with beacons that have the names of the log.
constexpr const char* kKits[] = {"marvelmind", "crazyflie", "dwm1001",   "trek1000",
                                 "makerfabs",  "pozyx",     "linktrack", "pyfg"};

struct ConvertArgs {
  std::string robot, input, output, format, site, columns, save_columns, topics, save_topics, time_format,
      decimal;
  std::vector<std::string> ignore, where, no_value;
  bool explain = false, no_header = false;
  std::optional<double> speed_mps, period_s;
  double clock_hz = kCounterClock_hz, spread_s = 2e-4;
  FiringSchedule schedule;
};

MeasurementLog from_counters(const ConvertArgs& args, const NameTable& names) {
  MeasurementLog log;
  log.arrivals =
      arrivals_of_counters(need(io::read_counter_log(args.input, names)), args.spread_s, args.clock_hz);
  log.has_epochs = !log.arrivals.empty() && log.arrivals.front().epoch != kNoEpoch;
  std::ranges::stable_sort(log.arrivals, {}, &Arrival::time_s);
  return log;
}

MeasurementLog from_pulses(const ConvertArgs& args, const NameTable& names) {
  PulseSyncOptions options;
  options.schedule = args.schedule;
  options.schedule.beacons = static_cast<int>(names.beacons.size());
  PulseSync sync(options);
  MeasurementLog log;
  log.has_epochs = true;
  for (const PulseArrival& pulse : need(io::read_pulse_log(args.input)))
    for (const Arrival& a : sync.push(pulse))
      if (a.receiver.index() < names.receivers.size()) log.arrivals.push_back(a);
  if (log.arrivals.empty())
    fail_with({.code = Errc::kBadInput,
               .file = args.input,
               .found = "no double pulse in the stream that could be beacon 0's",
               .expected = fmt::format("two pulses of {} s, {} s apart, every {} s", args.schedule.pulse_s,
                                       args.schedule.double_s, cycle_s(options.schedule)),
               .advice = "check --pulse-s, --double-s and --fire-s, and that the site file lists the "
                         "beacons in the order in which they fire"});
  std::ranges::stable_sort(log.arrivals, {}, &Arrival::time_s);
  return log;
}

/// ", 12 of ignored beacons", or an empty text if there are none.
std::string ignored_words(std::size_t rows) {
  return rows > 0 ? fmt::format(", {} of ignored beacons", rows) : "";
}

/// Writes the files of a run into a new or existing folder. Warns about existing files of a run, which will
/// be read as part of it.
void write_run_files(const std::string& folder, const std::vector<io::FileContent>& files, Session& session) {
  std::error_code made;
  std::filesystem::create_directories(folder, made);
  need(io::write_files(files));
  std::vector<std::string> rest;
  for (const char* name :
       {"tof.csv", "bearings.csv", "scans.csv", "odometry.csv", "odometry.tum", "poses.tum"}) {
    std::error_code none;
    const std::string path = folder + "/" + name;
    const bool written = std::any_of(files.begin(), files.end(),
                                     [&](const io::FileContent& file) { return file.path == path; });
    if (!written && std::filesystem::exists(path, none)) rest.emplace_back(name);
  }
  if (rest.empty()) return;
  session.warn(
      fmt::format("{}: {} {} there from before, and one recording with what is written now; if not, "
                  "convert into a folder of its own",
                  folder, fmt::join(rest, ", "), rest.size() == 1 ? "is" : "are"));
}

/// The first lines of a file for --explain.
std::string first_lines(const io::FileContent& file) {
  constexpr std::size_t kLines = 6;
  std::string_view text = file.content;
  std::string lines;
  for (std::size_t i = 0; i < kLines && !text.empty(); ++i) lines += fmt::format("{}\n", io::take_line(text));
  const auto more = std::ranges::count(text, '\n');
  if (more > 0) lines += fmt::format("... {} more\n", more);
  return lines;
}

/// Writes the files of a run into a new or existing folder, or shows their first rows.
void write_or_explain(const ConvertArgs& args, const std::vector<io::FileContent>& files, Session& session) {
  if (!args.explain) return write_run_files(args.output, files, session);
  for (const io::FileContent& file : files)
    session.result(
        fmt::format("{}\n{}", std::filesystem::path(file.path).filename().string(), first_lines(file)));
}

/// Completes an import with the names found in the log; there is no site file yet.
int finish_import(const ConvertArgs& args, io::ImportedLog log, const std::vector<io::FileContent>& others,
                  const std::string& format, Session& session,
                  const std::vector<std::string>& understood = {}) {
  auto files = need(io::run_files(log, args.output, args.speed_mps));
  session.warn(log.warnings);
  for (const std::string& line : understood) session.result(fmt::format("{:<17}{}\n", "understood", line));
  if (!args.explain) files.insert(files.end(), others.begin(), others.end());
  write_or_explain(args, files, session);
  std::string rows = fmt::format("{} arrivals{}", log.arrivals.size(), ignored_words(log.ignored_rows()));
  if (!log.odometry.empty()) rows += fmt::format(", {} odometry rows", log.odometry.size());
  if (!log.poses.empty()) rows += fmt::format(", {} poses", log.poses.size());
  session.result(fmt::format("{:<17}{}: {}\n", args.explain ? "not written" : "run",
                             args.explain ? args.input : args.output, rows));
  return session.finish({{"format", format},
                         {"run", args.output},
                         {"arrivals", log.arrivals.size()},
                         {"odometry", log.odometry.size()},
                         {"poses", log.poses.size()},
                         {"truth", log.truth.size()},
                         {"ignored", log.ignored_rows()},
                         {"not_heard", log.not_heard},
                         {"understood", understood}});
}

/// How a table is to be read: --columns or its file, and the options that overrule them.
io::TableMapping table_mapping(const ConvertArgs& args) {
  io::TableMapping mapping;
  if (!args.columns.empty())
    mapping = need(args.columns.find('=') == std::string::npos ? io::read_mapping(args.columns)
                                                               : io::mapping_from_words(args.columns));
  mapping.ignore.insert(mapping.ignore.end(), args.ignore.begin(), args.ignore.end());
  for (const std::string& word : args.where) mapping.where.push_back(need(io::condition_from_word(word)));
  mapping.no_header = mapping.no_header || args.no_header;
  if (!args.time_format.empty()) mapping.time_format = args.time_format;
  if (!args.decimal.empty()) mapping.decimal = args.decimal;
  if (!args.no_value.empty()) mapping.no_value = args.no_value;
  if (args.period_s) mapping.period_s = args.period_s;
  return mapping;
}

/// Converts any table.
int convert_table(const ConvertArgs& args, Session& session) {
  const bool is_file = !args.columns.empty() && args.columns.find('=') == std::string::npos;
  check_no_overwriting({.inputs = {args.input, is_file ? args.columns : ""},
                        .outputs = {args.save_columns},
                        .run_outputs = {args.output}});
  io::TableLog table = need(io::read_table_log(args.input, table_mapping(args)));
  std::vector<io::FileContent> others;
  if (!args.save_columns.empty()) others.push_back({args.save_columns, io::mapping_to_yaml(table.mapping)});
  return finish_import(args, std::move(table.log), others, "table", session,
                       args.explain ? table.understood : table.guessed);
}

/// Converts a bag, by --topics or by the types of its topics.
int convert_bag(const ConvertArgs& args, Session& session) {
  const bool is_file = !args.topics.empty() && args.topics.find('=') == std::string::npos;
  check_no_overwriting({.inputs = {args.input, is_file ? args.topics : ""},
                        .outputs = {args.save_topics},
                        .run_outputs = {args.output}});
  io::TopicMapping mapping = need(args.topics.empty() ? io::topics_by_type(args.input)
                                  : is_file           ? io::read_topics(args.topics)
                                                      : io::topics_from_words(args.topics));
  mapping.ignore.insert(mapping.ignore.end(), args.ignore.begin(), args.ignore.end());
  io::ImportedLog log = need(io::read_bag_log(args.input, mapping));
  std::vector<io::FileContent> others;
  if (!args.save_topics.empty()) others.push_back({args.save_topics, io::topics_to_yaml(mapping)});
  return finish_import(args, std::move(log), others, "bag", session);
}

/// Converts the log of a vendor's kit, or a graph of PyFactorGraph.
int convert_kit(const ConvertArgs& args, const std::string& format, Session& session) {
  check_no_overwriting({.inputs = {args.input}, .run_outputs = {args.output}});
  const io::VendorLogOptions options{.ignore = args.ignore, .period_s = args.period_s};
  auto log = need(format == "pyfg" ? io::read_pyfg(args.input, args.robot)
                                   : io::read_kit_log(format, args.input, options));
  std::vector<std::string> understood;
  if (args.format == "auto") understood.push_back(fmt::format("format: {} (otherwise: --format)", format));
  return finish_import(args, std::move(log), {}, format, session, understood);
}

/// Converts a survey network to a survey.yaml.
int convert_network(const ConvertArgs& args, Session& session) {
  check_no_overwriting({.inputs = {args.input}, .outputs = {args.output}});
  const io::NetworkFile file = need(io::read_gama(args.input));
  session.warn(file.warnings);
  const std::string text = io::survey_to_yaml(file);
  if (args.explain)
    session.result(first_lines({args.input, text}));
  else
    need(io::write_file(args.output, text));
  const std::size_t points = file.network.points.size(), observations = file.network.observations.size();
  session.result(fmt::format("{:<17}{}: {} points, {} observations\n",
                             args.explain ? "not written" : "survey", args.explain ? args.input : args.output,
                             points, observations));
  return session.finish(
      {{"format", "gama"}, {"survey", args.output}, {"points", points}, {"observations", observations}});
}

/// Detects the format of a log if --format is not given.
std::string format_of(const ConvertArgs& args) {
  if (args.format != "auto") return args.format;
  if (!args.columns.empty()) return "table";
  if (!args.topics.empty() || io::is_bag(args.input)) return "bag";
  if (!args.site.empty()) return "counters";
  if (io::is_carmen_log(args.input)) return "carmen";
  if (io::is_gama(args.input)) return "gama";
  if (io::is_pyfg(args.input)) return "pyfg";
  const std::string kit = io::kit_of(args.input);
  return kit.empty() ? "table" : kit;
}

int run(const ConvertArgs& args, Session& session) {
  if (args.output.empty() && !args.explain)
    fail_usage("-o,--output is required (Run folder to write)", "or --explain, which writes no files");
  const std::string format = format_of(args);
  if (format == "table") return convert_table(args, session);
  if (format == "bag") return convert_bag(args, session);
  if (format == "gama") return convert_network(args, session);
  if (std::ranges::count(kKits, format) > 0) return convert_kit(args, format, session);
  if (format != "carmen" && args.site.empty())
    fail_usage(fmt::format("--format {} needs --site", format), "the site file names beacons and receivers");
  check_no_overwriting({.inputs = {args.input, args.site}, .run_outputs = {args.output}});
  NameTable names;
  names.vehicles = {"robot"};
  if (!args.site.empty()) {
    const Site site = need(io::read_site(args.site));
    session.warn(site.warnings);
    names = names_of(site);
    if (format == "pulses" && (names.beacons.size() < 3 || names.beacons.size() > 16))
      fail_with({.code = Errc::kBadInput,
                 .file = args.site,
                 .found = fmt::format("{} beacons", names.beacons.size()),
                 .expected = "3 to 16, in the order in which they fire"});
  }
  MeasurementLog log = format == "carmen"     ? need(io::read_carmen_log(args.input))
                       : format == "counters" ? from_counters(args, names)
                                              : from_pulses(args, names);
  session.warn(log.warnings);
  log.vehicle = VehicleId(0);
  if (!args.explain) need(io::write_run(args.output, log, names));
  session.result(fmt::format("{:<17}{}: {} arrivals, {} scans, {} odometry rows\n",
                             args.explain ? "not written" : "run", args.explain ? args.input : args.output,
                             log.arrivals.size(), log.scans.size(), log.odometry.size()));
  return session.finish({{"format", format},
                         {"run", args.output},
                         {"arrivals", log.arrivals.size()},
                         {"scans", log.scans.size()},
                         {"odometry", log.odometry.size()}});
}

}  // namespace

/// Options for what is recognised in a table.
void add_table_options(CLI::App& command, ConvertArgs& args) {
  command.add_flag("--explain", args.explain, "Show what is understood and the first rows; write no files");
  command.add_flag("--no-header", args.no_header, "Tables: the first line is a row");
  add_option(command, "--where", args.where, "CONDITIONS",
             "Tables: use only the rows that meet all conditions, as valid=1,quality>50 (= != < <= > >=)")
      ->delimiter(',');
  add_option(
      command, "--time-format", args.time_format, "FORMAT",
      "Tables: of the times: s, ms, us, ns, excel or matlab (serial dates), dw1000 (counts of 40 bits), "
      "dmy or mdy (order of dates with slashes); without it, recognised")
      ->check(
          CLI::IsMember(std::vector<std::string>(std::begin(io::kTimeFormats), std::end(io::kTimeFormats))));
  add_option(command, "--decimal", args.decimal, "MARK",
             "Tables: decimal mark, point or comma; without it, recognised")
      ->check(CLI::IsMember({"point", "comma"}));
  add_option(command, "--no-value", args.no_value, "CELLS",
             "Tables: cells without a measurement, as 0,-1,65535, or none; without it, recognised")
      ->delimiter(',');
}

/// Options for tables, bags and kits.
void add_mapping_options(CLI::App& command, ConvertArgs& args) {
  add_option(
      command, "--columns", args.columns, "MAPPING",
      "Any table: which of its columns is what, as "
      "time=timestamp_ms,beacon=anchor,tof=tof_us*1e-6 (or distance=..., epoch, receiver, "
      "vehicle, amplitude, temperature), or a file that --save-columns wrote; without it, the columns are "
      "guessed. One column for "
      "each beacon: time=t,distance=r_{beacon} or time=t,distance:A1=r1,distance:A2=r2. "
      "Without a header line: time=#1,beacon=#2,distance=#3. A column of dates and one of times of day: "
      "time=Date+Time. Units at the end of names (_ms, "
      "[cm]), dates with times, delimiters and decimal commas are recognised");
  add_table_options(command, args);
  add_option(command, "--topics", args.topics, "MAPPING",
             "Bags: which topic is what, as range=/uwb/{receiver}/{beacon} (or range=/uwb@{beacon}, by "
             "frame_id; range:B3=/kit/range_3), odometry=/odom, poses=/mocap/pose, "
             "truth=/tf@map>base_link, time=recorded; or a file that --save-topics wrote; without it, all "
             "Range by frame_id and the only odometry");
  add_option(command, "--save-topics", args.save_topics, "M.yaml",
             "Bags: the mapping to write, for the next time");
  command
      .add_option(
          "--speed-mps", args.speed_mps,
          "Bags and kits: the speed that the device made distances with; they become times of flight, "
          "which media whose speed is not constant need [m/s]")
      ->check(CLI::PositiveNumber);
  command.add_option("--period-s", args.period_s, "Tables and kits: between lines without a time [s]")
      ->check(CLI::PositiveNumber);
  add_option(command, "--robot", args.robot, "LETTER",
             "pyfg: the robot to convert; without it, that of the first pose");
  add_option(command, "--ignore", args.ignore, "IDS",
             "Tables, bags and kits: beacons to leave out, a neighbour's; their rows are counted")
      ->delimiter(',');
  add_option(command, "--save-columns", args.save_columns, "M.yaml",
             "Tables: the mapping to write, for the next time");
}

void add_counter_options(CLI::App& command, ConvertArgs& args) {
  add_option(command, "--site", args.site, "SITE.yaml",
             "Site file that names beacons and receivers (counters, pulses)");
  command.add_option("--clock-hz", args.clock_hz, "Clock of the counter [Hz]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--spread-s", args.spread_s,
                  "Readings of one beacon agree within this; others are left out [s]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_option("--fire-s", args.schedule.fire_s, "Between the firings of successive beacons [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--pulse-s", args.schedule.pulse_s, "Length of a pulse [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--double-s", args.schedule.double_s, "Between the starts of beacon 0's two pulses [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

std::vector<std::string> formats() {
  std::vector<std::string> all = {"auto", "table", "bag", "carmen", "counters", "pulses", "gama"};
  all.insert(all.end(), std::begin(kKits), std::end(kKits));
  return all;
}

void add_convert(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<ConvertArgs>(
      app, common, action, "convert", "Make a run folder of another program's or device's log",
      "octant convert intel.clf -o intel", run);
  add_required_option(
      *command, "input", args->input, "INPUT",
      "Table (CSV, also .gz, .zst, UTF-16); CARMEN log; ROS 2 bag (.mcap, .db3, or its folder); a kit's log; "
      "counter log (time_s, "
      "beacon, counts; epoch, receiver); pulse log (time_s, channel, duration_s, amplitude_v); survey "
      "network "
      "of GNU Gama (.gkf)");
  add_option(*command, "-o,--output", args->output, "RUN",
             "Run folder to write; of a survey network: survey.yaml");
  // Set afterwards, because the description names the default.
  add_option(
      *command, "--format", args->format, "FORMAT",
      "auto, table, bag, carmen, counters, pulses, gama (survey network), pyfg (graphs of PyFactorGraph), or "
      "the log of a kit: "
      "marvelmind (the dashboard's CSV), crazyflie (the client's CSV of two-way ranging), dwm1001 (les or "
      "lec lines), trek1000 (mc or mr lines), makerfabs (JSON or AT+RANGE lines), pozyx (lines of ms, mm, "
      "dBm) or linktrack (frames); auto: by content, counters where --site is given")
      ->check(CLI::IsMember(formats()));
  args->format = "auto";
  add_mapping_options(*command, *args);
  add_counter_options(*command, *args);
}

}  // namespace octant::app

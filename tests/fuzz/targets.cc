// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include "io/bag/bag_log.h"
#include "io/bag/ros_messages.h"
#include "io/deployment/deployment_json.h"
#include "io/export/exported.h"
#include "io/history/history.h"
#include "io/import/foreign_logs.h"
#include "io/import/plan_import.h"
#include "io/import/pyfg.h"
#include "io/import/vendor_logs.h"
#include "io/run/run_folder.h"
#include "io/run/run_ids.h"
#include "io/run/tum.h"
#include "io/site/batch_yaml.h"
#include "io/site/scenario_yaml.h"
#include "io/site/scene_yaml.h"
#include "io/site/site_yaml.h"
#include "io/table/mapping_text.h"
#include "io/table/table_log.h"
#include "io/text/open_file.h"
#include "io/tof/run_parts.h"
#include "io/tof/tof_reader.h"
#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"
#include "tests/fuzz/live_target.h"
#include "tests/fuzz/must.h"
#include "tests/fuzz/solver_target.h"

namespace octant::fuzz {

namespace fs = std::filesystem;

namespace {

/// Gone with the process.
struct Folder {
  fs::path path = (::access("/dev/shm", W_OK) == 0 ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                  ("octant_fuzz." + std::to_string(::getpid()));
  Folder() { fs::create_directories(path / "run"); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

const fs::path& folder() {
  static const Folder made;
  return made.path;
}

}  // namespace

std::string scratch(const std::string& name) {
  const fs::path path = folder() / name;
  fs::create_directories(path.parent_path());
  return path.string();
}

std::string written(const std::string& name, std::string_view content) {
  const std::string path = scratch(name);
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  return path;
}

namespace {

const NameTable& names() {
  static const NameTable table = [] {
    NameTable t;
    t.beacons = {"B0", "B1", "B,2"};
    t.vehicles = {"robot", "cart"};
    t.receivers = {{"r0", VehicleId(0)}, {"r1", VehicleId(0)}, {"r0", VehicleId(1)}};
    return t;
  }();
  return table;
}

void take_site(std::string_view input) {
  const auto site = io::read_site(written("site.yaml", input));
  must_explain(site);
  if (!site) return;
  const auto again = io::read_site(written("again.yaml", io::site_to_yaml(*site)));
  must(again.has_value(), "a site that was written reads back");
  must(again->beacons.size() == site->beacons.size() && again->receivers.size() == site->receivers.size(),
       "with all that is in it");
}

void take_yaml(std::string_view input) {
  const auto root = io::parse_yaml(input, "a.yaml");
  must_explain(root);
  if (!root) return;
  io::YamlWriter out;
  out.copy(*root);
  must(io::parse_yaml(out.finish(), "b.yaml").has_value(), "a document that was written reads back");
}

void take_scene(std::string_view input) { must_explain(io::read_scene(written("scene.yaml", input))); }
void take_batch(std::string_view input) { must_explain(io::read_batch(written("batch.yaml", input), "")); }
void take_scenario(std::string_view input) { must_explain(io::scenario_from_yaml(input, "scenario.yaml")); }

void take_run_yaml(std::string_view input) {
  MeasurementLog log;
  const auto header = io::parse_run_yaml(input, "run.yaml", log);
  must_explain(header);
  if (header) must(io::parse_run_yaml(io::run_to_yaml(log, names()), "b", log).has_value(), "reads back");
}

/// All arrivals, and the error in the end if there is one.
struct AllArrivals {
  std::vector<Arrival> rows;
  std::string error;
};

AllArrivals arrivals_of(const std::shared_ptr<const io::MappedFile>& map, const io::NameLookup& lookup,
                        io::TofReaderOptions options) {
  AllArrivals all;
  io::TofReader reader(map, "tof.csv", lookup, Clock::kSynchronised, options);
  if (const auto ok = reader.read_header(); !ok) return {{}, ok.error().message()};
  for (;;) {
    const auto more = reader.append(all.rows);
    if (!more) all.error = more.error().message();
    if (!more || !*more) return all;
  }
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// The fast reader of tof.csv, in pieces and by threads, gives the result of the general reader.
void take_tof(std::string_view input) {
  auto map = io::MappedFile::open(written("tof.csv", input));
  must(map.has_value(), "the file was just written");
  const auto shared = std::make_shared<const io::MappedFile>(std::move(*map));
  io::NameLookup lookup(names());
  lookup.default_vehicle = VehicleId(0);
  const AllArrivals general = arrivals_of(shared, lookup, {.general_way = true});
  for (const std::size_t chunk : {std::size_t{40}, std::size_t{1} << 17}) {
    const AllArrivals fast = arrivals_of(shared, lookup, {.threads = 1, .chunk_bytes = chunk});
    must(fast.error == general.error, "both ways find the same error");
    if (!fast.error.empty()) continue;
    must(fast.rows.size() == general.rows.size(), "both ways find the same rows");
    for (std::size_t i = 0; i < fast.rows.size(); ++i) {
      const Arrival &a = fast.rows[i], &b = general.rows[i];
      must(same(a.time_s, b.time_s) && same(a.tof_s, b.tof_s) && same(a.amplitude_v, b.amplitude_v) &&
               same(a.temperature_degC, b.temperature_degC) && a.epoch == b.epoch && a.beacon == b.beacon &&
               a.receiver == b.receiver && a.vehicle == b.vehicle && a.line == b.line,
           "both ways read the same values");
    }
  }
}

/// A run folder with one file from outside; the rest of it is written once.
void take_in_run(const std::string& name, std::string_view input) {
  const std::string run = "run_of_" + name + "/", tof = run + "tof.csv";
  if (!fs::exists(scratch(tof)))
    (void)written(tof, "time_s,beacon,tof_s,epoch,receiver\n1,B0,0.01,1,r0\n2,B1,0.02,2,r0\n");
  (void)written(run + name, input);
  const auto log = io::read_run(scratch(run), names(), {}, {.read_truth = true, .read_poses = true});
  must_explain(log);
  must_explain(io::read_run_ids(scratch(run)));
}

/// Returns true if names can be determined for a run folder of one file.
bool written_run_reads(const std::string& name, std::string_view content) {
  const fs::path run = folder() / "run";
  for (const auto& entry : fs::directory_iterator(run)) fs::remove(entry.path());
  (void)written("run/" + name, content);
  return io::read_run_ids(run.string()).has_value();
}

void group_bearings(std::string_view input) { take_in_run("bearings.csv", input); }
void take_odometry(std::string_view input) { take_in_run("odometry.csv", input); }
void take_scans(std::string_view input) { take_in_run("scans.csv", input); }
void take_points(std::string_view input) { take_in_run("points.csv", input); }
void take_ids(std::string_view input) { take_in_run("tof.csv", input); }

void take_tum(std::string_view input) {
  const auto poses = io::tum_from_text(input, "poses.tum");
  must_explain(poses);
  if (poses) must(io::tum_from_text(io::poses_to_tum(*poses), "b").has_value(), "a track reads back");
}

void take_deployment(std::string_view input) {
  const auto deployment = io::deployment_from_json(std::string(input), "d.json");
  must_explain(deployment);
  if (!deployment) return;
  for (const auto& b : deployment->beacons)
    must(b.position_m.allFinite() && b.covariance_m2.allFinite() && std::isfinite(b.delay_s),
         "numbers are finite");
  must(io::deployment_from_json(io::deployment_to_json(*deployment), "e.json").has_value(), "it reads back");
}

void take_visit(std::string_view input) { must_explain(io::visit_of(std::string(input), "visit.json")); }
void take_dxf(std::string_view input) { must_explain(io::drawing_from_dxf(input, "a.dxf")); }

void take_pgm(std::string_view input) {
  (void)written("map.pgm", input);
  const auto map =
      io::read_ros_map(written("map.yaml", "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0.5]\n"));
  must_explain(map);
  if (map && map->cells.size() < 100'000) (void)io::rectangles_of(*map, io::RosMap::kOccupied);
}

void take_carmen(std::string_view input) { must_explain(io::read_carmen_log(written("carmen.log", input))); }
void take_counters(std::string_view input) {
  must_explain(io::read_counter_log(written("counters.csv", input), names()));
}

/// An imported log becomes a run that can be read back, or its rows are refused with a reason.
void must_become_a_run(Result<io::ImportedLog> log) {
  must_explain(log);
  if (!log) return;
  auto files = io::run_files(*log, (folder() / "run").string(), 343.0);
  must_explain(files);
}
/// A bag, by what its topics look like and by a mapping that asks for all kinds.
void take_bag(const std::string& path) {
  const auto by_type = io::topics_by_type(path);
  must_explain(by_type);
  if (by_type) must_become_a_run(io::read_bag_log(path, *by_type));
  io::TopicMapping all;
  all.ranges = {{"*{beacon}", "", "", "", ""}};
  all.odometry = io::PoseTopic{"/odom", "", ""};
  all.poses = io::PoseTopic{"/tf", "map", ""};
  all.truth = io::PoseTopic{"/mocap", "", ""};
  must_become_a_run(io::read_bag_log(path, all));
}
void take_mcap(std::string_view input) { take_bag(written("a.mcap", input)); }
void take_bag_database(std::string_view input) { take_bag(written("a.db3", input)); }
/// A message as each of the types, without the preceding checksums of a file.
void take_cdr(std::string_view input) {
  (void)io::range_of(input);
  for (const std::string_view type : {io::kRosPose, io::kRosOdometry, io::kRosTransforms})
    if (const auto poses = io::poses_of(type, input))
      for (const io::RosPose& pose : *poses)
        must(pose.T_frame_child.translation_m.allFinite() &&
                 std::abs(pose.T_frame_child.rotation.norm() - 1.0) < 1e-9,
             "a pose is finite, its quaternion of length 1");
}
void take_topics(std::string_view input) {
  const auto mapping = io::read_topics(written("topics.yaml", input));
  must_explain(mapping);
  if (mapping)
    must(io::read_topics(written("again.yaml", io::topics_to_yaml(*mapping))).has_value(),
         "a mapping reads back");
}
void take_marvelmind(std::string_view input) {
  must_become_a_run(io::read_marvelmind_log(written("marvelmind.csv", input), {.ignore = {"9"}}));
}
void take_crazyflie(std::string_view input) {
  must_become_a_run(io::read_crazyflie_log(written("crazyflie.csv", input)));
}
void take_dwm1001(std::string_view input) {
  must_become_a_run(io::read_dwm1001_log(written("dwm1001.log", input)));
  must_become_a_run(io::read_dwm1001_log((folder() / "dwm1001.log").string(), {.period_s = 0.1}));
}
/// Kits whose logs are lines or frames; a period stands for times that the lines do not have.
void take_kit(std::string_view input) {
  const std::string path = written("kit.log", input);
  (void)io::kit_of(path);
  for (const char* kit : {"trek1000", "makerfabs", "pozyx", "linktrack"})
    must_become_a_run(io::read_kit_log(kit, path, {.ignore = {"9"}, .period_s = 0.1}));
}
void take_pyfg(std::string_view input) { must_become_a_run(io::read_pyfg(written("graph.pyfg", input))); }
void take_fixes(std::string_view input) {
  const auto fixes = io::read_fixes(written("fixes.csv", input));
  must_explain(fixes);
  if (!fixes) return;
  io::ExportedContent content;
  content.tracks.push_back(*fixes);
  must_explain(io::to_mcap(content));
  must(!io::to_geojson(content, {}).empty(), "fixes become a map");
}

void take_pulses(std::string_view input) { must_explain(io::read_pulse_log(written("pulses.csv", input))); }

/// The first line is the argument of --columns, or blank: the columns are guessed. The others are the table;
/// its conversion is read like any tof.csv.
void take_table(std::string_view input) {
  const std::size_t end = std::min(input.find('\n'), input.size());
  io::TableMapping mapping;
  if (end > 0) {
    const auto stated = io::mapping_from_words(input.substr(0, end));
    must_explain(stated);
    if (!stated) return;
    mapping = *stated;
    const auto kept = io::read_mapping(written("columns.yaml", io::mapping_to_yaml(mapping)));
    must(kept.has_value() && kept->columns.size() == mapping.columns.size(), "a mapping reads back");
  }
  auto table =
      io::read_table_log(written("table.csv", input.substr(std::min(end + 1, input.size()))), mapping);
  must_explain(table);
  if (!table || table->log.arrivals.empty()) return;
  const auto files = io::run_files(table->log, (folder() / "run").string(), {});
  must_explain(files);
  if (files) must(written_run_reads("tof.csv", files->front().content), "what it became is a recording");
}

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all = {{"site", take_site},
                                          {"yaml", take_yaml},
                                          {"scene", take_scene},
                                          {"batch", take_batch},
                                          {"scenario", take_scenario},
                                          {"run_yaml", take_run_yaml},
                                          {"tof", take_tof},
                                          {"bearings", group_bearings},
                                          {"odometry", take_odometry},
                                          {"scans", take_scans},
                                          {"points", take_points},
                                          {"ids", take_ids},
                                          {"tum", take_tum},
                                          {"deployment", take_deployment},
                                          {"visit", take_visit},
                                          {"dxf", take_dxf},
                                          {"pgm", take_pgm},
                                          {"carmen", take_carmen},
                                          {"counters", take_counters},
                                          {"pulses", take_pulses},
                                          {"mcap", take_mcap},
                                          {"bag_database", take_bag_database},
                                          {"cdr", take_cdr},
                                          {"topics", take_topics},
                                          {"fixes", take_fixes},
                                          {"marvelmind", take_marvelmind},
                                          {"crazyflie", take_crazyflie},
                                          {"kit", take_kit},
                                          {"pyfg", take_pyfg},
                                          {"dwm1001", take_dwm1001},
                                          {"table", take_table},
                                          {"live", take_live},
                                          {"solver", take_solver, 40}};
  return all;
}

}  // namespace octant::fuzz

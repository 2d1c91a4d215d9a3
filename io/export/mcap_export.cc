// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/bag/bag_log.h"
#include "io/bag/ros_messages.h"
#include "io/export/exported.h"
#include "io/export/mcap_writer.h"
#include "io/text/text.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

using ExportJson = nlohmann::ordered_json;

constexpr double kLatestTime_s = 7.2582048e9;  ///< the year 2200
constexpr std::size_t kMostExportedBeacons = 60'000;

const McapSchema& arrival_schema() {
  static const McapSchema schema{
      kArrivalType, "jsonschema",
      R"({"type":"object","title":"octant.Arrival","properties":{"time_s":{"type":"number"},"beacon":{"type":"string"},)"
      R"("tof_s":{"type":"number"},"epoch":{"type":"integer"},"vehicle":{"type":"string"},"receiver":{"type":"string"},)"
      R"("amplitude_v":{"type":"number"},"temperature_degC":{"type":"number"},"received_s":{"type":"number"}}})"};
  return schema;
}

const McapSchema& fix_schema() {
  static const McapSchema schema{
      "octant.Fix", "jsonschema",
      R"({"type":"object","title":"octant.Fix","properties":{"time_s":{"type":"number"},"vehicle":{"type":"string"},)"
      R"("status":{"type":"string"},"x_m":{"type":"number"},"y_m":{"type":"number"},"z_m":{"type":"number"},)"
      R"("heading_rad":{"type":"number"},"sigma_x_m":{"type":"number"},"sigma_y_m":{"type":"number"},)"
      R"("protection_level_m":{"type":"number"},"arrivals_used":{"type":"integer"},)"
      R"("arrivals_rejected":{"type":"integer"}}})"};
  return schema;
}

/// The part of foxglove.SceneUpdate that is used here.
const McapSchema& scene_schema() {
  static const McapSchema schema{
      "foxglove.SceneUpdate", "jsonschema",
      R"({"type":"object","title":"foxglove.SceneUpdate","properties":{"deletions":{"type":"array","items":{"type":"object"}},)"
      R"("entities":{"type":"array","items":{"type":"object"}}}})"};
  return schema;
}

McapSchema ros_schema(std::string_view type) { return {std::string(type), "ros2msg", ros_definition(type)}; }

std::string dumped(const ExportJson& json) {
  return json.dump(-1, ' ', false, ExportJson::error_handler_t::replace);
}

class McapExport {
 public:
  explicit McapExport(const ExportedContent& content) : content_(content) {}

  Result<std::string> write() {
    if (content_.beacons.size() > kMostExportedBeacons)
      return fail({.found = fmt::format("{} beacons", content_.beacons.size()),
                   .expected = fmt::format("at most {}, a topic each", kMostExportedBeacons)});
    if (auto fit = find_times(); !fit) return fail(fit.error());
    beacons();
    for (const ExportedRun& run : content_.runs) this->run(run);
    for (const ExportedFixes& track : content_.tracks) fixes(track);
    return out_.finish();
  }

 private:
  Result<void> see(double time_s, const std::string& where) {
    if (time_s >= 0.0 && time_s < kLatestTime_s) {
      first_s_ = std::min(first_s_, time_s);
      return {};
    }
    return fail({.file = where,
                 .found = fmt::format("time_s {}", exact(time_s)),
                 .expected = "times from 0 (1970) to the year 2200, which MCAP counts in nanoseconds"});
  }

  Result<void> find_times() {
    for (const ExportedRun& run : content_.runs) {
      const auto all = [&](const auto& rows) -> Result<void> {
        for (const auto& row : rows)
          if (auto fit = see(row.time_s, run.log.path); !fit) return fit;
        return {};
      };
      for (auto fit : {all(run.log.arrivals), all(run.log.odometry), all(run.log.poses), all(run.log.truth)})
        if (!fit) return fit;
    }
    for (const ExportedFixes& track : content_.tracks)
      for (const Fix& fix : track.fixes)
        if (auto fit = see(fix.time_s, "fixes"); !fit) return fit;
    return {};
  }

  static std::uint64_t at(double time_s) { return static_cast<std::uint64_t>(nanoseconds_of(time_s)); }

  /// "/octant/fix", or "/octant/VEHICLE/fix" with several vehicles.
  static std::string topic_of(const NameTable& names, VehicleId vehicle, const char* what) {
    const bool named =
        names.vehicles.size() > 1 && vehicle.valid() && vehicle.index() < names.vehicles.size();
    return named ? fmt::format("/octant/{}/{}", names.vehicles[vehicle.index()], what)
                 : fmt::format("/octant/{}", what);
  }

  void beacons() {
    if (content_.beacons.empty()) return;
    ExportJson entities = ExportJson::array();
    for (const ExportedBeacon& b : content_.beacons) {
      const ExportJson place = {{"x", b.position_m.x()}, {"y", b.position_m.y()}, {"z", b.position_m.z()}};
      const ExportJson pose = {{"position", place},
                               {"orientation", {{"x", 0}, {"y", 0}, {"z", 0}, {"w", 1}}}};
      const ExportJson colour = {{"r", 0.1}, {"g", 0.4}, {"b", 0.8}, {"a", 1.0}};
      // Lists of one element are made by array(), because compilers interpret {x} differently.
      const ExportJson sphere = {
          {"pose", pose}, {"size", {{"x", 0.15}, {"y", 0.15}, {"z", 0.15}}}, {"color", colour}};
      const ExportJson text = {{"pose", pose},    {"billboard", true},
                               {"font_size", 14}, {"scale_invariant", true},
                               {"color", colour}, {"text", b.id}};
      entities.push_back({{"timestamp", {{"sec", 0}, {"nsec", 0}}},
                          {"frame_id", "map"},
                          {"id", b.id},
                          {"lifetime", {{"sec", 0}, {"nsec", 0}}},
                          {"frame_locked", false},
                          {"metadata", ExportJson::array()},
                          {"spheres", ExportJson::array({sphere})},
                          {"texts", ExportJson::array({text})}});
    }
    out_.message(out_.channel("/octant/beacons", scene_schema(), "json"),
                 at(std::isfinite(first_s_) ? first_s_ : 0.0),
                 dumped({{"deletions", ExportJson::array()}, {"entities", entities}}));
  }

  void run(const ExportedRun& run) {
    const MeasurementLog& log = run.log;
    if (const std::string yaml = run_to_yaml(log, run.names); !yaml.empty())
      out_.metadata(kRunMetadata, {{kRunYamlKey, yaml}});
    for (const Arrival& a : log.arrivals) arrival(a, run.names);
    std::vector<Pose> added(run.names.vehicles.size() + 1);
    for (const OdometryStep& step : log.odometry) {
      Pose& T = added[step.vehicle.valid() ? step.vehicle.index() : run.names.vehicles.size()];
      T = T * step.pose();
      out_.message(
          out_.channel(topic_of(run.names, step.vehicle, "odometry"), ros_schema(kRosOdometry), "cdr"),
          at(step.time_s), ros_odometry(nanoseconds_of(step.time_s), "odom", "base_link", T));
    }
    const std::pair<const std::vector<TimedPose>*, const char*> tracks[] = {{&log.poses, kPosesTopic},
                                                                            {&log.truth, kTruthTopic}};
    for (const auto& [poses, topic] : tracks)
      for (const TimedPose& pose : *poses)
        out_.message(out_.channel(topic, ros_schema(kRosPose), "cdr"), at(pose.time_s),
                     ros_pose(nanoseconds_of(pose.time_s), "map", pose.T_map_vehicle));
  }

  void arrival(const Arrival& a, const NameTable& names) {
    const std::string& beacon = names.beacons[a.beacon.index()];
    ExportJson json = {{"time_s", a.time_s}, {"beacon", beacon}, {"tof_s", a.tof_s}};
    if (a.epoch != kNoEpoch) json["epoch"] = a.epoch;
    if (names.vehicles.size() > 1 && a.vehicle.valid()) json["vehicle"] = names.vehicles[a.vehicle.index()];
    if (a.receiver.valid() && names.receivers.size() > 1)
      json["receiver"] = names.receivers[a.receiver.index()].name;
    if (std::isfinite(a.amplitude_v)) json["amplitude_v"] = a.amplitude_v;
    if (std::isfinite(a.temperature_degC)) json["temperature_degC"] = a.temperature_degC;
    if (std::isfinite(a.received_after_s)) json["received_s"] = a.time_s + a.received_after_s;
    out_.message(out_.channel("/octant/arrivals/" + beacon, arrival_schema(), "json"), at(a.time_s),
                 dumped(json));
  }

  void fixes(const ExportedFixes& track) {
    for (const Fix& fix : track.fixes) {
      const Pose& T = fix.T_map_vehicle;
      ExportJson json = {{"time_s", fix.time_s}};
      if (fix.vehicle.valid() && fix.vehicle.index() < track.names.vehicles.size())
        json["vehicle"] = track.names.vehicles[fix.vehicle.index()];
      json["status"] = to_string(fix.status);
      if (fix.ok()) {
        json["x_m"] = T.translation_m.x();
        json["y_m"] = T.translation_m.y();
        json["z_m"] = T.translation_m.z();
        json["heading_rad"] = T.heading_rad();
        if (fix.covariance.rows() >= 3) {
          json["sigma_x_m"] = std::sqrt(std::max(fix.covariance(0, 0), 0.0));
          json["sigma_y_m"] = std::sqrt(std::max(fix.covariance(1, 1), 0.0));
        }
        if (fix.protection_level_m > 0) json["protection_level_m"] = fix.protection_level_m;
        out_.message(out_.channel(topic_of(track.names, fix.vehicle, "fix"),
                                  ros_schema(kRosPoseWithCovariance), "cdr"),
                     at(fix.time_s),
                     ros_pose_with_covariance(nanoseconds_of(fix.time_s), "map", T, fix.covariance));
      }
      json["arrivals_used"] = fix.arrivals_used;
      json["arrivals_rejected"] = fix.arrivals_rejected;
      json["integrity"] = to_string(integrity(fix));
      json["integrity_reason"] = integrity_reason(fix);
      out_.message(out_.channel(topic_of(track.names, fix.vehicle, "fix_status"), fix_schema(), "json"),
                   at(fix.time_s), dumped(json));
    }
  }

  const ExportedContent& content_;
  McapWriter out_;
  double first_s_ = INFINITY;
};

}  // namespace

Result<std::string> to_mcap(const ExportedContent& content) { return McapExport(content).write(); }

}  // namespace octant::io

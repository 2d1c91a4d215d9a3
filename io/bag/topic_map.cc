// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/topic_map.h"

#include <algorithm>

#include <fmt/format.h>

#include "io/import/mapping_words.h"
#include "io/import/name_pattern.h"
#include "io/text/text.h"
#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

bool names_beacon(const RangeTopics& r) {
  return !r.beacon.empty() || r.topic.find("{beacon}") != std::string::npos ||
         r.frame.find("{beacon}") != std::string::npos;
}

/// Fault of a mapping; empty if it is valid.
std::string fault_of_topics(const TopicMapping& mapping) {
  for (const RangeTopics& r : mapping.ranges) {
    for (const std::string* pattern : {&r.topic, &r.frame})
      if (std::string fault = fault_of_pattern(*pattern); !fault.empty()) return fault;
    if (r.topic.empty()) return "a range without a topic";
    if (!names_beacon(r)) return fmt::format("range {} does not say of which beacon", in_quotes(r.topic));
  }
  return "";
}

constexpr const char* kTopicWords =
    "range=/uwb/{beacon}, range=/uwb@{beacon} (frame_id), range:B3=/kit/range_3, odometry=/odom, "
    "poses=/mocap/pose, truth=/tf@map>base_link, time=recorded";

void add_range(std::string_view target, std::string_view source, TopicMapping& mapping) {
  RangeTopics range;
  const std::size_t at = source.find('@');
  range.topic = source.substr(0, at);
  if (at != std::string_view::npos) range.frame = source.substr(at + 1);
  target.remove_prefix(std::string_view("range").size());
  if (target.starts_with(':')) {
    const std::string_view ids = target.substr(1);
    const std::size_t colon = ids.find(':');
    range.beacon = ids.substr(0, colon);
    if (colon != std::string_view::npos) range.receiver = ids.substr(colon + 1);
  }
  mapping.ranges.push_back(std::move(range));
}

PoseTopic pose_topic(std::string_view source) {
  PoseTopic pose;
  const std::size_t at = source.find('@');
  pose.topic = source.substr(0, at);
  if (at == std::string_view::npos) return pose;
  const std::string_view frames = source.substr(at + 1);
  const std::size_t arrow = frames.find('>');
  pose.parent = frames.substr(0, arrow);
  if (arrow != std::string_view::npos) pose.child = frames.substr(arrow + 1);
  return pose;
}

std::optional<PoseTopic> pose_block(YamlMap& root, const char* key, YamlLog& log) {
  YamlMap block(root.block(key), key, log);
  if (!block.present()) return std::nullopt;
  PoseTopic pose{block.required_text("topic"), block.text("parent", ""), block.text("child", "")};
  block.finish();
  return pose;
}

void write_entry(YamlWriter& yaml, const char* key, const std::string& value) {
  if (value.empty()) return;
  yaml.text(key);
  yaml.text(value, true);
}

void write_pose_topic(YamlWriter& yaml, const char* key, const std::optional<PoseTopic>& pose) {
  if (!pose) return;
  yaml.text(key);
  yaml.begin_map(true);
  write_entry(yaml, "topic", pose->topic);
  write_entry(yaml, "parent", pose->parent);
  write_entry(yaml, "child", pose->child);
  yaml.end_map();
}

}  // namespace

Result<TopicMapping> topics_from_words(std::string_view words) {
  TopicMapping mapping;
  const auto refuse = [](std::string found) {
    return fail({.code = Errc::kUsage, .found = std::move(found), .expected = kTopicWords});
  };
  for (const auto& [word, target, source] : mapping_words(words)) {
    if (source.empty()) return refuse(fmt::format("{} names no topic", in_quotes(word)));
    if (target == "range" || target.starts_with("range:")) {
      add_range(target, source, mapping);
    } else if (target == "time" && (source == "header" || source == "recorded")) {
      mapping.recorded_time = source == "recorded";
    } else if (target == "odometry" || target == "poses" || target == "truth") {
      auto& pose = target == "odometry" ? mapping.odometry
                   : target == "poses"  ? mapping.poses
                                        : mapping.truth;
      if (pose) return refuse(fmt::format("{} is there twice", target));
      pose = pose_topic(source);
    } else {
      return refuse(fmt::format("{} is none of a bag's topics", in_quotes(word)));
    }
  }
  if (const std::string fault = fault_of_topics(mapping); !fault.empty()) return refuse(fault);
  return mapping;
}

Result<TopicMapping> read_topics(const std::string& path) {
  auto mapping = read_yaml_content<TopicMapping>(
      path, "octant_topics", [](YamlMap& root, YamlLog& log, TopicMapping& topics) {
        for (const YamlNode& item : root.list("ranges")) {
          YamlMap range(item, "ranges", log);
          topics.ranges.push_back({range.required_text("topic"), range.text("frame", ""),
                                   range.text("beacon", ""), range.text("receiver", ""),
                                   range.text("vehicle", "")});
          range.finish();
        }
        topics.odometry = pose_block(root, "odometry", log);
        topics.poses = pose_block(root, "poses", log);
        topics.truth = pose_block(root, "truth", log);
        topics.recorded_time = root.choice<bool>("time", {{"header", false}, {"recorded", true}}, false);
        topics.ignore = read_ignored(root, log);
      });
  if (!mapping) return mapping;
  if (const std::string fault = fault_of_topics(*mapping); !fault.empty())
    return fail({.file = path, .found = fault, .expected = "{beacon}, {receiver}, {vehicle} or *"});
  return mapping;
}

std::string topics_to_yaml(const TopicMapping& mapping) {
  YamlWriter yaml;
  yaml.begin_map(false);
  yaml.text("octant_topics");
  yaml.text("1");
  yaml.text("ranges");
  yaml.begin_list(false);
  for (const RangeTopics& r : mapping.ranges) {
    yaml.begin_map(true);
    write_entry(yaml, "topic", r.topic);
    write_entry(yaml, "frame", r.frame);
    write_entry(yaml, "beacon", r.beacon);
    write_entry(yaml, "receiver", r.receiver);
    write_entry(yaml, "vehicle", r.vehicle);
    yaml.end_map();
  }
  yaml.end_list();
  write_pose_topic(yaml, "odometry", mapping.odometry);
  write_pose_topic(yaml, "poses", mapping.poses);
  write_pose_topic(yaml, "truth", mapping.truth);
  yaml.text("time");
  yaml.text(mapping.recorded_time ? "recorded" : "header");
  write_ignored(yaml, mapping.ignore);
  yaml.end_map();
  return yaml.finish();
}

}  // namespace octant::io

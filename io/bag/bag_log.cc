// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/bag_log.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/bag/bag.h"
#include "io/bag/ros_messages.h"
#include "io/import/mapping_words.h"
#include "io/import/name_pattern.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kLargestArrival = 65'536;  ///< bytes of a JSON message
constexpr std::size_t kListedTopics = 20;

std::string listed_topics(const std::vector<BagTopic>& topics) {
  std::vector<std::string> words;
  words.reserve(topics.size());
  for (const BagTopic& t : topics)
    words.push_back(fmt::format("{} ({})", t.name, t.type.empty() ? "?" : t.type));
  std::ranges::sort(words);
  return words.empty() ? "the bag has no topics" : "topics of the bag: " + listed(words, kListedTopics);
}

/// Destination of the messages of a topic: arrivals by a rule for ranges, poses, or arrivals as octant
/// exports them.
struct TopicPlan {
  const RangeTopics* range = nullptr;
  std::map<std::string, std::string, std::less<>> names;  ///< names that the topic states for its ranges
  const PoseTopic* pose = nullptr;
  std::vector<TimedPose>* poses = nullptr;  ///< destination of the poses of `pose`
};

class BagLogReader {
 public:
  BagLogReader(const std::string& path, const TopicMapping& mapping) : mapping_(mapping) { log_.path = path; }

  Result<ImportedLog> read() {
    BagVisitor visitor;
    visitor.wants = [this](const BagTopic& topic) { return plan(topic); };
    visitor.message = [this](const BagMessage& message) { return take(message); };
    visitor.metadata = [this](const std::string& name, const std::map<std::string, std::string>& values) {
      const auto yaml = values.find(kRunYamlKey);
      if (name == kRunMetadata && yaml != values.end()) log_.run_yaml = yaml->second;
    };
    auto summary = read_bag(log_.path, visitor);
    if (!summary) return fail(summary.error());
    if (error_) return fail(*error_);
    for (auto& warning : summary->warnings) log_.warnings.push_back(std::move(warning));
    if (auto complete = check_found(); !complete) return fail(complete.error());
    if (unmatched_ > 0)
      log_.warnings.push_back(fmt::format("{}: {} ranges whose frame_id is as no pattern says are left out",
                                          log_.path, unmatched_));
    return std::move(log_);
  }

 private:
  Error bad(std::string found, std::string expected) const {
    return {.file = log_.path, .found = std::move(found), .expected = std::move(expected)};
  }

  bool refuse_type(const BagTopic& topic, const char* what, std::string expected) {
    if (!error_)
      error_ = bad(fmt::format("topic {} of type {} as {}", topic.name, in_quotes(topic.type), what),
                   std::move(expected));
    return false;
  }

  bool plan(const BagTopic& topic) {
    topics_.push_back(topic);
    TopicPlan plan;
    if (topic.type != kArrivalType || topic.encoding != "json") {
      if (!plan_poses(topic, plan) && !plan_ranges(topic, plan)) return false;
      if (topic.encoding != "cdr") {
        if (!error_)
          error_ = bad(fmt::format("topic {} in encoding {}", topic.name, in_quotes(topic.encoding)), "cdr");
        return false;
      }
    }
    plans_[topic.name] = std::move(plan);
    return true;
  }

  /// Topics of poses in the mapping, and their destinations.
  std::vector<std::pair<const PoseTopic*, std::vector<TimedPose>*>> pose_topics() {
    std::vector<std::pair<const PoseTopic*, std::vector<TimedPose>*>> topics;
    if (mapping_.odometry) topics.emplace_back(&*mapping_.odometry, &log_.odometry);
    if (mapping_.poses) topics.emplace_back(&*mapping_.poses, &log_.poses);
    if (mapping_.truth) topics.emplace_back(&*mapping_.truth, &log_.truth);
    return topics;
  }
  bool plan_poses(const BagTopic& topic, TopicPlan& plan) {
    for (const auto& [pose, poses] : pose_topics()) {
      if (pose->topic != topic.name) continue;
      if (!is_pose_type(topic.type))
        return refuse_type(
            topic, "poses",
            fmt::format("{}, {}, {} or {}", kRosPose, kRosPoseWithCovariance, kRosOdometry, kRosTransforms));
      plan.pose = pose;
      plan.poses = poses;
      return true;
    }
    return false;
  }

  bool plan_ranges(const BagTopic& topic, TopicPlan& plan) {
    for (const RangeTopics& range : mapping_.ranges) {
      plan.names.clear();
      if (!matches(range.topic, topic.name, plan.names)) continue;
      if (topic.type != kRosRange) {
        if (range.topic.find_first_of("*{") != std::string::npos) continue;
        return refuse_type(topic, "ranges", std::string(kRosRange));
      }
      plan.range = &range;
      return true;
    }
    return false;
  }

  Result<void> take(const BagMessage& message) {
    if (error_) return fail(*error_);
    const TopicPlan& plan = plans_.at(message.topic.name);
    ++taken_[message.topic.name];
    const bool whole = plan.range != nullptr  ? take_range(message, plan)
                       : plan.pose != nullptr ? take_poses(message, plan)
                                              : take_arrival(message);
    if (error_) return fail(*error_);
    if (whole) return {};
    return fail(bad(fmt::format("message {} of topic {}, {} bytes, is no {}", taken_[message.topic.name],
                                message.topic.name, message.data.size(), message.topic.type),
                    "messages as their type says"));
  }

  double time_of(double stamp_s, const BagMessage& message) const {
    // Drivers without time stamps write zero.
    return mapping_.recorded_time || stamp_s == 0.0 ? seconds_of(message.log_time_ns) : stamp_s;
  }

  /// Number of a name; -1 for an empty name.
  int number_of(std::string_view name) {
    if (name.empty()) return -1;
    if (!is_utf8(name) && !error_)
      error_ = bad(fmt::format("the name {}", in_quotes(name)), "a name in UTF-8");
    const int number = log_.names.number_of(name);
    if (number < 0 && !error_)
      error_ = bad(fmt::format("more than {} names of beacons and receivers", kMostImportedNames),
                   "as many as there may be at a site");
    return number;
  }

  bool ignores(const std::string& beacon) {
    if (!is_ignored(mapping_.ignore, beacon)) return false;
    ++log_.ignored[beacon];
    return true;
  }

  bool take_range(const BagMessage& message, const TopicPlan& plan) {
    const auto range = range_of(message.data);
    if (!range) return false;
    const RangeTopics& rule = *plan.range;
    auto names = plan.names;
    if (!rule.frame.empty() &&
        (range->frame.size() > kLongestTopic || !matches(rule.frame, range->frame, names)))
      return ++unmatched_, true;
    const auto named = [&](const char* what, const std::string& otherwise) {
      const auto found = names.find(what);
      return found == names.end() ? otherwise : found->second;
    };
    const std::string beacon = named("beacon", rule.beacon);
    if (ignores(beacon)) return true;
    if (!range->measured) return ++log_.not_heard, true;
    ImportedArrival a;
    a.time_s = time_of(range->stamp_s, message);
    a.value = range->range_m;
    a.is_distance = true;
    a.beacon = number_of(beacon);
    a.receiver = number_of(named("receiver", rule.receiver));
    a.vehicle = number_of(named("vehicle", rule.vehicle));
    log_.arrivals.push_back(a);
    return true;
  }

  bool take_arrival(const BagMessage& message) {
    if (message.data.size() > kLargestArrival) return false;
    const auto json = nlohmann::json::parse(message.data, nullptr, false);
    if (!json.is_object()) return false;
    const auto number = [&](const char* key, double otherwise) {
      const auto at = json.find(key);
      return at != json.end() && at->is_number() ? at->get<double>() : otherwise;
    };
    const auto text = [&](const char* key) {
      const auto at = json.find(key);
      return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
    };
    const std::string beacon = text("beacon");
    if (beacon.empty() || beacon.size() > kLongestTopic || !is_utf8(beacon)) return false;
    if (ignores(beacon)) return true;
    ImportedArrival a;
    a.time_s = number("time_s", NAN);
    a.value = number("tof_s", NAN);
    if (!std::isfinite(a.time_s)) return false;
    if (!std::isfinite(a.value)) return ++log_.not_heard, true;
    a.beacon = number_of(beacon);
    a.receiver = number_of(text("receiver"));
    a.vehicle = number_of(text("vehicle"));
    a.amplitude_v = number("amplitude_v", NAN);
    a.temperature_degC = number("temperature_degC", NAN);
    a.received_after_s = number("received_s", NAN) - a.time_s;
    if (const auto epoch = json.find("epoch"); epoch != json.end() && epoch->is_number_integer())
      a.epoch = epoch->get<std::int64_t>();
    log_.arrivals.push_back(a);
    return true;
  }

  bool take_poses(const BagMessage& message, const TopicPlan& plan) {
    const auto all = poses_of(message.topic.type, message.data);
    if (!all) return false;
    for (const RosPose& pose : *all)
      if ((plan.pose->parent.empty() || plan.pose->parent == pose.frame) &&
          (plan.pose->child.empty() || plan.pose->child == pose.child))
        plan.poses->push_back({time_of(pose.stamp_s, message), pose.T_frame_child});
    return true;
  }

  /// Checks that each requested topic exists, and that each requested frame of tf exists.
  Result<void> check_found() {
    const auto missing = [&](const std::string& name) {
      return std::ranges::none_of(topics_, [&](const BagTopic& t) { return t.name == name; });
    };
    std::vector<std::string> absent;
    for (const RangeTopics& r : mapping_.ranges)
      if (r.topic.find_first_of("*{") == std::string::npos && missing(r.topic)) absent.push_back(r.topic);
    for (const auto& [pose, poses] : pose_topics())
      if (missing(pose->topic)) absent.push_back(pose->topic);
    if (!absent.empty()) return fail(bad(fmt::format("no topic {}", listed(absent)), listed_topics(topics_)));
    for (const auto& [pose, poses] : pose_topics())
      if (poses->empty() && !(pose->parent.empty() && pose->child.empty()))
        return fail(bad(fmt::format("topic {} has no pose of {} in {}", pose->topic, in_quotes(pose->child),
                                    in_quotes(pose->parent)),
                        "frames as the bag has them"));
    return {};
  }

  const TopicMapping& mapping_;
  ImportedLog log_;
  std::vector<BagTopic> topics_;
  std::unordered_map<std::string, TopicPlan> plans_;
  std::unordered_map<std::string, std::size_t> taken_;
  std::size_t unmatched_ = 0;
  std::optional<Error> error_;
};

}  // namespace

Result<TopicMapping> topics_by_type(const std::string& path) {
  std::vector<BagTopic> topics;
  BagVisitor visitor;
  visitor.wants = [&topics](const BagTopic& topic) {
    topics.push_back(topic);
    return false;
  };
  visitor.message = [](const BagMessage&) { return Result<void>(); };
  if (auto read = read_bag(path, visitor); !read) return fail(read.error());
  TopicMapping mapping;
  bool arrivals = false;
  std::map<std::string, std::string> odometry;
  for (const BagTopic& t : topics) {
    arrivals = arrivals || t.type == kArrivalType;
    if (t.type == kRosRange && mapping.ranges.empty())
      mapping.ranges.push_back({"*", "{beacon}", "", "", ""});
    if (t.type == kRosOdometry) odometry[t.name] = t.type;
    if (t.name == kPosesTopic && is_pose_type(t.type)) mapping.poses = PoseTopic{t.name, "", ""};
    if (t.name == kTruthTopic && is_pose_type(t.type)) mapping.truth = PoseTopic{t.name, "", ""};
  }
  if (odometry.contains(kOdometryTopic)) {
    mapping.odometry = PoseTopic{kOdometryTopic, "", ""};
  } else if (odometry.size() == 1) {
    mapping.odometry = PoseTopic{odometry.begin()->first, "", ""};
  }
  if (arrivals || !mapping.ranges.empty() || mapping.odometry || mapping.poses) return mapping;
  return fail({.file = path,
               .found = "no topic of sensor_msgs/msg/Range and none of nav_msgs/msg/Odometry",
               .expected = "one of them, or --topics that says which topics are what",
               .advice = listed_topics(topics)});
}

Result<ImportedLog> read_bag_log(const std::string& path, const TopicMapping& mapping) {
  return BagLogReader(path, mapping).read();
}

}  // namespace octant::io

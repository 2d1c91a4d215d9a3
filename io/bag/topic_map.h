// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

// Mapping of the topics of a bag: `octant convert --topics`.
namespace octant::io {

/// Topics whose sensor_msgs/Range messages are arrivals. `topic` and `frame` (of the header's frame_id;
/// empty: any) are patterns: {beacon}, {receiver} and {vehicle} match a name without a slash, * matches any
/// text.
struct RangeTopics {
  std::string topic, frame;
  std::string beacon, receiver, vehicle;  ///< used where the patterns do not name it
};

/// Topic of poses; for tf also the two frames.
struct PoseTopic {
  std::string topic;
  std::string parent, child;  ///< empty: any
};

struct TopicMapping {
  std::vector<RangeTopics> ranges;
  std::optional<PoseTopic> odometry, poses, truth;
  bool recorded_time = false;       ///< use the time of recording instead of the message's own
  std::vector<std::string> ignore;  ///< beacons whose rows are left out, such as those of a neighbour
};

/// "range=/uwb/{receiver}/{beacon},range:B3=/kit/range_3,odometry=/odom,poses=/tf@map>base_link": ranges as
/// TOPIC or TOPIC@FRAME, with the beacon (and :receiver) behind `range:` where no pattern names it; poses,
/// odometry and truth as TOPIC or TOPIC@PARENT>CHILD; time=header (the default) or time=recorded.
/// Errors: kUsage, naming the word.
[[nodiscard]] Result<TopicMapping> topics_from_words(std::string_view words);
/// Reads a mapping from a file: octant_topics: 1, ranges: [{topic, frame, beacon, receiver, vehicle}],
/// odometry, poses, truth: {topic, parent, child}, time: header | recorded, ignore: [...].
[[nodiscard]] Result<TopicMapping> read_topics(const std::string& path);
[[nodiscard]] std::string topics_to_yaml(const TopicMapping& mapping);

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/bag/topic_map.h"
#include "io/import/imported_log.h"
#include "models/support/result.h"

// Bags of ROS 2 (rosbag2's .db3, MCAP), without ROS.
namespace octant::io {

/// Whether a path is one, or a folder with some.
[[nodiscard]] bool is_bag(const std::string& path);

/// What the topics of a bag most likely are: all Range by frame_id as the beacon's name; the one topic of
/// nav_msgs/Odometry as odometry; /octant/odometry, /octant/poses and /octant/truth, which
/// `octant export` writes. Errors: those of reading; kBadInput, listing the topics, where there is nothing.
[[nodiscard]] Result<TopicMapping> topics_by_type(const std::string& path);

/// Reads a bag by a mapping: arrivals from sensor_msgs/Range and from octant.Arrival (JSON, as `octant
/// export` writes them, of whatever topic), odometry, measured poses and reference from PoseStamped,
/// PoseWithCovarianceStamped, nav_msgs/Odometry and tf. Errors: kBadInput: topics that the bag has not (it is
/// said which it has), types that are none of these, messages that end early.
[[nodiscard]] Result<ImportedLog> read_bag_log(const std::string& path, const TopicMapping& mapping);

inline constexpr const char* kArrivalType = "octant.Arrival";
inline constexpr const char *kOdometryTopic = "/octant/odometry", *kPosesTopic = "/octant/poses",
                            *kTruthTopic = "/octant/truth";
/// Name of the metadata that hold run.yaml, and their key.
inline constexpr const char *kRunMetadata = "octant.run", *kRunYamlKey = "run.yaml";

}  // namespace octant::io

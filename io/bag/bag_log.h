// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/bag/topic_map.h"
#include "io/import/imported_log.h"
#include "models/support/result.h"

// Bags of ROS 2 (rosbag2's .db3, MCAP), without ROS.
namespace octant::io {

/// Returns true if a path is a bag, or a folder with bags.
[[nodiscard]] bool is_bag(const std::string& path);

/// Guesses the mapping from the types of the topics: all Range topics with the frame_id as the beacon's name,
/// the only topic of nav_msgs/Odometry as odometry, and /octant/odometry, /octant/poses and /octant/truth as
/// `octant export` writes them. Errors: those of the reader; kBadInput, with a list of the topics, if no
/// topic fits.
[[nodiscard]] Result<TopicMapping> topics_by_type(const std::string& path);

/// Reads a bag by a mapping: arrivals from sensor_msgs/Range and octant.Arrival (JSON, as `octant export`
/// writes them, on any topic); odometry, measured poses and reference poses from PoseStamped,
/// PoseWithCovarianceStamped, nav_msgs/Odometry and tf. Errors: kBadInput: topics that are missing (the
/// message lists those that exist), types that are not supported, truncated messages.
[[nodiscard]] Result<ImportedLog> read_bag_log(const std::string& path, const TopicMapping& mapping);

inline constexpr const char* kArrivalType = "octant.Arrival";
inline constexpr const char *kOdometryTopic = "/octant/odometry", *kPosesTopic = "/octant/poses",
                            *kTruthTopic = "/octant/truth";
/// Name of the metadata record with run.yaml, and its key.
inline constexpr const char *kRunMetadata = "octant.run", *kRunYamlKey = "run.yaml";

}  // namespace octant::io

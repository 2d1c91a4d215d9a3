// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "apps/octant/session.h"
#include "models/localizers/methods.h"

namespace octant::app {

inline const std::vector<std::string> kLiveFormats = {"json", "nmea", "ros", "mavlink"};

/// Arguments of `octant localize --follow`.
struct FollowArgs {
  bool follow = false;
  std::string from = "-";                  ///< ByteSource
  std::string format = "json";             ///< one of kLiveFormats
  std::string mavlink_message = "vision";  ///< vision, odometry, gps
  std::string origin;                      ///< LAT,LON[,ALT] of the map's origin; nmea, gps
  std::optional<double> north_deg;         ///< direction of north in the map, counter-clockwise from +x
  bool watch = false;
  double lateness_s = 0.2;  ///< rows may arrive in any order within this time
  std::string odometry;     ///< run.yaml, or a folder with one, with the accuracy of the odometry
};
void add_follow_options(CLI::App& command, FollowArgs& args);

/// Localizes a live stream until it ends or a signal requests an end. Reads arrivals and odometry as JSON
/// lines and writes fixes to standard output. Invalid lines are counted and reported. SIGHUP reads the
/// deployment again; an invalid one is reported, and the previous one remains in use.
int follow(const FollowArgs& args, const std::string& deployment, const std::string& trusted_key,
           Method method, Session& session);

}  // namespace octant::app

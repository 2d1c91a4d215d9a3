// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "apps/octant/session.h"
#include "models/localizers/methods.h"

namespace octant::app {

/// The words of `octant localize --follow`.
struct FollowArgs {
  bool follow = false;
  std::string from = "-";       ///< ByteSource
  std::string format = "json";  ///< json, nmea, ros
  std::string origin;           ///< LAT,LON[,ALT] of the map's origin; nmea
  double north_deg = 90.0;      ///< direction of north in the map, counter-clockwise from +x
  bool watch = false;
  double lateness_s = 0.2;  ///< rows may come in any order within it
  std::string odometry;     ///< run.yaml, or a folder with one: how good the odometry is
};
void add_follow_options(CLI::App& command, FollowArgs& args);

/// Localizes what comes, until it ends or a signal says so: arrivals and odometry in as JSON lines, fixes out
/// on standard output. Lines that say nothing sensible are counted and reported. SIGHUP reads the deployment
/// anew; a bad one is reported, and the old one goes on.
int follow(const FollowArgs& args, const std::string& deployment, const std::string& trusted_key,
           Method method, Session& session);

}  // namespace octant::app

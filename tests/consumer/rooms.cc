// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Objects that cross between a program and the libraries: matrices that one side allocates and the other
// frees, values that contain Eigen's types, localizers that live on either side.
#include <cstdio>
#include <memory>
#include <vector>

#include <Eigen/Dense>

#include <octant/io/deployment/deployment_json.h>
#include <octant/io/run/run_folder.h>
#include <octant/models/live/follower.h>
#include <octant/models/localizers/least_squares/epoch_fix.h>
#include <octant/models/localizers/methods.h>
#include <octant/models/watch/watch.h>

int main(int count, char** words) {
  if (count < 3) return 2;
  auto deployment = octant::io::read_deployment(words[1]);
  if (!deployment) return std::puts(deployment.error().message().c_str()), 3;
  octant::Deployment copy = *deployment;
  copy.covariance.matrix =
      Eigen::MatrixXd::Identity(7, 7);         // allocated here, freed here after the other's went
  deployment->covariance.matrix.resize(0, 0);  // allocated there, freed here
  copy.covariance.matrix.resize(0, 0);
  copy.covariance.parameters.clear();

  const auto run = octant::io::read_run(words[2], names_of(copy), copy.timing);
  if (!run) return std::puts(run.error().message().c_str()), 3;
  const auto fixes = octant::locate_run(octant::Method::kAuto, copy, *run);
  if (!fixes) return std::puts(fixes.error().message().c_str()), 3;

  octant::FollowOptions options;
  options.watch = true;
  octant::Follower follower(copy, options);
  std::vector<octant::Fix> live;
  follower.on_fix = [&live](const octant::Fix& fix) { live.push_back(fix); };
  for (const octant::Arrival& arrival : run->arrivals) follower.hear(arrival);
  follower.flush();
  if (live.size() != fixes->size()) return std::puts("the follower gives other fixes"), 1;
  double apart_m = 0.0;
  for (std::size_t i = 0; i < live.size(); ++i)
    apart_m += (live[i].T_map_vehicle.translation_m - (*fixes)[i].T_map_vehicle.translation_m).norm();
  const Eigen::MatrixXd mean = fixes->front().covariance * 0.5;
  const octant::Pose& pose = fixes->front().T_map_vehicle;
  std::printf("x %.3f m, y %.3f m, %zu fixes, %.1e %zu\n", pose.translation_m.x(), pose.translation_m.y(),
              fixes->size(), apart_m, static_cast<std::size_t>(mean.rows()));
  return apart_m < 1e-9 ? 0 : 1;
}

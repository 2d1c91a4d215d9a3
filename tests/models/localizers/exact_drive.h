// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/physics/measurement.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {

/// Half a second of a drive: odometry that is exact, a beacon at each row.
struct ExactDrive {
  Deployment d = with_receiver(hall(), {0.3, 0.0, 0.3});
  EpochFixModel model = epoch_fix_model(d);
  Trajectory t;
  std::vector<Pose> truth;

  ExactDrive() {
    t.moving = true;
    for (int k = 0; k < 12; ++k) {
      truth.push_back(Pose::planar(7 + 0.1 * k, 5 + 0.01 * k * k, 0.1 + 0.02 * k));
      Node node;
      node.time_s = 0.1 * k;
      t.nodes.push_back(node);
      if (k > 0)
        t.odometry.push_back({static_cast<std::size_t>(k - 1),
                              truth[static_cast<std::size_t>(k - 1)].inverse() * truth.back(), 0.03, 0.01});
    }
    for (std::uint32_t k = 0; k + 1 < 12; ++k) {
      ArrivalObservation a;
      a.node = k;
      a.alpha = 0.4;
      a.beacon = BeaconId(static_cast<std::size_t>(k) % 8);
      a.receiver = ReceiverId(0);
      a.sigma_s = 1e-5;
      a.model_speed_mps = 343.7;
      const Pose T = interpolate(truth[k], truth[k + 1], 0.4);
      PathInput in = path_of(t, a, model.state);
      in.T_map_vehicle = &T;
      a.tof_s = predict_arrival_value(in).tof_s;
      t.arrivals.push_back(a);
    }
    t.segments.push_back({.last_node = 12, .last_arrival = 11, .last_odometry = 11});
  }
};

}  // namespace octant::test

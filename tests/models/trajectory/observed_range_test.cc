// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// All conversions of a time of flight to a range agree, and give the length of the path.
#include "models/trajectory/observed_range.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/localizers/common/arrival_range.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace observed_range_test {

/// A stop among three beacons, one with half the amplitude of the others, without noise.
struct Heard {
  Deployment deployment;
  SharedState state;
  MeasurementLog log;
  Trajectory t;

  explicit Heard(Ranging ranging, Clock clock = Clock::kSynchronised) {
    Scenario hall = hall_scenario();
    hall.path.epochs = hall.heldout_path.epochs = 1;
    deployment = must(simulate(hall, 1)).truth;
    deployment.attenuation = AttenuationModel{
        .amplitude_1m_v = 1.0, .absorption_np_per_m = 0.05, .threshold_v = 0.01, .rise_time_s = 300e-6};
    deployment.beacons[1].gain = 0.5;
    deployment.speed_offset_mps = 0.7;
    deployment.timing.ranging = ranging;
    deployment.timing.clock = clock;
    deployment.timing.turnaround_s = ranging == Ranging::kTwoWay ? 1.5e-3 : 0.0;
    for (DeploymentReceiver& r : deployment.receivers) r.delay_s = 2e-6;
    state = shared_state(deployment);
    t.has_cycle_offset = clock == Clock::kCycleOffset;
    t.turnaround_s = deployment.timing.turnaround_s;
    t.T_hear_send = {Pose()};
    Node node;
    node.T_map_vehicle = Pose::planar(8, 5, 0.3);
    node.placed = true;
    node.cycle_offset_s = t.has_cycle_offset ? 4e-3 : 0.0;
    t.nodes = {node};
    for (std::size_t b = 0; b < 3; ++b) {
      ArrivalObservation a;
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(b);
      a.sigma_s = 1e-5;
      a.model_speed_mps = speed_mps(deployment.medium, deployment.medium.temperature_degC);
      a.two_way = ranging == Ranging::kTwoWay;
      a.hear_send = 0;
      PathInput path = path_of(t, a, state);
      path.T_map_vehicle = &t.nodes[0].T_map_vehicle;
      a.tof_s = predict_arrival_value(path).tof_s + node.cycle_offset_s;
      t.arrivals.push_back(a);
    }
  }
  [[nodiscard]] double way_m(std::size_t i) const {
    const ArrivalObservation& a = t.arrivals[i];
    return (t.nodes[0].T_map_vehicle * state.receiver_p_vehicle_m[a.receiver.index()] -
            state.beacon_p_map_m[a.beacon.index()])
        .norm();
  }
};

TEST(ObservedRange, IsTheWayThatTheSignalTook) {
  for (const Ranging ranging : {Ranging::kOneWay, Ranging::kTwoWay}) {
    const Heard heard(ranging);
    for (std::size_t i = 0; i < heard.t.arrivals.size(); ++i)
      EXPECT_NEAR(observed_range_m(heard.t, heard.t.arrivals[i], heard.state), heard.way_m(i), 1e-10) << i;
  }
}

TEST(ObservedRange, IsThatOfAnArrivalAndItsDeployment) {
  for (const Ranging ranging : {Ranging::kOneWay, Ranging::kTwoWay}) {
    const Heard heard(ranging);
    for (const ArrivalObservation& a : heard.t.arrivals) {
      Arrival recorded;
      recorded.beacon = a.beacon;
      recorded.receiver = a.receiver;
      recorded.tof_s = a.tof_s;
      EXPECT_NEAR(arrival_range(recorded, heard.deployment).range_m,
                  observed_range_m(heard.t, a, heard.state), 1e-10);
    }
  }
}

TEST(ObservedRange, AnOffsetThatIsNotKnownStaysInIt) {
  const Heard heard(Ranging::kOneWay, Clock::kCycleOffset);
  for (std::size_t i = 0; i < heard.t.arrivals.size(); ++i) {
    const ArrivalObservation& a = heard.t.arrivals[i];
    EXPECT_NEAR(observed_range_m(heard.t, a, heard.state, 4e-3), heard.way_m(i), 1e-10);
    EXPECT_GT(observed_range_m(heard.t, a, heard.state), heard.way_m(i) + 4e-3 * 340.0);
  }
}

}  // namespace observed_range_test
}  // namespace octant::test

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// All shared parameters, free at once: the derivatives of a row compared with differences of its residual, so
// that a parameter missing from a path is detected.
#include "calib/problem/shared_entries.h"

#include <set>

#include <gtest/gtest.h>

#include "models/trajectory/linearise.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace shared_entries_test {

/// A stop in the hall; two vehicles, so that one has an array as a whole and one its receivers on their own.
struct Stop {
  calib::Problem problem;
  calib::ParameterLayout layout;
  SharedState state;
  Trajectory t;

  explicit Stop(std::size_t vehicle) {
    Scenario hall = hall_scenario();
    Site& site = hall.site;
    add_attenuation(hall);
    site.attenuation->half_power_angle_rad = {0.9, 0.1};
    for (SiteBeacon& b : site.beacons) b.log_gain = {0.1, 0.2};
    add_receivers(site, {{0.1, 0.0, 0.3}, {-0.2, 0.1, 0.4}}, 0.01, "cart");
    for (SiteReceiver& r : site.receivers) r.axis = Eigen::Vector3d(0.6, 0.0, 0.8);
    site.vehicles[0].array.emplace();
    site.vehicles[0].array->radius_sigma_m = 0.01;
    site.vehicles[0].array->turn_sigma_rad = 0.05;
    site.timing.delay_per = {.beacon = true, .receiver = true, .site = true};
    site.timing.delay_sigma_s = 1e-4;
    site.timing.clock = Clock::kCycleOffset;
    site.timing.drift_sigma = 1e-4;
    site.noise.pair_sigma_s = 1e-6;
    problem.site = site;
    problem.runs.resize(1);
    state = prior_state(site);
    layout = calib::make_layout(problem, state);
    state = layout.state_of(layout.vector_of(state));
    t.vehicle = VehicleId(vehicle);
    t.has_cycle_offset = true;
    Node node;
    node.T_map_vehicle = Pose::planar(9, 5, 0.4);
    t.nodes = {node};
    for (std::size_t r = 0; r < site.receivers.size(); ++r) {
      if (site.receivers[r].vehicle != t.vehicle) continue;
      ArrivalObservation a;
      a.beacon = BeaconId(1 + r % (site.beacons.size() - 1));
      a.receiver = ReceiverId(r);
      a.time_s = 0.3;
      a.tof_s = 0.02;
      a.sigma_s = 1e-5;
      a.model_speed_mps = 343.0;
      a.log_amplitude_sigma = 0.05;
      t.arrivals.push_back(a);
    }
  }
};

class SharedEntries : public testing::TestWithParam<std::size_t> {};

TEST_P(SharedEntries, AreTheDerivativesByEveryParameterThereIs) {
  const Stop stop(GetParam());
  const Eigen::VectorXd x = stop.layout.vector_of(stop.state);
  constexpr double kStep = 1e-6;
  for (std::size_t i = 0; i < stop.t.arrivals.size(); ++i) {
    ObservationRow at[2], before[2], after[2];
    ASSERT_EQ(arrival_rows(stop.t, i, stop.state, at), 2);
    Eigen::MatrixXd said = Eigen::MatrixXd::Zero(2, x.size()), differs = said;
    for (int k = 0; k < 2; ++k) {
      const calib::RowEntries e = calib::row_entries(at[k], 0, stop.layout, stop.state);
      for (std::size_t j = 0; j < static_cast<std::size_t>(e.count); ++j) said(k, e.column[j]) += e.value[j];
    }
    for (Eigen::Index c = 0; c < x.size(); ++c) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(x.size(), c);
      (void)arrival_rows(stop.t, i, stop.layout.state_of(x - step), before);
      const SharedState ahead = stop.layout.state_of(x + step);
      (void)arrival_rows(stop.t, i, ahead, after);
      EXPECT_NEAR(arrival_residual(stop.t, stop.t.arrivals[i], ahead), after[0].residual,
                  1e-12 * (1 + std::abs(after[0].residual)));
      for (int k = 0; k < 2; ++k) differs(k, c) = (after[k].residual - before[k].residual) / (2 * kStep);
    }
    for (Eigen::Index c = 0; c < x.size(); ++c)
      for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(said(k, c), differs(k, c), 1e-5 * (1 + std::abs(differs(k, c))))
            << "arrival " << i << ", row " << k << ", parameter "
            << parameter_name(stop.layout.parameters[static_cast<std::size_t>(c)].id,
                              names_of(stop.problem.site));
  }
}

TEST_P(SharedEntries, APathTouchesEachKindThatItsVehicleHas) {
  const Stop stop(GetParam());
  std::set<ParameterKind> touched, free;
  for (const calib::PathColumns::Column& of :
       calib::path_columns(stop.layout, stop.t.arrivals[0].beacon, stop.t.arrivals[0].receiver, 0))
    touched.insert(stop.layout.parameters[static_cast<std::size_t>(of.column)].id.kind);
  for (const calib::Parameter& p : stop.layout.parameters) free.insert(p.id.kind);
  EXPECT_EQ(free.size(), kParameterKinds) << "the stop lacks a kind of parameter";
  free.erase(GetParam() == 0 ? ParameterKind::kReceiverPosition : ParameterKind::kArray);
  EXPECT_EQ(touched, free);
}

TEST_P(SharedEntries, AReflectorThatIsSeenHasItsPlaceAlone) {
  const Stop stop(GetParam());
  for (const calib::PathColumns::Column& of : calib::path_columns(stop.layout, BeaconId(1), ReceiverId(), 0))
    EXPECT_EQ(stop.layout.parameters[static_cast<std::size_t>(of.column)].id.kind,
              ParameterKind::kBeaconPosition);
}

INSTANTIATE_TEST_SUITE_P(AnArrayAsAWholeAndReceiversOnTheirOwn, SharedEntries, testing::Values(0, 1),
                         [](const auto& of) { return of.param == 0 ? "array" : "receivers"; });

}  // namespace shared_entries_test
}  // namespace octant::test

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/survey/report_input.h"

#include <limits>

namespace octant::survey {

DeploymentBeacon test_beacon(const std::string& name, double x_m, double y_m, double sigma_m,
                             BeaconStatus status) {
  DeploymentBeacon b;
  b.name = name;
  b.position_m = {x_m, y_m, 2.5};
  b.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  b.status = status;
  b.delay_s = 1e-4;
  b.delay_sigma_s = 2e-6;
  return b;
}

ReportInput full_report() {
  ReportInput input;
  Deployment& d = input.plan.deployment;
  d.site = "hall";
  d.created = "2026-01-01T00:00:00Z";
  d.statistics = {2000, 20, 300, 1700.0, 1.02, 0.4, 9e-6, true};
  d.datum.description = "position by control points (B0)";
  d.program_version = "0.1.0";
  d.program_command = "octant calibrate site.yaml run -o deployment.json";
  d.inputs = {{"site.yaml", std::string(64, 'a')}};
  d.beacons = {test_beacon("B0", 0, 0, 0, BeaconStatus::kControlPoint),
               test_beacon("B1", 10, 0, 0.002, BeaconStatus::kCalibrated),
               test_beacon("B2", 10, 8, 0.001, BeaconStatus::kCalibrated)};
  d.validity_area_m = {{1, 1}, {9, 1}, {9, 7}};
  input.plan.tracks = {{false, {{2, 2, 0}, {3, 3, 0}}}, {true, {{4, 4, 0}, {5, 5, 0}, {6, 5, 0}}}};
  input.plan.fixes_m = {{5, 6, 0}};
  const double none = std::numeric_limits<double>::quiet_NaN();
  input.plan.maps = {{"HDOP", "", {0, 0}, 5.0, 2, {1.0, 2.0, 3.0, none}},
                     {"error", "mm", {0, 0}, 5.0, 2, {4.0, 5.0, 6.0, 7.0}}};
  input.beacons = {{"B0", 700, 3, 0.8, 9e-6, 1.0, 5e-5, 0.001, 2e-4, 0.0005},
                   {"B1", 650, 10, 0.75, 9e-6, 1.1, 5e-5, 0.002, 2e-4, 0.0006},
                   {"B2", 650, 7, 0.7, 9e-6, 0.9, 5e-5, 0.003, 2e-4, 0.0007}};
  input.weak = {{"speed and scale", "tape one distance", 0.001, false}};
  input.left_out = {{"late (echo)", 20}};
  input.residuals = {{"beacon", "", {{"B0", 0, 0, 700, 1e-7, 9e-6}, {"B1", 0, 0, 650, -2e-7, 9e-6}}},
                     {"distance", "m", {{"", 2, 5, 900, 1e-7, 8e-6}, {"", 5, 9, 1100, 2e-7, 9e-6}}}};
  input.stops = {{"7", false, {2, 2}, 40, 15, 3, 0, 40, 1e-6, 3e-5},
                 {"8", false, {3, 3}, 50, 2, 0, 0, 50, 0, 9e-6}};
  input.misses = {{"B1", {2, 2}, 15, 0, 0}, {"B2", {2, 2}, 0, 3, 0}, {"B1", {3, 3}, 2, 0, 0}};
  input.words = {{"variance factor", "How large the squared residuals are."}};
  input.standardised = Histogram{-6.0, 3.0, {10, 990, 985, 15}};
  input.looked_at = 2000;
  input.evaluation = Evaluation{};
  input.evaluation->fixes = input.evaluation->matched = 3;
  input.evaluation->position_rmse_m = 0.008;
  input.evaluation->error_quantiles_m = {0.001, 0.005, 0.012};
  input.evaluation->gates = {{"fix_m", 0.02, 0.008, true}};
  input.losses = {{"B1", 0.8, 1.9, 4.0, input.plan.maps[0]}, {"B2", 0.9, 1.5, 3.0, input.plan.maps[0]}};
  input.no_loss = BeaconLoss{"", 1.0, 1.2, 2.0, input.plan.maps[0]};
  input.loss_name = "HDOP";
  input.changes = Changes{"2025-01-01T00:00:00Z",
                          true,
                          {{"B1", {0.02, 0, 0}, {0.003, 0.003, 0.003}, 1e-9, 1e-6, 2e-6, {}, true}},
                          {"B9"},
                          {"B2"},
                          {},
                          kFalseAlarm,
                          {},
                          0.1,
                          0.2};
  input.warnings = {"run/tof.csv:3: odd"};
  input.command = "octant report deployment.json -o report.html";
  input.options = {"threads 2"};
  return input;
}

ReportInput report_full_of(const std::string& text) {
  ReportInput input = full_report();
  Deployment& d = input.plan.deployment;
  for (std::string* s : {&d.site,
                         &d.created,
                         &d.datum.description,
                         &d.program_command,
                         &d.program_version,
                         &d.inputs[0].path,
                         &d.inputs[0].sha256,
                         &input.message,
                         &input.weak[0].description,
                         &input.weak[0].remedy,
                         &input.left_out[0].reason,
                         &input.stops[0].name,
                         &input.words[0].first,
                         &input.words[0].second,
                         &input.evaluation->gates[0].name,
                         &input.losses[0].beacon,
                         &input.losses[0].map->silent_beacon,
                         &input.plan.maps[0].name,
                         &input.plan.maps[0].unit,
                         &input.loss_name,
                         &input.changes->since,
                         &input.changes->beacons[0].name,
                         &input.changes->gone[0],
                         &input.changes->added[0],
                         &input.command,
                         &input.options[0],
                         &input.warnings[0]})
    *s = text;
  for (auto& b : d.beacons) b.name = text;
  for (auto& b : input.beacons) b.name = text;
  for (auto& m : input.misses) m.beacon = text;
  for (auto& b : input.residuals[0].bins) b.name = text;
  return input;
}

}  // namespace octant::survey

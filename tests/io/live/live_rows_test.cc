// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/live_rows.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/live/live_fixes.h"

namespace octant::io {
namespace live_rows_test {

NameTable two_vehicles() {
  NameTable names;
  names.beacons = {"B0", "B1", "7"};
  names.vehicles = {"robot", "cart"};
  names.receivers = {{"front", VehicleId(0)}, {"rear", VehicleId(0)}, {"mast", VehicleId(1)}};
  return names;
}

std::string found(const LiveReader& reader, std::string_view line) {
  const auto row = reader.row(line);
  return row ? "" : row.error().found;
}

TEST(LiveRows, Arrivals) {
  const LiveReader reader(two_vehicles());
  const auto row = reader.row(
      R"({"time_s": 1.5, "beacon": "B1", "tof_s": 0.01, "vehicle": "cart", "epoch": 4, "amplitude_v": 0.5, "strange": []})");
  ASSERT_TRUE(row);
  const auto& a = std::get<Arrival>(*row);
  EXPECT_EQ(a.time_s, 1.5);
  EXPECT_EQ(a.tof_s, 0.01);
  EXPECT_EQ(a.beacon, BeaconId(1));
  EXPECT_EQ(a.vehicle, VehicleId(1));
  EXPECT_EQ(a.receiver, ReceiverId(2));  // the cart's only one
  EXPECT_EQ(a.epoch, 4);
  EXPECT_EQ(a.amplitude_v, 0.5);
  EXPECT_TRUE(std::isnan(a.temperature_degC));
  const auto numbered =
      reader.row(R"({"time_s": 1, "beacon": 7, "receiver": "rear", "tof_s": 1e-3, "epoch": null})");
  ASSERT_TRUE(numbered);
  EXPECT_EQ(std::get<Arrival>(*numbered).beacon, BeaconId(2));
  EXPECT_EQ(std::get<Arrival>(*numbered).epoch, kNoEpoch);
}

TEST(LiveRows, OdometryAndTheRest) {
  const LiveReader reader(two_vehicles());
  const auto row = reader.row(R"({"time_s": 2, "dx_m": 0.1, "dheading_rad": -0.01})");
  ASSERT_TRUE(row);
  const auto& step = std::get<OdometryStep>(*row);
  EXPECT_EQ(step.dx_m, 0.1);
  EXPECT_EQ(step.dy_m, 0.0);
  EXPECT_EQ(step.dheading_rad, -0.01);
  EXPECT_EQ(step.vehicle, VehicleId(0));
  EXPECT_TRUE(std::holds_alternative<LiveFlush>(*reader.row(R"({"flush": true})")));
  for (const char* nothing : {"", "   ", "\r", "# words", "  # words"})
    EXPECT_TRUE(std::holds_alternative<std::monostate>(*reader.row(nothing))) << nothing;
}

TEST(LiveRows, OdometryInSpace) {
  const LiveReader reader(two_vehicles());
  // A quarter turn about x, of another length than one.
  const auto row =
      reader.row(R"({"time_s": 2, "dx_m": 0.1, "dz_m": 0.3, "qx": 2, "qy": 0, "qz": 0, "qw": 2})");
  ASSERT_TRUE(row);
  const auto& step = std::get<OdometryStep>(*row);
  EXPECT_EQ(step.dz_m, 0.3);
  EXPECT_NEAR(step.turn_x_rad, 1.5707963267948966, 1e-15);
  EXPECT_NEAR(step.turn_y_rad, 0.0, 1e-15);
  EXPECT_NEAR(step.dheading_rad, 0.0, 1e-15);
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dx_m": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 0})"), "no rotation");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dx_m": 0, "qx": 0, "qy": 0, "qw": 1})"), "no rotation");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dheading_rad": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1})"),
            "both a quaternion and dheading_rad");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dx_m": 0, "dz_m": "up"})"),
            "dx_m, dy_m, dz_m or dheading_rad is no number");
}

TEST(LiveRows, DistancesWhereTheSpeedIsConstant) {
  const char* line = R"({"time_s": 0, "vehicle": "cart", "beacon": "B0", "distance_m": 6.0})";
  EXPECT_EQ(found(LiveReader(two_vehicles()), line), "tof_s is missing or no number");
  const auto row = LiveReader(two_vehicles(), 3e8).row(line);
  ASSERT_TRUE(row);
  EXPECT_DOUBLE_EQ(std::get<Arrival>(*row).tof_s, 2e-8);
}

TEST(LiveRows, EveryFaultHasAName) {
  const LiveReader reader(two_vehicles());
  EXPECT_EQ(found(reader, "time"), "not JSON");
  EXPECT_EQ(found(reader, "[]"), "not a JSON object");
  EXPECT_EQ(found(reader, "{}"), "time_s is missing or no number");
  EXPECT_EQ(found(reader, R"({"time_s": "1"})"), "time_s is missing or no number");
  EXPECT_EQ(found(reader, R"({"time_s": 1})"), "neither an arrival nor odometry");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "vehicle": "x"})"), "unknown vehicle 'x'");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "vehicle": {}})"), "vehicle is no name");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B9"})"), "unknown beacon 'B9'");
  EXPECT_EQ(found(reader, "{\"time_s\": 1, \"beacon\": \"a\\u0001\\u00e9\"}"),
            "unknown beacon 'a?"
            "??'");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B0", "tof_s": 1})"),
            "receiver is missing, and there are several");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B0", "receiver": "mast", "tof_s": 1})"),
            "unknown receiver 'mast'");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B0", "receiver": "rear", "tof_s": null})"),
            "tof_s is missing or no number");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B0", "receiver": "rear", "tof_s": 1e300})"),
            "tof_s is impossibly large");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "beacon": "B0", "receiver": "rear", "tof_s": 1, "epoch": 1.5})"),
            "epoch is no integer");
  EXPECT_EQ(
      found(reader,
            R"({"time_s": 1, "beacon": "B0", "receiver": "rear", "tof_s": 1, "temperature_degC": 294.15})"),
      "temperature_degC is beyond 100 degrees Celsius (20 degC are 293 K)");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dx_m": 1e999})"), "not JSON");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dy_m": 0, "dx_m": 1e160})"),
            "dx_m, dy_m or dz_m is impossibly large");
  EXPECT_EQ(found(reader, R"({"time_s": 1, "dx_m": [1]})"), "dx_m, dy_m, dz_m or dheading_rad is no number");
}

TEST(LiveRows, AnyBytes) {
  const LiveReader reader(two_vehicles());
  std::mt19937 random(20261122);
  const std::string good = R"({"time_s": 1.5, "beacon": "B1", "tof_s": 0.01, "vehicle": "cart", "epoch": 4})";
  for (int i = 0; i < 20000; ++i) {
    std::string line = good;
    for (unsigned k = random() % 6; k > 0; --k) line[random() % line.size()] = static_cast<char>(random());
    line.resize(random() % (line.size() + 1));
    (void)reader.row(line);
  }
  (void)reader.row(std::string(60000, '['));
  (void)reader.row(std::string(60000, '{'));
}

TEST(LineCutter, LinesOverPiecesAndLongOnes) {
  std::string text = "a\r\nbc\n\n";
  text += std::string(100, 'x') + "\nd";
  for (std::size_t piece = 1; piece <= text.size(); ++piece) {
    LineCutter cutter(10);
    std::vector<std::string> lines;
    int too_long = 0;
    const auto line = [&](std::string_view l) { lines.emplace_back(l); };
    const auto count = [&] { ++too_long; };
    for (std::size_t at = 0; at < text.size(); at += piece) cutter.feed(text.substr(at, piece), line, count);
    cutter.end(line, count);
    cutter.end(line, count);
    EXPECT_EQ(lines, (std::vector<std::string>{"a", "bc", "", "d"})) << piece;
    EXPECT_EQ(too_long, 1) << piece;
  }
}

Fix some_fix() {
  Fix fix;
  fix.status = FixStatus::kOk;
  fix.time_s = 86399.999;
  fix.vehicle = VehicleId(0);
  fix.T_map_vehicle = Pose::planar(10.0, 20.0, 0.5);
  fix.covariance = Eigen::Vector3d(1e-4, 4e-4, 1e-6).asDiagonal().toDenseMatrix();
  fix.arrivals_used = 5;
  return fix;
}

TEST(LiveFixes, JsonIsJson) {
  const auto object = nlohmann::json::parse(fix_as_json(some_fix(), two_vehicles()));
  EXPECT_EQ(object["x_m"], 10.0);
  EXPECT_EQ(object["sigma_y_m"], 0.02);
  EXPECT_EQ(object["vehicle"], "robot");
  EXPECT_FALSE(object.contains("epoch"));
  Fix none;
  const auto missing = nlohmann::json::parse(fix_as_json(none, two_vehicles()));
  EXPECT_EQ(missing["status"], "too_few_arrivals");
  EXPECT_FALSE(missing.contains("x_m"));
  EXPECT_EQ(fix_as_ros(none, two_vehicles()), "");
  const auto ros = nlohmann::json::parse(fix_as_ros(some_fix(), two_vehicles()));
  EXPECT_EQ(ros["child_frame_id"], "robot/base_link");
  EXPECT_EQ(ros["header"]["stamp"]["sec"], 86399);
  EXPECT_EQ(ros["pose"]["covariance"][35], 1e-6);
  EXPECT_EQ(ros["pose"]["covariance"][7], 4e-4);
  EXPECT_EQ(ros["twist"]["covariance"][0], -1);
}

TEST(LiveFixes, VelocityAndCovarianceAreInEachFormat) {
  Fix fix = some_fix();
  fix.covariance(0, 1) = fix.covariance(1, 0) = 1.5e-4;
  fix.velocity = VelocityEstimate{};
  fix.velocity->mean << 2.0, 0.0, 0.0, 0.0, 0.0, 0.25;
  fix.velocity->variance << 1e-4, 1e-4, 0.0, 0.0, 0.0, 4e-4;
  const auto json = nlohmann::json::parse(fix_as_json(fix, two_vehicles()));
  ASSERT_EQ(json["covariance"].size(), 36U);
  EXPECT_EQ(json["covariance"][1], 1.5e-4);
  EXPECT_EQ(json["covariance"][35], 1e-6);
  EXPECT_EQ(json["velocity_mps"], (nlohmann::json{2.0, 0.0, 0.0}));
  EXPECT_EQ(json["turn_rate_radps"], (nlohmann::json{0.0, 0.0, 0.25}));
  EXPECT_EQ(json["sigma_velocity_mps"], (nlohmann::json{0.01, 0.01, 0.0}));
  EXPECT_EQ(json["sigma_turn_rate_radps"], (nlohmann::json{0.0, 0.0, 0.02}));
  const auto twist = nlohmann::json::parse(fix_as_ros(fix, two_vehicles()))["twist"];
  EXPECT_EQ(twist["twist"]["linear"]["x"], 2.0);
  EXPECT_EQ(twist["twist"]["angular"]["z"], 0.25);
  EXPECT_EQ(twist["covariance"][0], 1e-4);
  EXPECT_EQ(twist["covariance"][35], 4e-4);
  // 2 m/s are 3.888 knots, at 0.5 rad from east towards north. The axes of [1 1.5; 1.5 4] cm^2 have variances
  // of 0.3787 and 4.6213 cm^2; the longer one is 67.5 degrees from +x, so 22.5 degrees from north.
  const std::string nmea = fix_as_nmea(fix, {48.14816, 17.10674, 0.0, std::numbers::pi / 2});
  EXPECT_NE(nmea.find("$GPVTG,61.352,T,,M,3.888,N,7.200,K,A*"), std::string::npos) << nmea;
  EXPECT_NE(nmea.find("$GPGST,235959.99,,0.0215,0.0062,22.5,0.0200,0.0100,0.0000*"), std::string::npos)
      << nmea;
}

/// 10 m east and 20 m north of 48.14816 N, 17.10674 E on the tangent plane, via Cartesian coordinates of WGS
/// 84: 48 degrees 8.9003920 minutes, 17 degrees 6.4124633 minutes.
TEST(LiveFixes, NmeaIsOnTheEarth) {
  const std::string text = fix_as_nmea(some_fix(), {48.14816, 17.10674, 0.0, std::numbers::pi / 2});
  EXPECT_EQ(text.substr(0, 47), "$GPGGA,235959.99,4808.9003920,N,01706.4124633,E") << text;
  EXPECT_NE(text.find("$GPGST,235959.99,,0.0200,0.0100,0.0,0.0200,0.0100,0.0000*"), std::string::npos)
      << text;
  EXPECT_NE(text.find("$GPHDT,61.352,T*"), std::string::npos) << text;  // 90 - 0.5 rad
  Fix unknown = some_fix();
  unknown.covariance(2, 2) = kUnknownRotationVariance;
  EXPECT_EQ(fix_as_nmea(unknown, {48.0, 17.0, 0.0, 0.0}).find("HDT"), std::string::npos);
  EXPECT_EQ(fix_as_nmea(Fix{}, {}), "$GPGGA,000000.00,,,,,0,00,,,M,,M,,*48\r\n");
}

}  // namespace live_rows_test
}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/deployment/deployment_json.h"

#include <nlohmann/json.hpp>

#include "io/deployment/deployment_digest.h"
#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace deployment_json_test {

using test::expect_error;
using Json = nlohmann::ordered_json;

Deployment small_deployment() {
  Deployment d;
  d.site = "hall";
  d.created = "2026-01-02T03:04:05Z";
  d.medium = {MediumModel::kCramer1993, 343.0, 21.0, 0.5, 101325.0};
  d.speed_offset_mps = 0.25;
  d.speed_sigma_mps = 0.01;
  d.timing.delay_per.beacon = true;
  d.attenuation = AttenuationModel{12.5, 0.15, 0.2, 4.5e-4};
  d.beacons.push_back({.name = "B0", .position_m = {1, 2, 3}});
  d.beacons.push_back(
      {.name = "B1", .position_m = {4, 5, 6}, .delay_s = 1e-4, .status = BeaconStatus::kUndetermined});
  d.vehicles.push_back({"robot", 0, 1});
  d.receivers.push_back(
      {.name = "r0", .vehicle = VehicleId(0), .position_m = {0.1, 0, 0.3}, .axis = std::nullopt});
  d.covariance = {{parameters::beacon_position(0, 0), parameters::speed()},
                  (Eigen::Matrix2d() << 1, 0.5, 0.5, 2).finished()};
  d.statistics.converged = true;
  d.warnings = {"w"};
  return d;
}

/// The small deployment with one value changed, with or without a digest that fits.
std::string changed(const std::string& pointer, const Json& value, bool with_digest = true) {
  Json json = Json::parse(deployment_to_json(small_deployment()));
  json[Json::json_pointer(pointer)] = value;
  json.erase("digest");
  if (with_digest) json["digest"] = digest_of(nlohmann::json(json));
  return json.dump(1);
}

/// A later program's unknowns: the covariance of the others is the marginal one.
TEST(DeploymentJson, NumbersThatAreNotKnownHereAreLeftOutOfTheCovariance) {
  const std::string later =
      changed("/covariance", {{"parameters", {"beacon/B0/x_m", "clock/robot/scale", "medium/speed_mps"}},
                              {"upper_triangle", {1.0, 7.0, 0.5, 9.0, 8.0, 2.0}}});
  const Result<Deployment> read = deployment_from_json(later, "d.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->covariance.parameters, small_deployment().covariance.parameters);
  EXPECT_EQ(read->covariance.matrix, small_deployment().covariance.matrix);
}

TEST(DeploymentJson, HoldsWhatTheContractAsksFor) {
  const auto json = Json::parse(deployment_to_json(small_deployment()));
  EXPECT_EQ(json.at("type"), "octant_deployment");
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_NEAR(json.at("medium").at("speed_mps").get<double>(), small_deployment().speed_mps(21.0), 1e-12);
  EXPECT_EQ(json.at("medium").at("reference_temperature_degC"), 21.0);
  EXPECT_EQ(json.at("timing").at("delay_per"), "beacon");
  EXPECT_EQ(json.at("beacons").at(1).at("status"), "undetermined");
  EXPECT_EQ(json.at("vehicles").at(0).at("receivers").at(0).at("position_m"), Json::array({0.1, 0.0, 0.3}));
  EXPECT_EQ(json.at("covariance").at("upper_triangle"), Json::array({1.0, 0.5, 2.0}));
  for (const char* key : {"site", "created", "motion", "datum", "noise", "attenuation", "statistics",
                          "validity", "inputs", "program"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  Deployment without = small_deployment();
  without.attenuation.reset();
  EXPECT_TRUE(Json::parse(deployment_to_json(without)).at("attenuation").is_null());
}

TEST(DeploymentJson, ADirectionThatNoReceiverHasIsRefused) {
  for (const double angle_rad : {0.0, -0.4, 3.0}) {
    const auto read = deployment_from_json(changed("/attenuation/half_power_angle_rad", angle_rad), "d.json");
    ASSERT_FALSE(read) << angle_rad;
    EXPECT_THAT(read.error().message(), testing::HasSubstr("/attenuation/half_power_angle_rad is"))
        << angle_rad;
  }
  EXPECT_EQ(deployment_from_json(changed("/attenuation/half_power_angle_rad", 0.4), "d.json")
                ->attenuation->half_power_angle_rad,
            0.4);
  Json old = Json::parse(deployment_to_json(small_deployment()));  // as written before there was one
  old["attenuation"].erase("half_power_angle_rad");
  old["attenuation"].erase("saturation_v");
  old.erase("digest");
  old["digest"] = digest_of(nlohmann::json(old));
  EXPECT_FALSE(deployment_from_json(old.dump(), "d.json")->attenuation->directional());
}

TEST(DeploymentJson, ARailIsWrittenOnlyWhereThereIsOne) {
  Deployment d = small_deployment();
  EXPECT_FALSE(Json::parse(deployment_to_json(d)).at("vehicles").at(0).contains("rail"));
  d.vehicles[0].rail = Rail{.shape = Rail::Shape::kArc, .centre_m = {6, 5}, .radius_m = 4};
  EXPECT_EQ(Json::parse(deployment_to_json(d)).at("vehicles").at(0).at("rail"),
            (Json{{"centre_m", {6.0, 5.0}}, {"radius_m", 4.0}}));
}

TEST(DeploymentJson, LayoutDoesNotMatterButValuesDo) {
  const std::string text = deployment_to_json(small_deployment());
  EXPECT_TRUE(deployment_from_json(nlohmann::json::parse(text).dump(), "d.json")) << "keys sorted, one line";
  std::string altered = text;
  altered.replace(altered.find("0.15"), 4, "0.16");
  const int line = 1 + static_cast<int>(std::count(
                           text.begin(), text.begin() + static_cast<long>(text.find("\"digest\"")), '\n'));
  expect_error(deployment_from_json(altered, "d.json"), line, "altered", "d.json");
}

TEST(DeploymentJson, ADigestIsNotAskedOfOtherPrograms) {
  const auto d = deployment_from_json(changed("/site", "x", false), "d.json");
  ASSERT_TRUE(d) << d.error().message();
  EXPECT_THAT(d->warnings, testing::ElementsAre("w", testing::HasSubstr("no digest")));
}

TEST(DeploymentJson, RefusesTruncatedFilesWherever) {
  const std::string text = deployment_to_json(small_deployment());
  for (std::size_t size = 0; size + 2 < text.size(); size += 97) {
    const auto d = deployment_from_json(text.substr(0, size), "d.json");
    ASSERT_FALSE(d) << size;
    EXPECT_GT(d.error().line, 0);
  }
  expect_error(deployment_from_json("", "d.json"), 1, "empty", "d.json");
  expect_error(deployment_from_json("{\"type\": \"x\",\n \"a\": nan}", "d.json"), 2, "not JSON", "d.json");
  expect_error(deployment_from_json("{\n\"a\": 1e999}", "d.json"), 0, "cannot be read", "d.json");
}

TEST(DeploymentJson, NamesWhatIsWrongByPointerAndLine) {
  struct Bad {
    std::string pointer;
    Json value;
    std::string words;
  };
  const std::vector<Bad> cases = {
      {"/type", "octant_report", "/type is 'octant_report'"},
      {"/version", 2, "/version is 2; expected 1"},
      {"/version", "1", "/version is '1'; expected a finite number"},
      {"/site", 3, "/site is 3; expected text"},
      {"/motion", "flying", "/motion is 'flying'; expected one of planar, spatial"},
      {"/medium/speed_mps", nullptr, "/medium is without 'speed_mps'"},
      {"/medium/speed_mps", 300.0, "/medium/speed_mps is 300; expected"},
      {"/timing/delay_per", Json::array({"beacon", "room"}), "/timing/delay_per/1 is 'room'"},
      {"/noise/tof_sigma_s", 0.0, "a positive number"},
      {"/noise/correlated", Json{{"sigma_s", -1e-9}}, "/noise/correlated/sigma_s"},
      {"/beacons/1/position_m", Json::array({1, 2}), "/beacons/1/position_m is an array of 2"},
      {"/beacons/1/position_m/2", nullptr, "/beacons/1/position_m/2 is null"},
      {"/beacons/1/position_m/2", "6", "/beacons/1/position_m/2 is '6'"},
      {"/beacons/1/id", "B0", "'B0', which is used twice"},
      {"/beacons/0/status", "fine", "/beacons/0/status is 'fine'"},
      {"/beacons/0/covariance_m2/1/1", -1.0, "negative variance"},
      {"/vehicles", Json::array(), "/vehicles is empty"},
      {"/vehicles/0/receivers", Json::object(), "/vehicles/0/receivers is an object"},
      {"/vehicles/0/rail", 3, "/vehicles/0/rail"},
      {"/vehicles/0/rail", Json::object(), "/vehicles/0/rail is without 'from_m'"},
      {"/vehicles/0/rail", Json{{"from_m", {0, 0}}, {"to_m", {0, 0}}},
       "/vehicles/0/rail/to_m is where the rail begins"},
      {"/vehicles/0/rail", Json{{"centre_m", {0, 0}}, {"radius_m", 0}}, "a positive number"},
      {"/vehicles/0/rail", Json{{"from_m", {0}}, {"to_m", {0, 1}}}, "an array of 2"},
      {"/covariance/upper_triangle", Json::array({1, 2}), "expected an array of 3 numbers"},
      {"/statistics/arrivals", -1, "/statistics/arrivals is -1"},
      {"/statistics/converged", 1, "true or false"},
      {"/validity/temperature_degC", 20, "an array of 2"},
      {"/inputs", "none", "/inputs is 'none'"},
  };
  for (const Bad& bad : cases) {
    SCOPED_TRACE(bad.pointer);
    const auto d = deployment_from_json(changed(bad.pointer, bad.value), "d.json");
    ASSERT_FALSE(d);
    EXPECT_THAT(d.error().message(), testing::HasSubstr(bad.words));
    EXPECT_GT(d.error().line, 0) << d.error().message();
  }
}

TEST(DeploymentJson, TheLineIsThatOfTheValue) {
  const std::string text = changed("/beacons/1/status", "fine");
  const int line = 1 + static_cast<int>(std::count(
                           text.begin(), text.begin() + static_cast<long>(text.find("\"fine\"")), '\n'));
  expect_error(deployment_from_json(text, "d.json"), line, "'fine'", "d.json");
}

TEST(DeploymentJson, NothingIsWrittenThatCannotBeRead) {
  const test::TemporaryFolder folder;
  Deployment d = small_deployment();
  d.covariance.matrix(0, 1) = std::nan("");
  expect_error(write_deployment(folder.path("d.json"), d), 0,
               "/covariance/upper_triangle/1 is not a finite number", "d.json");
  Deployment refused = small_deployment();
  refused.beacons[0].delay_sigma_s = -1e-6;
  expect_error(write_deployment(folder.path("d.json"), refused), 0, "it cannot be read back", "d.json");
  EXPECT_EQ(folder.files(), 0u);
  ASSERT_TRUE(write_deployment(folder.path("d.json"), small_deployment()));
  EXPECT_TRUE(read_deployment(folder.path("d.json")));
  expect_error(read_deployment(folder.path("e.json")), 0, "No such file", "e.json");
}

Eigen::Vector3d some_vector() { return {test::some_number(), test::some_number(), test::some_number()}; }

Deployment some_deployment() {
  Deployment d = small_deployment();
  d.site = test::some_name(0);
  d.motion = *rc::gen::element(Motion::kPlanar, Motion::kSpatial);
  d.datum = {"words", "control points", "x", "y", {"B0"}};
  d.medium = {
      *rc::gen::element(MediumModel::kConstant, MediumModel::kLinearTemperature, MediumModel::kCramer1993),
      300 + test::some_positive(), 30 * test::some_fraction(), test::some_fraction(), 1e5};
  d.speed_offset_mps = test::some_fraction();
  d.speed_sigma_mps = test::some_positive();
  d.timing = {*rc::gen::element(Clock::kSynchronised, Clock::kCycleOffset),
              *rc::gen::element(Ranging::kOneWay, Ranging::kTwoWay),
              test::some_positive(),
              {*rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>()},
              test::some_number(),
              test::some_positive()};
  d.noise = {test::some_positive(), test::some_positive(), test::maybe(test::some_positive()),
             test::some_positive(), test::some_positive()};
  if (*rc::gen::arbitrary<bool>())
    d.correlated_noise = {test::some_positive(), test::some_positive(), test::some_positive()};
  if (*rc::gen::arbitrary<bool>()) d.attenuation->half_power_angle_rad = 0.1 + 2 * test::some_fraction();
  if (*rc::gen::arbitrary<bool>()) d.attenuation->saturation_v = test::some_positive();
  if (*rc::gen::arbitrary<bool>()) d.attenuation.reset();
  for (DeploymentBeacon& b : d.beacons) {
    b.position_m = some_vector();
    const Eigen::Vector3d v = some_vector();
    b.covariance_m2 = v * v.transpose();
    b.delay_s = test::some_number();
    b.delay_sigma_s = test::some_positive();
    b.status = *rc::gen::element(BeaconStatus::kCalibrated, BeaconStatus::kControlPoint,
                                 BeaconStatus::kUndetermined);
  }
  d.receivers[0].sigma_m = some_vector();
  d.receivers[0].delay_s = test::some_number();
  if (*rc::gen::arbitrary<bool>()) d.receivers[0].axis = some_vector();
  d.vehicles[0].rail = test::some_rail();
  if (*rc::gen::arbitrary<bool>()) d.receivers[0].hearing_cosine = 0.25;
  const Eigen::Vector2d c(test::some_number(), test::some_number());
  d.covariance.matrix = c * c.transpose();
  d.statistics = {*rc::gen::inRange<std::size_t>(0, 1u << 30),
                  2,
                  3,
                  test::some_number(),
                  test::some_number(),
                  test::some_fraction(),
                  test::some_positive(),
                  *rc::gen::arbitrary<bool>()};
  d.tolerance = {test::maybe(test::some_positive()), test::maybe(test::some_positive())};
  if (*rc::gen::arbitrary<bool>()) d.validity_temperature_degC = {test::some_number(), test::some_number()};
  if (*rc::gen::arbitrary<bool>()) d.validity_reach_m = 1 + std::abs(test::some_number());
  if (*rc::gen::arbitrary<bool>()) d.validity_heights_m = {test::some_number(), test::some_number()};
  if (*rc::gen::arbitrary<bool>()) d.validity_area_m = {{0, 1}, {test::some_number(), 2}};
  d.validity_period = {test::maybe(test::some_positive()), test::maybe(test::some_positive())};
  d.drift = {test::maybe(test::some_positive()), test::maybe(test::some_positive()),
             test::maybe(test::some_positive()), test::maybe(test::some_positive())};
  d.inputs = {{test::some_name(3), std::string(64, 'a')}};
  d.program_version = "0.1.0";
  d.program_command = "octant calibrate 'a b'";
  return d;
}

void assert_same_validity(const Deployment& a, const Deployment& b) {
  RC_ASSERT(a.validity_temperature_degC == b.validity_temperature_degC &&
            a.validity_area_m == b.validity_area_m && a.validity_heights_m == b.validity_heights_m);
  RC_ASSERT(a.validity_reach_m == b.validity_reach_m && a.validity_period == b.validity_period &&
            a.drift == b.drift);
}

void assert_same(const Deployment& a, const Deployment& b) {
  RC_ASSERT(a.site == b.site && a.created == b.created && a.motion == b.motion);
  RC_ASSERT(a.datum.description == b.datum.description && a.datum.position == b.datum.position &&
            a.datum.scale == b.datum.scale);
  RC_ASSERT(a.datum.orientation == b.datum.orientation && a.datum.control_points == b.datum.control_points);
  RC_ASSERT(a.medium.model == b.medium.model && a.medium.speed_mps == b.medium.speed_mps &&
            a.medium.pressure_pa == b.medium.pressure_pa);
  RC_ASSERT(a.medium.temperature_degC == b.medium.temperature_degC &&
            a.medium.relative_humidity == b.medium.relative_humidity);
  RC_ASSERT(a.speed_offset_mps == b.speed_offset_mps && a.speed_sigma_mps == b.speed_sigma_mps);
  RC_ASSERT(a.timing.clock == b.timing.clock && a.timing.ranging == b.timing.ranging &&
            a.timing.turnaround_s == b.timing.turnaround_s);
  RC_ASSERT(a.timing.delay_per.beacon == b.timing.delay_per.beacon &&
            a.timing.delay_per.receiver == b.timing.delay_per.receiver);
  RC_ASSERT(a.timing.delay_per.site == b.timing.delay_per.site && a.timing.delay_s == b.timing.delay_s);
  RC_ASSERT(a.timing.delay_sigma_s == b.timing.delay_sigma_s && a.noise.tof_sigma_s == b.noise.tof_sigma_s);
  RC_ASSERT(a.noise.amplitude_relative_sigma == b.noise.amplitude_relative_sigma &&
            a.noise.pair_sigma_s == b.noise.pair_sigma_s);
  RC_ASSERT(a.noise.bearing_sigma_rad == b.noise.bearing_sigma_rad &&
            a.noise.range_sigma_m == b.noise.range_sigma_m);
  RC_ASSERT(a.correlated_noise.sigma_s == b.correlated_noise.sigma_s &&
            a.correlated_noise.time_s == b.correlated_noise.time_s);
  RC_ASSERT(a.correlated_noise.pair_sigma_s == b.correlated_noise.pair_sigma_s);
  RC_ASSERT(a.attenuation.has_value() == b.attenuation.has_value());
  if (a.attenuation) {
    RC_ASSERT(a.attenuation->amplitude_1m_v == b.attenuation->amplitude_1m_v &&
              a.attenuation->threshold_v == b.attenuation->threshold_v);
    RC_ASSERT(a.attenuation->absorption_np_per_m == b.attenuation->absorption_np_per_m);
    RC_ASSERT(a.attenuation->rise_time_s == b.attenuation->rise_time_s);
    RC_ASSERT(a.attenuation->half_power_angle_rad == b.attenuation->half_power_angle_rad);
    RC_ASSERT(a.attenuation->saturation_v == b.attenuation->saturation_v);
  }
  RC_ASSERT(a.beacons.size() == b.beacons.size() && a.vehicles.size() == b.vehicles.size() &&
            a.receivers.size() == b.receivers.size());
  for (std::size_t i = 0; i < a.beacons.size(); ++i) {
    const DeploymentBeacon &x = a.beacons[i], &y = b.beacons[i];
    RC_ASSERT(x.name == y.name && x.position_m == y.position_m && x.covariance_m2 == y.covariance_m2);
    RC_ASSERT(x.delay_s == y.delay_s && x.delay_sigma_s == y.delay_sigma_s && x.status == y.status);
  }
  RC_ASSERT(test::same_rail(a.vehicles[0].rail, b.vehicles[0].rail));
  const DeploymentReceiver &x = a.receivers[0], &y = b.receivers[0];
  RC_ASSERT(x.name == y.name && x.vehicle == y.vehicle && x.position_m == y.position_m &&
            x.sigma_m == y.sigma_m);
  RC_ASSERT(x.delay_s == y.delay_s && x.delay_sigma_s == y.delay_sigma_s && x.axis == y.axis &&
            x.hearing_cosine == y.hearing_cosine);
  RC_ASSERT(a.covariance.parameters == b.covariance.parameters && a.covariance.matrix == b.covariance.matrix);
  RC_ASSERT(a.statistics.arrivals == b.statistics.arrivals &&
            a.statistics.redundancy == b.statistics.redundancy);
  RC_ASSERT(a.statistics.rejected == b.statistics.rejected && a.statistics.unknowns == b.statistics.unknowns);
  RC_ASSERT(a.statistics.variance_factor == b.statistics.variance_factor &&
            a.statistics.chi2_p == b.statistics.chi2_p);
  RC_ASSERT(a.statistics.rms_s == b.statistics.rms_s && a.statistics.converged == b.statistics.converged);
  RC_ASSERT(a.tolerance.beacon_m == b.tolerance.beacon_m && a.tolerance.fix_m == b.tolerance.fix_m);
  assert_same_validity(a, b);
  RC_ASSERT(a.inputs.size() == b.inputs.size() && a.inputs[0].path == b.inputs[0].path &&
            a.inputs[0].sha256 == b.inputs[0].sha256);
  RC_ASSERT(a.program_version == b.program_version && a.program_command == b.program_command &&
            a.warnings == b.warnings);
}

TEST(DeploymentJson, AMarkStays) {
  Deployment d = small_deployment();
  EXPECT_FALSE(Json::parse(deployment_to_json(d)).contains("verdict"));
  d.contradictions = {{ContradictionKind::kControlPoint, "B3", "here", "there", 12.5, "survey it again"}};
  const std::string text = deployment_to_json(d);
  EXPECT_EQ(Json::parse(text).at("verdict").at("grade"), "Contradicted");
  const auto back = deployment_from_json(text, "d.json");
  ASSERT_TRUE(back.has_value());
  ASSERT_EQ(back->contradictions.size(), 1U);
  const Contradiction &a = d.contradictions[0], &b = back->contradictions[0];
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(std::tie(a.subject, a.stated, a.found, a.sigmas, a.remedy),
            std::tie(b.subject, b.stated, b.found, b.sigmas, b.remedy));
}

TEST(DeploymentJson, ReadsBackWhatItWrote) {
  EXPECT_TRUE(rc::check("read(write(x)) == x", [] {
    const Deployment d = some_deployment();
    const auto back = deployment_from_json(deployment_to_json(d), "d.json");
    if (!back) RC_FAIL(back.error().message());
    assert_same(d, *back);
  }));
}

}  // namespace deployment_json_test
}  // namespace octant::io

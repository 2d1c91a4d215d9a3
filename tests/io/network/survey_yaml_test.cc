// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// survey.yaml: observations of all kinds with their units, and errors with their lines.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/network/network_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace survey_yaml_test {

using test::expect_error;

Result<NetworkFile> read(const std::string& content) {
  const test::TemporaryFolder box;
  return read_survey(box.write("survey.yaml",
                               "octant_survey: 1\npoints:\n"
                               "  - {id: P, position_m: [0, 0, 1], fixed: xyz}\n"
                               "  - {id: B, datum: xy}\n"
                               "  - {id: H, position_m: [null, null, 4]}\n" +
                                   content));
}

TEST(SurveyYaml, ReadsEveryKind) {
  const auto file = read(
      "angles: clockwise\naxes: ne\nsigmas: scaled\n"
      "stations:\n  - at: P\n    instrument_height_m: 1.5\n"
      "    sigmas: {direction_gon: 0.001, zenith_deg: 0.002, distance_m: 0.002, distance_m_per_m: 1e-5}\n"
      "    sights:\n"
      "      - {to: B, direction_gon: 50, zenith_gon: 310, slope_m: 100, target_height_m: 0.2}\n"
      "      - {to: H, direction_rad: 1.5, direction_sigma_rad: 1e-4, horizontal_m: 20, sigma_m: 0.01}\n"
      "horizontal_angles: [{at: P, from: B, to: H, angle_deg: 90, sigma_deg: 0.01}]\n"
      "azimuths: [{from: P, to: B, azimuth_gon: 100, sigma_gon: 0.01}]\n"
      "distances: [{from: B, to: H, slope_m: 3, sigma_m: 0.003}]\n"
      "height_differences: [{from: P, to: H, difference_m: 3, length_km: 4, sigma_m_per_sqrt_km: 0.001}]\n"
      "coordinates: [{point: B, position_m: [1, 2, null], covariance_m2: [4e-4, 1e-4, 9e-4]}]\n"
      "vectors: [{from: P, to: H, vector_m: [1, 2, 3], sigma_m: [0.01, 0.01, 0.02]}]\n");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_TRUE(file->warnings.empty());
  const std::vector<SurveyObservation>& o = file->network.observations;
  ASSERT_EQ(o.size(), 14U);
  constexpr double kGon = std::numbers::pi / 200.0;
  EXPECT_NEAR(o[0].value, 50 * kGon, 1e-14);
  EXPECT_NEAR(o[0].sigma, 0.001 * kGon, 1e-17);
  EXPECT_EQ(o[0].set, 0);
  EXPECT_NEAR(o[1].value, 90 * kGon, 1e-14);  // second face
  EXPECT_EQ(o[1].instrument_height_m, 1.5);
  EXPECT_NEAR(o[2].sigma, 0.003, 1e-15);
  EXPECT_EQ(o[3].sigma, 1e-4);
  EXPECT_EQ(o[4].kind, SurveyKind::kHorizontalDistance);
  EXPECT_NEAR(o[5].value, std::numbers::pi / 2, 1e-14);
  EXPECT_NEAR(o[6].value, std::numbers::pi / 2, 1e-14);
  EXPECT_NEAR(o[8].sigma, 0.002, 1e-15);
  EXPECT_NEAR(o[10].sigma, 0.03, 1e-15);
  EXPECT_EQ(o[13].sigma, 0.02);
  EXPECT_EQ(o[13].line, 21);
  ASSERT_EQ(file->network.covariances.size(), 1U);
  EXPECT_EQ(file->network.covariances[0].covariance(1, 0), 1e-4);
  EXPECT_EQ(file->network.points[1].p_map_m.x(), 1.0);
  EXPECT_TRUE(file->sigmas_a_posteriori);
}

TEST(SurveyYaml, LeavesOutCoordinatesWithoutObservations) {
  const auto file = read("distances: [{from: P, to: B, horizontal_m: 3, sigma_m: 0.003}]\n");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->network.points[1].role,
            (std::array{CoordinateRole::kDatum, CoordinateRole::kDatum, CoordinateRole::kAbsent}));
  EXPECT_EQ(file->network.points[2].role[2], CoordinateRole::kAbsent);
}

TEST(SurveyYaml, NamesTheLineOfAnError) {
  expect_error(read("distances:\n  - {from: P, to: X, slope_m: 3, sigma_m: 0.003}\n"), 7, "'X'");
  expect_error(read("distances:\n  - {from: P, to: B, slope_m: 3}\n"), 7, "sigma_m");
  expect_error(read("distances:\n  - {from: P, to: B, sigma_m: 0.1}\n"), 7, "slope_m");
  expect_error(read("coordinates:\n  - {point: B, position_m: [1, 2], sigma_m: 0.1}\n"), 7, "position_m");
  expect_error(read("coordinates:\n  - {point: B, position_m: [1, 2, null], covariance_m2: [1, 2, 1]}\n"), 7,
               "not positive definite");
}

TEST(SurveyYaml, AdjustsWhatIsStated) {
  const test::TemporaryFolder box;
  const auto file = read_survey(box.write("s.yaml",
                                          "octant_survey: 1\npoints:\n"
                                          "  - {id: A, position_m: [0, 0, 0], fixed: xy, adjusted: \"\"}\n"
                                          "  - {id: B, adjusted: \"y\", datum: z}\n"
                                          "distances: [{from: A, to: B, slope_m: 3, sigma_m: 0.003}]\n"));
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->network.points[0].role[2], CoordinateRole::kAbsent);
  EXPECT_EQ(file->network.points[1].role,
            (std::array{CoordinateRole::kAbsent, CoordinateRole::kFree, CoordinateRole::kDatum}));
}

TEST(SurveyYaml, GathersCorrelatedObservations) {
  const auto file = read(
      "distances:\n  - {from: P, to: B, slope_m: 3, sigma_m: 0.1}\n"
      "  - {id: d, from: P, to: H, slope_m: 4, sigma_m: 0.2}\n"
      "vectors:\n  - {id: v, from: P, to: B, vector_m: [1, null, 3], sigma_m: 0.5}\n"
      "correlations: [{observations: [v, d], correlation: [0.5, 0.1, 0]}]\n");
  ASSERT_TRUE(file) << file.error().message();
  const std::vector<SurveyObservation>& o = file->network.observations;
  ASSERT_EQ(o.size(), 4U);
  EXPECT_EQ(o[0].value, 3);
  EXPECT_EQ(o[2].kind, SurveyKind::kDz);
  EXPECT_EQ(o[3].value, 4);
  ASSERT_EQ(file->network.covariances.size(), 1U);
  EXPECT_EQ(file->network.covariances[0].first, 1);
  EXPECT_NEAR(file->network.covariances[0].covariance(0, 1), 0.125, 1e-15);
  EXPECT_NEAR(file->network.covariances[0].covariance(2, 0), 0.01, 1e-15);
  EXPECT_NEAR(file->network.covariances[0].covariance(2, 2), 0.04, 1e-15);
  const std::string two =
      "distances:\n  - {id: d, from: P, to: B, slope_m: 3, sigma_m: 0.1}\n"
      "  - {id: e, from: P, to: H, slope_m: 3, sigma_m: 0.1}\ncorrelations:\n";
  expect_error(read(two + "  - {observations: [d, f], correlation: [0.5]}\n"), 10, "'f'");
  expect_error(read(two + "  - {observations: [d, d], correlation: [0.5]}\n"), 10, "already");
  expect_error(read(two + "  - {observations: [d, e], correlation: [1.5]}\n"), 10, "not positive definite");
  expect_error(read(two + "  - {observations: [d, e], correlation: [0.5, 1]}\n"), 10, "correlation");
}

/// Every kind of observation, set of directions and covariance, with awkward names.
TEST(SurveyYaml, ReadsWhatTheWriterWrites) {
  const test::TemporaryFolder box;
  const auto gama = read_gama(box.write(
      "n.gkf",
      "<gama-local><network axes-xy='sw' angles='right-handed'><description>a: 'b'\n#</description>"
      "<parameters sigma-act='apriori' tol-abs='50' update-constrained-coordinates='yes'/>"
      "<points-observations distance-stdev='5'><point id='no' x='0' y='0' z='0' fix='xyz'/>"
      "<point id='1e5' x='10' y='1' fix='x' adj='Y'/><point id='y' adj='yz'/><point id='unused'/>"
      "<obs from='no'><direction to='1e5' val='10' stdev='1'/><direction to='y' val='-10' stdev='2'/>"
      "<s-distance to='y' val='7' from_dh='1.5' to_dh='0.2'/><z-angle to='y' val='300' stdev='3'/>"
      "<angle bs='1e5' fs='y' val='3' stdev='1'/><azimuth to='y' val='1-2-3' stdev='1'/>"
      "<distance to='y' val='6'/></obs><obs from='no'><direction to='y' val='1' stdev='1'/>"
      "<direction to='1e5' val='2' stdev='1'/><cov-mat dim='2' band='1'>4 1 9</cov-mat></obs>"
      "<height-differences><dh from='no' to='y' val='1' dist='4'/></height-differences>"
      "<coordinates><point id='1e5' x='10' y='1'/><point id='y' z='3'/>"
      "<cov-mat dim='3' band='2'>4 1 1 9 0 16</cov-mat></coordinates>"
      "<vectors><vec from='no' to='y' dx='1' dy='2' dz='3'/><vec from='no' to='y' dx='1.1' dy='2.1' dz='4'/>"
      "<cov-mat dim='6' band='1'>4 1 9 0 4 0 4 1 9 0 4</cov-mat></vectors>"
      "</points-observations></network></gama-local>"));
  ASSERT_TRUE(gama) << gama.error().message();
  const std::string yaml = survey_to_yaml(*gama);
  const auto file = read_network(box.write("s.yaml", yaml));
  ASSERT_TRUE(file) << file.error().message() << yaml;
  EXPECT_TRUE(file->warnings.empty());
  EXPECT_EQ(file->description, gama->description);
  EXPECT_EQ(file->axes, "sw");
  EXPECT_EQ(file->angle_sign, gama->angle_sign);
  EXPECT_EQ(file->north_rad, gama->north_rad);
  EXPECT_EQ(file->sigmas_a_posteriori, gama->sigmas_a_posteriori);
  EXPECT_EQ(file->outlier_limit_m, gama->outlier_limit_m);
  EXPECT_TRUE(file->datum_follows);
  const Network &a = file->network, &b = gama->network;
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < b.points.size(); ++i) {
    EXPECT_EQ(a.points[i].id, b.points[i].id);
    EXPECT_EQ(a.points[i].p_map_m, b.points[i].p_map_m);
    EXPECT_EQ(a.points[i].role, b.points[i].role) << yaml;
    EXPECT_EQ(a.points[i].known, b.points[i].known);
  }
  EXPECT_EQ(a.sets, b.sets);
  ASSERT_EQ(a.observations.size(), b.observations.size()) << yaml;
  for (const SurveyObservation& o : b.observations)
    EXPECT_EQ(std::ranges::count_if(a.observations,
                                    [&](const SurveyObservation& p) {
                                      return p.kind == o.kind && p.from == o.from && p.to == o.to &&
                                             p.second == o.second && p.set == o.set &&
                                             p.instrument_height_m == o.instrument_height_m &&
                                             p.target_height_m == o.target_height_m &&
                                             std::abs(p.value - o.value) < 1e-14 &&
                                             std::abs(p.sigma - o.sigma) < 1e-14;
                                    }),
              1)
        << o.line << "\n"
        << yaml;
  ASSERT_EQ(a.covariances.size(), b.covariances.size());
  for (std::size_t i = 0; i < b.covariances.size(); ++i)
    EXPECT_TRUE(a.covariances[i].covariance.isApprox(b.covariances[i].covariance, 1e-14));
}

}  // namespace survey_yaml_test
}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Reader of gama-local documents: elements and attributes that networks of GNU Gama use.
#include <numbers>

#include "io/network/network_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace gama_reader_test {

using test::expect_error;
using testing::HasSubstr;

class GamaReader : public ::testing::Test {
 protected:
  Result<NetworkFile> read(const std::string& content, const std::string& before = "") {
    return read_gama(box.write("n.gkf", before + "<gama-local><network axes-xy='en' angles='right-handed'>" +
                                            content + "</network></gama-local>\n"));
  }
  Result<NetworkFile> read_observations(const std::string& content) {
    return read("<points-observations direction-stdev='5' distance-stdev='3 2 2'>" + kPoints + content +
                "</points-observations>");
  }
  test::TemporaryFolder box;
  const std::string kPoints =
      "<point id='A' x='0' y='0' z='1' fix='xyz'/><point id='B' x='1000' y='0' fix='XY' adj='Z'/>";
};

TEST_F(GamaReader, ReadsSectionsInAnyOrder) {
  const auto file =
      read("<points-observations>" + kPoints +
           "</points-observations><description> one </description><parameters sigma-apr=' 2 ' tol-abs='50'/>"
           "<points-observations distance-stdev='4'><obs from='A'><distance to='B' val='1000'/></obs>"
           "</points-observations><parameters sigma-act='apriori' update-constrained-coordinates='yes'/>");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->description, "one");
  EXPECT_EQ(file->sigma_unit, 2.0);
  EXPECT_EQ(file->outlier_limit_m, 0.05);
  EXPECT_FALSE(file->sigmas_a_posteriori);
  EXPECT_TRUE(file->datum_follows);
  ASSERT_EQ(file->network.observations.size(), 1U);
  EXPECT_NEAR(file->network.observations[0].sigma, 0.004, 1e-15);
  EXPECT_EQ(file->network.points[1].role,
            (std::array{CoordinateRole::kFixed, CoordinateRole::kFixed, CoordinateRole::kDatum}));
}

TEST_F(GamaReader, ReadsObservationsWithTheirDefaults) {
  const auto file = read_observations(
      "<obs from='A' orientation='12' from_dh='1.5'><direction to='B' val='100' extern='7'/>"
      "<direction to='B' val='-0-00-10' stdev='2'/><z-angle to='B' val='290' stdev='20' to_dh='0.5'/>"
      "<distance to='B' val='2000'/><angle bs='A' fs='B' from='B' val='90-0-0' stdev='1'/>"
      "<angle to='A' rs='B' from='B' val='50' stdev='1'/></obs>");
  ASSERT_TRUE(file) << file.error().message();
  const std::vector<SurveyObservation>& o = file->network.observations;
  constexpr double kGon = std::numbers::pi / 200.0, kSecond = std::numbers::pi / 648000.0;
  EXPECT_NEAR(o[0].value, 100 * kGon, 1e-14);
  EXPECT_NEAR(o[0].sigma, 5e-4 * kGon, 1e-18);
  EXPECT_NEAR(o[1].value, -10 * kSecond, 1e-16);
  EXPECT_NEAR(o[1].sigma, 2 * kSecond, 1e-18);
  EXPECT_NEAR(o[2].value, 110 * kGon, 1e-14);  // second face
  EXPECT_EQ(o[2].instrument_height_m, 1.5);
  EXPECT_EQ(o[2].target_height_m, 0.5);
  EXPECT_NEAR(o[3].sigma, 0.003 + 0.002 * 4, 1e-15);  // 3 mm + 2 mm D^2
  EXPECT_NEAR(o[4].value, std::numbers::pi / 2, 1e-14);
  EXPECT_EQ(std::pair(o[5].to, o[5].second), std::pair(0, 1));
}

TEST_F(GamaReader, ReadsPointsOfObservedCoordinatesAndSplitsTheirCovariance) {
  const auto file = read_observations(
      "<coordinates><point id='C' x='1' y='2' z='3' adj='xyz'/><point id='D' z='4' adj='z'/>"
      "<cov-mat dim='4' band='1'>1 0.5 4 0 9 0.1 16</cov-mat></coordinates>");
  ASSERT_TRUE(file) << file.error().message();
  const Network& n = file->network;
  EXPECT_EQ(n.points[2].p_map_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(n.points[2].role[0], CoordinateRole::kFree);
  EXPECT_EQ(n.points[3].role,
            (std::array{CoordinateRole::kAbsent, CoordinateRole::kAbsent, CoordinateRole::kFree}));
  ASSERT_EQ(n.covariances.size(), 2U);
  EXPECT_EQ(n.covariances[1].first, 2);
  EXPECT_NEAR(n.covariances[0].covariance(1, 0), 0.5e-6, 1e-18);
  EXPECT_NEAR(n.covariances[1].covariance(0, 1), 0.1e-6, 1e-18);
  EXPECT_NEAR(n.observations[3].sigma, 0.004, 1e-15);
}

TEST_F(GamaReader, OpensNoDocumentTypeAndReadsOldEncodings) {
  const std::string content = "<points-observations>" + kPoints + "</points-observations>";
  EXPECT_TRUE(read(content, "<!DOCTYPE gama-local SYSTEM \"gama-local.dtd\">\n"));
  EXPECT_FALSE(read(content, "<!DOCTYPE gama-local SYSTEM \"/etc/passwd\">\n"));
  EXPECT_FALSE(read(content, "<!DOCTYPE gama-local SYSTEM \"gama-local.dtd\" [<!ENTITY a 'b'>]>\n"));
  const std::string name =
      "<description>Sn\xec\x9e"
      "ka</description>";
  EXPECT_TRUE(read(name + content, "<?xml version=\"1.0\" encoding=\"iso-8859-2\"?>"));
  EXPECT_FALSE(read(name + content, "<?xml version=\"1.0\" encoding=\"utf-8\"?>"));
}

TEST_F(GamaReader, NamesTheLineOfAnError) {
  expect_error(read_observations("\n<obs from='A'>\n<distance to='B' val='x' stdev='1'/></obs>"), 3, "'x'");
  expect_error(read_observations("\n<obs from='A'><slope to='B' val='1'/></obs>"), 2, "<slope>");
  expect_error(read_observations("\n<point id='A' x='0.5'/>"), 2, "another x of point 'A'");
  expect_error(read_observations("\n<point id='B' adj='x'/>"), 2, "another x of point 'B'");
  expect_error(read_observations("\n<vectors><vec from='A' to='B' dx='1' dy='1' dz='1'/></vectors>"), 2,
               "without standard deviation");
}

}  // namespace gama_reader_test
}  // namespace octant::io

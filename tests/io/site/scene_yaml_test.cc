// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/scene_yaml.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "io/import/plan_import.h"
#include "io/site/site_yaml.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace scene_yaml_test {

using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr const char* kSite = R"(octant_site: 1
motion: planar
medium: {model: constant, speed_mps: 343, sigma_mps: 0}
timing: {clock: synchronised, delay_per: none}
beacons: [{id: A, position_m: [0, 0, 2], sigma_m: 0}]
vehicles: [{receivers: [{id: r0, position_m: [0, 0, 0]}]}]
)";

constexpr const char* kBlock = R"(scene:
  floor_m: [[0, 0], [10, 0], [10, 8], [0, 8]]
  walls: [{id: w, points_m: [[2, 0], [2, 3], [4, 3]], bottom_m: 0.5, top_m: 2.5}]
  obstacles: [{id: o, points_m: [[5, 5], [6, 5], [6, 6]], blocks_sound: false}]
  mounts:
    - {id: north, kind: wall, points_m: [[0, 8], [10, 8]], height_m: [2, 3]}
    - {id: mast, kind: pole, points_m: [[5, 1]], height_m: [1, 4], axis: [0, 0, -2]}
  patterns:
    - {id: cone, kind: cone, half_angle_rad: 0.9}
    - {id: power, kind: cosine_power, exponent: 2}
    - {id: table, kind: table, angle_rad: [0, 1], gain: [1, 0.5]}
    - {id: piezo, kind: half_power, half_power_angle_rad: 0.4}
  beacon_pattern: power
  receiver_pattern: table
  beacons: [{id: A, axis: [0, 0, -3], pattern: cone}]
  routes: [{id: way, points_m: [[1, 1], [9, 1]]}]
  acoustics: {frequency_hz: 40000, amplitude_1m_v: 10, threshold_v: 0.1, range_m: 20}
  noise: {sigma_m_per_m: 0.001, sigma_m_per_sqrt_m: 0.002}
  cell_m: 0.5
  headings: 4
  temperature_error_degC: -3
  coverage: 4
)";

Result<std::optional<Scene>> read(const std::string& text) {
  const TemporaryFolder folder;
  return read_site_scene(folder.write("site.yaml", text));
}

TEST(SceneYaml, EveryKey) {
  const auto read_scene = read(std::string(kSite) + kBlock);
  ASSERT_TRUE(read_scene) << read_scene.error().message();
  ASSERT_TRUE(*read_scene);
  const Scene& s = **read_scene;
  EXPECT_EQ(s.floor_m.size(), 4u);
  EXPECT_EQ(s.floor_line, 8);
  ASSERT_EQ(s.walls.size(), 2u);
  EXPECT_EQ(s.walls[0].name, "w");
  EXPECT_FALSE(s.walls[0].solid);
  EXPECT_EQ(s.walls[0].points_m[2], Eigen::Vector2d(4, 3));
  EXPECT_EQ(s.walls[0].bottom_m, 0.5);
  EXPECT_EQ(s.walls[0].top_m, 2.5);
  EXPECT_TRUE(s.walls[1].solid);
  EXPECT_FALSE(s.walls[1].blocks_sound);
  EXPECT_TRUE(std::isinf(s.walls[1].top_m));
  ASSERT_EQ(s.mounts.size(), 2u);
  EXPECT_EQ(s.mounts[1].kind, SceneMount::Kind::kPole);
  EXPECT_EQ(*s.mounts[1].axis, Eigen::Vector3d(0, 0, -1));
  ASSERT_EQ(s.patterns.size(), 4u);
  EXPECT_EQ(s.patterns[1].exponent, 2.0);
  EXPECT_EQ(s.patterns[3].kind, BeamPattern::Kind::kHalfPower);
  EXPECT_EQ(s.patterns[3].half_power_angle_rad, 0.4);
  EXPECT_NEAR(beam_gain(s.patterns[3], std::cos(0.4)), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(*s.beacon_pattern, 1u);
  EXPECT_EQ(*s.receiver_pattern, 2u);
  EXPECT_EQ(*s.beacons[0].pattern, 0u);
  EXPECT_EQ(s.routes[0].points_m[1], Eigen::Vector2d(9, 1));
  EXPECT_EQ(*s.acoustics.frequency_hz, 40000.0);
  EXPECT_EQ(*s.acoustics.range_m, 20.0);
  EXPECT_EQ(s.noise.sigma_m_per_sqrt_m, 0.002);
  EXPECT_EQ(s.cell_m, 0.5);
  EXPECT_EQ(s.headings, 4);
  EXPECT_EQ(s.temperature_error_degC, -3.0);
  EXPECT_EQ(s.coverage, 4);
  EXPECT_TRUE(s.warnings.empty());
}

TEST(SceneYaml, TheSiteReaderLeavesTheBlockAlone) {
  const TemporaryFolder folder;
  const auto site = read_site(folder.write("site.yaml", std::string(kSite) + kBlock));
  ASSERT_TRUE(site);
  EXPECT_TRUE(site->warnings.empty()) << site->warnings[0];
  const auto none = read_site_scene(folder.write("bare.yaml", kSite));
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
}

TEST(SceneYaml, AFileOfItsOwn) {
  const TemporaryFolder folder;
  const auto scene = read_scene(folder.write("scene.yaml", "octant_scene: 1\ncell_m: 0.5\nfloor: 3\n"));
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->cell_m, 0.5);
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_THAT(scene->warnings[0], HasSubstr("floor"));
  const auto other = read_scene(folder.write("other.yaml", "octant_scene: 2\n"));
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().line, 1);
}

TEST(SceneYaml, ErrorsNameElementAndLine) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"scene:\n  cell_m: 0\n", "scene.cell_m"},
      {"scene:\n  cell_m: -1\n", "scene.cell_m"},
      {"scene:\n  floor_m: [[0, 0], [1]]\n", "scene.floor_m[1]"},
      {"scene:\n  walls: [{id: w}]\n", "scene.walls[0].points_m"},
      {"scene:\n  mounts: [{kind: roof, points_m: [[0, 0]], height_m: [1, 2]}]\n", "roof"},
      {"scene:\n  patterns: [{id: p, kind: cone}]\n", "scene.patterns[0].half_angle_rad"},
      {"scene:\n  patterns: [{id: p, kind: half_power, half_power_angle_rad: 22.5}]\n",
       "from 0.02 to 2.8 rad"},
      {"scene:\n  beacon_pattern: none\n", "there is no pattern 'none'"},
      {"scene:\n  beacons: [{id: A, axis: [0, 0, 0]}]\n", "scene.beacons[0].axis"},
      {"scene:\n  headings: 0\n", "scene.headings"},
      {"scene:\n  acoustics: {frequency_hz: -1}\n", "scene.acoustics.frequency_hz"},
      {"scene:\n  import: [{unit_m: 1}]\n", "scene.import[0]"},
      {"scene:\n  import: [{dxf: nowhere.dxf}]\n", "nowhere.dxf"}};
  for (const auto& [block, expected] : wrong) {
    const auto scene = read(kSite + block);
    ASSERT_FALSE(scene) << block;
    EXPECT_EQ(scene.error().code, Errc::kBadInput);
    EXPECT_THAT(scene.error().message(), HasSubstr(expected)) << block;
  }
}

constexpr const char* kDxf =
    "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n"
    "0\nSECTION\n2\nBLOCKS\n0\nLINE\n8\nWALLS\n10\n7\n20\n7\n11\n8\n21\n8\n0\nENDSEC\n"
    "0\nSECTION\n2\nENTITIES\n"
    "0\nLINE\n8\nWALLS\n10\n1000.0\n20\n2000\n30\n0\n11\n3000\n21\n2000\n31\n0\n"
    "0\nLWPOLYLINE\n8\nFLOOR\n90\n4\n70\n1\n10\n0\n20\n0\n10\n10000\n20\n0\n10\n10000\n20\n8000\n10\n0\n20\n8"
    "000\n"
    "0\nLWPOLYLINE\n8\nRACKS\n90\n3\n70\n1\n10\n4000\n20\n4000\n10\n5000\n20\n4000\n10\n5000\n20\n5000\n"
    "0\nLWPOLYLINE\n8\nWALLS\n90\n2\n70\n0\n10\n6000\n20\n1000\n42\n1.0\n10\n8000\n20\n1000\n"
    "0\nPOLYLINE\n8\nWALLS\n66\n1\n70\n0\n0\nVERTEX\n8\nWALLS\n10\n1000\n20\n6000\n0\nVERTEX\n8\nWALLS\n10\n2"
    "000\n20\n6000\n0\nVERTEX\n8\nWALLS\n10\n2000\n20\n7000\n0\nSEQEND\n"
    "0\nCIRCLE\n8\nWALLS\n10\n1\n20\n1\n40\n3\n"
    "0\nENDSEC\n0\nEOF\n";

TEST(SceneYaml, ImportsADrawing) {
  const TemporaryFolder folder;
  folder.write("plan.dxf", kDxf);
  const auto scene = read_scene(folder.write("scene.yaml",
                                             "octant_scene: 1\nimport: [{dxf: plan.dxf, layers: [WALLS], "
                                             "obstacle_layers: [RACKS], floor_layer: FLOOR, top_m: 3}]\n"));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->floor_m.size(), 4u);
  EXPECT_EQ(scene->floor_m[2], Eigen::Vector2d(10, 8));
  ASSERT_EQ(scene->walls.size(), 4u);
  EXPECT_EQ(scene->walls[0].points_m[0], Eigen::Vector2d(1, 2));
  EXPECT_EQ(scene->walls[0].points_m[1], Eigen::Vector2d(3, 2));
  EXPECT_EQ(scene->walls[0].top_m, 3.0);
  EXPECT_TRUE(scene->walls[1].solid);
  EXPECT_EQ(scene->walls[1].points_m.size(), 3u);
  // A bulge of 1 is half a circle, to the right of the way for a positive one: from (6, 1) round (7, 1)
  // through (7, 0).
  const auto& arc = scene->walls[2].points_m;
  EXPECT_GE(arc.size(), 19u);
  for (const auto& p : arc) EXPECT_NEAR((p - Eigen::Vector2d(7, 1)).norm(), 1.0, 1e-12);
  EXPECT_NEAR(arc[arc.size() / 2].y(), 0.0, 1e-9);
  EXPECT_EQ(scene->walls[3].points_m.size(), 3u);
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_THAT(scene->warnings[0], HasSubstr("1 CIRCLE"));
}

TEST(SceneYaml, DrawingsThatAreNone) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& dxf) {
    folder.write("plan.dxf", dxf);
    const auto scene = read_scene(folder.write("scene.yaml", "octant_scene: 1\nimport: [{dxf: plan.dxf}]\n"));
    return scene ? std::string() : scene.error().message();
  };
  EXPECT_THAT(error_of("AutoCAD Binary DXF\r\n"), HasSubstr("binary"));
  EXPECT_THAT(error_of("hello\nworld\n"), HasSubstr("plan.dxf:1"));
  EXPECT_THAT(error_of("0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nx\n"), HasSubstr("plan.dxf:8"));
  EXPECT_THAT(error_of("0\nSECTION\n2\nENTITIES\n0\n"), HasSubstr("ends within a group"));
  EXPECT_THAT(error_of("0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n"), HasSubstr("not a single line"));
  EXPECT_THAT(error_of("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n12\n0\nENDSEC\n"), HasSubstr("unit_m"));
  // Without a unit: metres, with a warning.
  folder.write("plan.dxf",
               "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n1\n20\n2\n11\n3\n21\n4\n0\nENDSEC\n0\nEOF\n");
  const auto scene = read_scene(folder.write("scene.yaml", "octant_scene: 1\nimport: [{dxf: plan.dxf}]\n"));
  ASSERT_TRUE(scene);
  EXPECT_THAT(scene->warnings.at(0), HasSubstr("metres are assumed"));
  EXPECT_EQ(scene->walls[0].points_m[1], Eigen::Vector2d(3, 4));
}

// 4 x 3 pixels, the image's first row on top: a wall along the top row, one unknown pixel at the lower right.
constexpr const char* kPgm = "P2\n# made by hand\n4 3\n255\n0 0 0 0\n254 254 254 254\n254 254 254 205\n";

TEST(SceneYaml, ImportsARosMapWithOriginAndYaw) {
  const TemporaryFolder folder;
  folder.write("map.pgm", kPgm);
  folder.write("map.yaml",
               "image: map.pgm\nresolution: 0.5\norigin: [10, 20, 1.5707963267948966]\nnegate: "
               "0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  const auto scene =
      read_scene(folder.write("scene.yaml", "octant_scene: 1\nimport: [{ros_map: map.yaml, top_m: 2}]\n"));
  ASSERT_TRUE(scene) << scene.error().message();
  // Turned by a right angle: columns go with y, rows against x.
  ASSERT_EQ(scene->floor_m.size(), 4u);
  EXPECT_NEAR((scene->floor_m[1] - Eigen::Vector2d(10, 22)).norm(), 0, 1e-12);
  EXPECT_NEAR((scene->floor_m[2] - Eigen::Vector2d(8.5, 22)).norm(), 0, 1e-12);
  ASSERT_EQ(scene->walls.size(), 2u);
  const SceneWall& wall = scene->walls[0];
  EXPECT_TRUE(wall.solid && wall.blocks_sound);
  EXPECT_EQ(wall.top_m, 2.0);
  EXPECT_NEAR((wall.points_m[0] - Eigen::Vector2d(9, 20)).norm(), 0, 1e-12);
  EXPECT_NEAR((wall.points_m[2] - Eigen::Vector2d(8.5, 22)).norm(), 0, 1e-12);
  EXPECT_FALSE(scene->walls[1].blocks_sound);
  EXPECT_NEAR((scene->walls[1].points_m[0] - Eigen::Vector2d(10, 21.5)).norm(), 0, 1e-12);
}

TEST(RosMap, BinaryNegatedAndBroken) {
  const TemporaryFolder folder;
  const std::string yaml =
      folder.write("map.yaml", "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 1\n");
  folder.write("map.pgm", std::string("P5 2 2 255\n") + '\xFF' + '\x00' + '\x00' + '\x80');
  const auto map = read_ros_map(yaml);
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->cells,
            (std::vector<std::uint8_t>{RosMap::kFree, RosMap::kUnknown, RosMap::kOccupied, RosMap::kFree}));
  for (const char* broken : {"P6 2 2 255\nxxxx", "P5 2 2 255\nxxx", "P5 0 2 255\n", "P5 2 2 70000\nxxxxxxxx",
                             "P2 2 2 255\n1 2 3", "P2 2 2 255\n1 2 3 400", "P5 99999999 99999999 255\n"}) {
    folder.write("map.pgm", broken);
    EXPECT_FALSE(read_ros_map(yaml)) << broken;
  }
}

TEST(RosMap, RectanglesCoverEachCellOnce) {
  RosMap map{.columns = 7, .rows = 5, .resolution_m = 1.0, .cells = {}};
  for (std::size_t i = 0; i < 35; ++i)
    map.cells.push_back(i * 7 % 5 < 2 || i > 20 ? RosMap::kOccupied : RosMap::kFree);
  std::vector<int> covered(35, 0);
  for (const auto& corners : rectangles_of(map, RosMap::kOccupied))
    for (auto row = static_cast<std::size_t>(corners[0].y()); row < static_cast<std::size_t>(corners[2].y());
         ++row)
      for (auto column = static_cast<std::size_t>(corners[0].x());
           column < static_cast<std::size_t>(corners[2].x()); ++column)
        ++covered[row * 7 + column];
  for (std::size_t i = 0; i < 35; ++i) EXPECT_EQ(covered[i], map.cells[i] == RosMap::kOccupied ? 1 : 0);
}

TEST(RosMap, ACostmapReadsBackWhereItWas) {
  const TemporaryFolder folder;
  const auto text = costmap_text({254, 254, 0, 254, 205, 254}, 3, 2, 0.25, {-1.5, 2.0}, "cost.pgm");
  folder.write("cost.pgm", text.pgm);
  const auto map = read_ros_map(folder.write("cost.yaml", text.yaml));
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->origin_m, Eigen::Vector2d(-1.5, 2.0));
  EXPECT_EQ(map->resolution_m, 0.25);
  EXPECT_EQ(map->cells, (std::vector<std::uint8_t>{RosMap::kFree, RosMap::kFree, RosMap::kOccupied,
                                                   RosMap::kFree, RosMap::kUnknown, RosMap::kFree}));
}

}  // namespace scene_yaml_test
}  // namespace octant::io

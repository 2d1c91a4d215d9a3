// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "io/import/plan_import.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace dxf_test {

using test::expect_error;
using testing::HasSubstr;
using Points = std::vector<Eigen::Vector2d>;

std::string group(int code, const std::string& value) { return fmt::format("{}\n{}\n", code, value); }
std::string group(int code, double value) { return fmt::format("{:3d}\n{}\n", code, value); }

/// A corner and how the side from it to the next bulges.
struct Corner {
  Eigen::Vector2d at;
  double bulge = 0.0;
};

std::string lwpolyline(const std::vector<Corner>& corners, int flags, const std::string& more = "") {
  std::string text = group(0, "LWPOLYLINE") + group(8, "WALLS") + group(90, std::to_string(corners.size())) +
                     group(70, std::to_string(flags)) + more;
  for (const Corner& c : corners) {
    text += group(10, c.at.x()) + group(20, c.at.y());
    if (c.bulge != 0) text += group(42, c.bulge);
  }
  return text;
}

std::string drawing(const std::string& entities, const std::string& unit = "6") {
  return group(0, "SECTION") + group(2, "HEADER") + group(9, "$ACADVER") + group(1, "AC1015") +
         group(9, "$INSUNITS") + group(70, unit) + group(0, "ENDSEC") + group(0, "SECTION") +
         group(2, "ENTITIES") + entities + group(0, "ENDSEC") + group(0, "EOF");
}

Drawing read(const std::string& text, std::optional<double> unit_m = {}) {
  const auto result = drawing_from_dxf(text, "a.dxf", unit_m);
  EXPECT_TRUE(result) << result.error().message();
  return result.value_or(Drawing{});
}

double area_m2(const Points& p) {
  double twice = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector2d &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

TEST(Dxf, ABulgeIsTheTangentOfAQuarterOfItsAngle) {
  for (const double angle : {-6.0, -3.0, -1.0, -0.3, 0.3, 1.0, std::numbers::pi, 5.5}) {
    // An arc of radius 2 about (3, 1), by its ends.
    const auto on_arc = [](double turn) {
      return Eigen::Vector2d(3 + 2 * std::cos(turn), 1 + 2 * std::sin(turn));
    };
    const Drawing d =
        read(drawing(lwpolyline({{on_arc(0.4), std::tan(angle / 4)}, {on_arc(0.4 + angle)}}, 0)));
    ASSERT_EQ(d.lines.size(), 1U);
    const Points& p = d.lines[0].points_m;
    double turned = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      EXPECT_NEAR((p[i] - Eigen::Vector2d(3, 1)).norm(), 2.0, 1e-9) << "on the arc";
      if (i == 0) continue;
      const Eigen::Vector2d a = p[i - 1] - Eigen::Vector2d(3, 1), b = p[i] - Eigen::Vector2d(3, 1);
      const double step = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
      EXPECT_LE(std::abs(step), std::numbers::pi / 18 + 1e-9) << "chords of ten degrees at most";
      turned += step;
    }
    EXPECT_NEAR(turned, angle, 1e-9) << "the right way round, all of it";
  }
}

TEST(Dxf, AClosedLineBulgesBackToItsBeginToo) {
  // A slot: two straight sides of 4, two half circles of radius 1.
  const Drawing d = read(drawing(lwpolyline({{{0, 0}}, {{4, 0}, 1.0}, {{4, 2}}, {{0, 2}, 1.0}}, 1)));
  ASSERT_EQ(d.lines.size(), 1U);
  EXPECT_TRUE(d.lines[0].closed);
  // Eighteen chords of ten degrees: half of 36 / 2 sin(10 degrees) for each half circle.
  EXPECT_NEAR(area_m2(d.lines[0].points_m), 8.0 + 18 * std::sin(std::numbers::pi / 18), 1e-9);
  EXPECT_NE(d.lines[0].points_m.front(), d.lines[0].points_m.back()) << "the first corner stands there once";
}

/// CAD programs draw a round column as a closed line of two corners and two half circles.
TEST(Dxf, ACircleOfTwoHalvesIsWhole) {
  const Drawing d = read(drawing(lwpolyline({{{1, 3}, 1.0}, {{5, 3}, 1.0}}, 1)));
  ASSERT_EQ(d.lines.size(), 1U);
  const Points& p = d.lines[0].points_m;
  EXPECT_EQ(p.size(), 36U);
  for (const auto& corner : p) EXPECT_NEAR((corner - Eigen::Vector2d(3, 3)).norm(), 2.0, 1e-9);
  EXPECT_NEAR(area_m2(p), 18 * 4 * std::sin(std::numbers::pi / 18), 1e-9);
}

TEST(Dxf, LengthsAreInTheDrawingsUnitUnlessAnotherIsStated) {
  const std::string line =
      group(0, "LINE") + group(10, 1.0) + group(20, 2.0) + group(11, 3.0) + group(21, 5.0);
  for (const auto& [unit, metres] : std::vector<std::pair<const char*, double>>{{"1", 0.0254},
                                                                                {"2", 0.3048},
                                                                                {"4", 0.001},
                                                                                {"5", 0.01},
                                                                                {"6", 1.0},
                                                                                {"7", 1000.0},
                                                                                {"10", 0.9144},
                                                                                {"14", 0.1}}) {
    const Drawing d = read(drawing(line, unit));
    ASSERT_EQ(d.lines.size(), 1U);
    EXPECT_LT((d.lines[0].points_m[1] - metres * Eigen::Vector2d(3, 5)).norm(), 1e-12 * metres) << unit;
    EXPECT_TRUE(d.warnings.empty());
    EXPECT_EQ(read(drawing(line, unit), 0.5).lines[0].points_m[0], Eigen::Vector2d(0.5, 1.0));
  }
  EXPECT_THAT(read(drawing(line, "0")).warnings.at(0), HasSubstr("metres are assumed"));
  expect_error(drawing_from_dxf(drawing(line, "12"), "a.dxf"), 0, "$INSUNITS 12");
  EXPECT_TRUE(drawing_from_dxf(drawing(line, "12"), "a.dxf", 1.0)) << "a stated unit goes before it";
}

TEST(Dxf, WhatIsMirroredInItsPlaneIsMirroredHere) {
  const std::string down = group(210, 0.0) + group(220, 0.0) + group(230, -1.0);
  const Drawing d = read(drawing(lwpolyline({{{1, 0}, 1.0}, {{3, 0}}}, 0, down)));
  const Points& p = d.lines.at(0).points_m;
  EXPECT_EQ(p.front(), Eigen::Vector2d(-1, 0));
  // Seen from the other side the half circle below is still below, and left of the axis.
  for (const auto& corner : p) EXPECT_NEAR((corner - Eigen::Vector2d(-2, 0)).norm(), 1.0, 1e-12);
  EXPECT_LT(p[p.size() / 2].y(), -0.9);
}

std::string old_polyline(int flags, int vertex_flags = 0) {
  std::string text =
      group(0, "POLYLINE") + group(8, "OLD") + group(66, "1") + group(70, std::to_string(flags));
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}})
    text += group(0, "VERTEX") + group(8, "OTHER") + group(10, x) + group(20, y) +
            group(70, std::to_string(vertex_flags));
  return text + group(0, "SEQEND");
}

TEST(Dxf, AnOldPolylineIsItsVerticesOnItsOwnLayer) {
  Drawing d = read(drawing(old_polyline(0) + old_polyline(1)));
  ASSERT_EQ(d.lines.size(), 2U);
  EXPECT_EQ(d.lines[0].points_m, (Points{{0, 0}, {4, 0}, {4, 3}}));
  EXPECT_EQ(d.lines[0].layer, "OLD");
  EXPECT_FALSE(d.lines[0].closed);
  EXPECT_TRUE(d.lines[1].closed);
  EXPECT_EQ(d.lines[1].points_m.size(), 3U);
  d = read(drawing(old_polyline(64) + old_polyline(0, 16)));
  EXPECT_TRUE(d.lines.empty()) << "a mesh; a spline's frame";
  EXPECT_THAT(d.warnings.at(0), HasSubstr("1 POLYLINE of a mesh"));
}

TEST(Dxf, WhatIsNotReadIsCounted) {
  const Drawing d = read(drawing(group(0, "CIRCLE") + group(10, 1.0) + group(0, "ARC") + group(0, "CIRCLE") +
                                 lwpolyline({{{0, 0}}, {{1, 0}}}, 0)));
  EXPECT_EQ(d.lines.size(), 1U);
  ASSERT_EQ(d.warnings.size(), 1U);
  EXPECT_THAT(d.warnings[0], HasSubstr("not read: 1 ARC, 2 CIRCLE"));
}

TEST(Dxf, PointsThatStandThereTwiceAreOne) {
  const Drawing d =
      read(drawing(lwpolyline({{{0, 0}}, {{0, 0}}, {{2, 0}}, {{2, 2}}, {{2, 2}}, {{0, 0}}}, 1) +
                   lwpolyline({{{7, 7}}, {{7, 7}}}, 0) + lwpolyline({{{7, 7}}}, 1) + lwpolyline({}, 1)));
  ASSERT_EQ(d.lines.size(), 1U) << "a line of one place is none";
  EXPECT_EQ(d.lines[0].points_m, (Points{{0, 0}, {2, 0}, {2, 2}}));
}

TEST(Dxf, BlocksAndHeadersAreNoLinesOfThePlan) {
  const std::string block =
      group(0, "SECTION") + group(2, "BLOCKS") + lwpolyline({{{0, 0}}, {{9, 9}}}, 0) + group(0, "ENDSEC");
  EXPECT_TRUE(read(block + drawing("")).lines.empty());
}

TEST(Dxf, LinesKnowWhereTheyStandInTheFile) {
  const std::string text = drawing(lwpolyline({{{0, 0}}, {{1, 0}}}, 0));
  const Drawing d = read(text);
  int line = 0;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word);) {
    ++line;
    if (word == "LWPOLYLINE") EXPECT_EQ(d.lines.at(0).line, line);
  }
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(read(windows).lines.at(0).points_m, d.lines[0].points_m) << "whatever ends its lines";
}

TEST(Dxf, FaultsAreNamedByTheirLine) {
  const std::string head = group(0, "SECTION") + group(2, "ENTITIES") + group(0, "LINE");
  expect_error(drawing_from_dxf("AutoCAD Binary DXF\r\n\x1a", "a"), 1, "a binary DXF");
  expect_error(drawing_from_dxf(head + "ten\n1\n", "a"), 7, "'ten' where a DXF group code should be");
  expect_error(drawing_from_dxf(head + "1.5\n1\n", "a"), 7, "group code");
  expect_error(drawing_from_dxf(head + "1e9\n1\n", "a"), 7, "group code");
  expect_error(drawing_from_dxf(head + "10\n", "a"), 7, "ends within a group");
  expect_error(drawing_from_dxf(head + "10\nnan\n", "a"), 8, "'nan' for group 10; expected a number");
  expect_error(drawing_from_dxf(head + "70\n1.5\n", "a"), 8, "expected a whole number");
  expect_error(drawing_from_dxf(head + "8\n\xFF\n", "a"), 8, "byte 0xFF");
}

}  // namespace dxf_test
}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/figure_json.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "models/simulator/random.h"
#include "survey/drawing/palette.h"
#include "survey/drawing/plan_frame.h"
#include "survey/drawing/site_plan.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace figure_json_test {

using nlohmann::json;

json trace_of(const json& figure, const std::string& name_begins) {
  for (const json& trace : figure.at("data"))
    if (trace.contains("name") && trace["name"].get<std::string>().starts_with(name_begins)) return trace;
  ADD_FAILURE() << "no trace " << name_begins;
  return json();
}

bool has_trace(const json& figure, const std::string& name_begins) {
  for (const json& trace : figure.at("data"))
    if (trace.contains("name") && trace["name"].get<std::string>().starts_with(name_begins)) return true;
  return false;
}

/// A plan of one calibrated beacon with a skew covariance, and a second one to give it a size.
PlanInput one_ellipse(const Eigen::Matrix3d& C) {
  PlanInput plan;
  plan.deployment.beacons = {test_beacon("B0", 3, 4, 0, BeaconStatus::kCalibrated),
                             test_beacon("B1", 13, 9, 0, BeaconStatus::kControlPoint)};
  plan.deployment.beacons[0].covariance_m2 = C;
  return plan;
}

Eigen::Matrix3d some_covariance(Random& draws) {
  Eigen::Matrix3d root;
  for (int k = 0; k < 3; ++k) root.col(k) = 0.01 * draws.normal3();
  return root * root.transpose() + 1e-6 * Eigen::Matrix3d::Identity();
}

/// Points are rounded to a hundred thousandth of the figure's size, about 1e-4 m here, and drawn larger: the
/// quadratic form deviates by twice that part of the smallest half axis.
double form_tolerance(const Eigen::Matrix3d& C, double drawn) {
  const double least_m =
      drawn * std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(C).eigenvalues()[0]);
  return 4e-4 / least_m;
}

TEST(PlanFigure, EllipsesHaveTheFormOfTheCovariance) {
  Random draws(20261125);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d C = some_covariance(draws);
    const PlanInput plan = one_ellipse(C);
    const double drawn = ellipse_exaggeration(plan.deployment, plan_frame(plan).extent_m());
    const json trace = trace_of(json::parse(plan_figure_json(plan)), "95 % ellipse");
    std::size_t points = 0;
    for (std::size_t k = 0; k < trace["x"].size(); ++k) {
      if (trace["x"][k].is_null()) continue;
      ++points;
      const Eigen::Vector2d arm(trace["x"][k].get<double>() - 3, trace["y"][k].get<double>() - 4);
      // Chi-square of two: exp(-q / 2) of all lies beyond q.
      const double q = arm.dot(C.topLeftCorner<2, 2>().inverse() * arm) / (drawn * drawn);
      EXPECT_NEAR(q / (-2 * std::log(0.05)), 1.0, 1e-4 + form_tolerance(C, drawn));
    }
    EXPECT_GT(points, 20U);
  }
}

TEST(SpaceFigure, EllipsoidsAreOnTheirSurface) {
  Random draws(2);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d C = some_covariance(draws);
    const PlanInput plan = one_ellipse(C);
    const double drawn = ellipse_exaggeration(plan.deployment, plan_frame(plan).extent_m());
    const json trace = trace_of(json::parse(space_figure_json(plan)), "95 % ellipsoid");
    for (std::size_t k = 0; k < trace["x"].size(); ++k) {
      if (trace["x"][k].is_null()) continue;
      const Eigen::Vector3d arm(trace["x"][k].get<double>() - 3, trace["y"][k].get<double>() - 4,
                                trace["z"][k].get<double>() - 2.5);
      // Abramowitz and Stegun, table 26.8: 0.95 quantile of chi-square, three degrees of freedom, is 7.81473.
      EXPECT_NEAR(arm.dot(C.inverse() * arm) / (drawn * drawn) / 7.81473, 1.0,
                  1e-4 + form_tolerance(C, drawn));
    }
  }
}

TEST(PlanFigure, BeaconsStandWhereTheyAreWithAllThatIsKnown) {
  const PlanInput plan = one_ellipse(1e-6 * Eigen::Matrix3d::Identity());
  const json figure = json::parse(plan_figure_json(plan));
  const json beacon = trace_of(figure, "calibrated beacon"), control = trace_of(figure, "control point");
  EXPECT_EQ(beacon["x"], json({3.0}));
  EXPECT_EQ(beacon["y"], json({4.0}));
  EXPECT_EQ(beacon["text"], json({"B0"}));
  EXPECT_EQ(beacon["hovertext"][0],
            "B0<br>x 3.0000, y 4.0000, z 2.5000 m<br>U (k = 2) 2 mm, 2 mm, 2 mm<br>delay 100 µs");
  EXPECT_EQ(control["x"], json({13.0}));
  EXPECT_NE(beacon["marker"]["symbol"], control["marker"]["symbol"]) << "told by shape, not by colour alone";
  EXPECT_EQ(figure["layout"]["yaxis"]["scaleanchor"], "x") << "a metre is a metre in both directions";
}

TEST(PlanFigure, MapsAreRowsFromBelowWithGapsWhereNothingIs) {
  PlanInput plan = full_report().plan;
  const json figure = json::parse(plan_figure_json(plan));
  const json map = trace_of(figure, "HDOP");
  EXPECT_EQ(map["z"], json::parse("[[1.0, 2.0], [3.0, null]]"));
  EXPECT_EQ(map["x0"], 2.5) << "the middle of the first cell";
  EXPECT_EQ(map["dx"], 5.0);
  EXPECT_EQ(map["visible"], true);
  EXPECT_EQ(trace_of(figure, "error")["visible"], false) << "one at a time";
  EXPECT_EQ(trace_of(figure, "error")["layer"], 1);
}

TEST(PlanFigure, AMapAgainstATolerance) {
  PlanInput plan = full_report().plan;
  plan.maps[1].tolerance = 8.0;
  const json map = trace_of(json::parse(plan_figure_json(plan)), "error");
  // Seven classes, the last as wide as the first: to 2.25 times the tolerance.
  EXPECT_EQ(map["zmin"], 0.0);
  EXPECT_EQ(map["zmax"], 18.0);
  const json& scale = map["colorscale"];
  EXPECT_EQ(scale.front()[0], 0.0);
  EXPECT_EQ(scale.back()[0], 1.0);
  for (std::size_t i = 1; i < scale.size(); ++i)
    EXPECT_GE(scale[i][0].get<double>(), scale[i - 1][0].get<double>());
  // At the tolerance itself the colour changes from near to beyond.
  const auto edge = std::find_if(scale.begin(), scale.end(), [](const json& stop) {
    return std::abs(stop[0].get<double>() - 8.0 / 18) < 1e-12;
  });
  ASSERT_NE(edge, scale.end());
  EXPECT_EQ((*edge)[1], kToleranceColours[3]);
  EXPECT_EQ((*(edge + 1))[1], kToleranceColours[4]);
}

TEST(PlanFigure, LinesArePartedByGapsAndClosedWhereTheyAre) {
  PlanInput plan = full_report().plan;
  plan.walls = {{"rack <1>", {{0, 0}, {1, 0}, {1, 1}}, true}, {"", {{2, 2}, {3, 3}}, false}};
  const json wall = trace_of(json::parse(plan_figure_json(plan)), "wall");
  EXPECT_EQ(wall["x"], json::parse("[0.0, 1.0, 1.0, 0.0, null, 2.0, 3.0, null]"));
  EXPECT_EQ(wall["text"], json::parse(R"(["rack &lt;1&gt;", "", "", "", "", "", "", ""])"));
  EXPECT_EQ(wall["hovertext"][5], "wall");
  // That number of names would hide the map.
  plan.walls.assign(41, NamedLine(plan.walls[0]));
  EXPECT_FALSE(trace_of(json::parse(plan_figure_json(plan)), "wall").contains("text"));
}

TEST(PlanFigure, OfVeryManyBeaconsThereAreDotsAlone) {
  PlanInput plan;
  for (std::size_t i = 0; i <= kMostNamed; ++i)
    plan.deployment.beacons.push_back(test_beacon("B", static_cast<double>(i), 2.0 * static_cast<double>(i),
                                                  0.01, BeaconStatus::kCalibrated));
  const json figure = json::parse(plan_figure_json(plan));
  EXPECT_FALSE(has_trace(figure, "95 %"));
  const json beacon = trace_of(figure, "calibrated beacon");
  EXPECT_EQ(beacon["x"].size(), kMostNamed + 1);
  EXPECT_EQ(beacon["mode"], "markers");
  EXPECT_FALSE(beacon.contains("text"));
}

TEST(PlanFigure, OfNothingIsStillAFigure) {
  for (const std::string& text : {plan_figure_json({}), space_figure_json({})}) {
    const json figure = json::parse(text);
    EXPECT_TRUE(figure["data"].empty());
    EXPECT_TRUE(figure["layout"].is_object());
  }
}

TEST(ResidualFigure, HasMeansAndRmsInTheUnitOfItsAxis) {
  const ResidualChart chart{"distance", "m", {{"", 2, 4, 9, 1.5e-6, 4e-6}, {"", 4, 8, 7, -2e-6, 3e-6}}};
  const json figure = json::parse(residual_chart_json(chart)), trace = figure["data"][0];
  EXPECT_EQ(trace["x"], json::parse("[3.0, 6.0]"));
  EXPECT_EQ(trace["y"], json::parse("[1.5, -2.0]"));
  EXPECT_EQ(trace["error_y"]["array"], json::parse("[4.0, 3.0]"));
  EXPECT_EQ(trace["error_x"]["array"], json::parse("[1.0, 2.0]"));
  EXPECT_EQ(figure["layout"]["yaxis"]["title"]["text"], "residual [µs]");
  EXPECT_EQ(figure["layout"]["xaxis"]["title"]["text"], "distance [m]");
  const ResidualChart named{"beacon", "", {{"B & 1", 0, 0, 9, 1e-9, 4e-9}}};
  const json by_name = json::parse(residual_chart_json(named));
  EXPECT_EQ(by_name["data"][0]["x"], json({"B &amp; 1"}));
  EXPECT_EQ(by_name["layout"]["xaxis"]["type"], "category") << "names that are numbers stay names";
  EXPECT_EQ(by_name["layout"]["yaxis"]["title"]["text"], "residual [ns]");
}

TEST(HistogramFigure, HasTheCountsAtTheMiddlesOfTheirBins) {
  const json figure = json::parse(histogram_json({-1.5, 0.5, {4, 5, 6}}));
  EXPECT_EQ(figure["data"][0]["x"], json::parse("[-1.25, -0.75, -0.25]"));
  EXPECT_EQ(figure["data"][0]["y"], json::parse("[4, 5, 6]"));
  EXPECT_EQ(figure["data"][0]["width"], 0.5);
  EXPECT_EQ(figure["data"][1]["x"], figure["data"][0]["x"]);
}

TEST(ErrorFigure, GoesFromNoneToAllOfTheFixes) {
  const json figure = json::parse(error_curve_json({0.001, 0.002, 0.004}, 0.05));
  EXPECT_EQ(figure["data"][0]["x"], json::parse("[1.0, 2.0, 4.0]"));
  EXPECT_EQ(figure["data"][0]["y"], json::parse("[0.0, 50.0, 100.0]"));
  EXPECT_EQ(figure["data"][1]["x"], json::parse("[50.0, 50.0]"));
  EXPECT_EQ(json::parse(error_curve_json({0.001, 0.002}, std::nullopt))["data"].size(), 1U);
  EXPECT_EQ(error_curve_json({}, 0.05), "");
}

}  // namespace figure_json_test
}  // namespace octant::survey

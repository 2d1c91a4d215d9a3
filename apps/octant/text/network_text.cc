// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/network_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <ranges>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Eigenvalues>

#include "apps/octant/text/layout.h"
#include "calib/errors/reliability.h"
#include "calib/network/survey_row.h"

namespace octant::app {
namespace {

constexpr double kMilligonPerRad = 2e5 / std::numbers::pi;
constexpr std::array kAxes = {"x", "y", "z"};

const char* name_of(SurveyKind kind) {
  switch (kind) {
    case SurveyKind::kDirection: return "direction";
    case SurveyKind::kAzimuth: return "azimuth";
    case SurveyKind::kAngle: return "angle";
    case SurveyKind::kZenithAngle: return "zenith_angle";
    case SurveyKind::kHorizontalDistance: return "horizontal_distance";
    case SurveyKind::kSlopeDistance: return "slope_distance";
    case SurveyKind::kHeightDifference: return "height_difference";
    case SurveyKind::kX: return "x";
    case SurveyKind::kY: return "y";
    case SurveyKind::kZ: return "z";
    case SurveyKind::kDx: return "dx";
    case SurveyKind::kDy: return "dy";
    case SurveyKind::kDz: return "dz";
    case SurveyKind::kConstant: return "constant";
  }
  return "";
}

bool is_angle(SurveyKind kind) { return kind <= SurveyKind::kZenithAngle; }

/// Sign of an angle in the file relative to the network.
double sign_of(const io::NetworkFile& file, SurveyKind kind) {
  return kind < SurveyKind::kZenithAngle ? file.angle_sign : 1.0;
}

double value_in_file(const io::NetworkFile& file, const SurveyObservation& o, double value) {
  if (!is_angle(o.kind)) return value;
  const double north = o.kind == SurveyKind::kAzimuth ? file.north_rad : 0.0;
  const double turned = std::fmod(sign_of(file, o.kind) * (value - north), 2.0 * std::numbers::pi);
  return turned < 0.0 ? turned + 2.0 * std::numbers::pi : turned;
}

std::string points_in_words(const AdjustedNetwork& a, CoordinateRole role) {
  std::vector<std::string> names;
  for (const NetworkPoint& p : a.solved.network.points) {
    std::string axes;
    for (std::size_t i = 0; i < 3; ++i)
      if (p.role[i] == role) axes += kAxes[i];
    if (!axes.empty()) names.push_back(fmt::format("{} ({})", p.id, axes));
  }
  return joined(names, ", ", [](const std::string& name) { return name; });
}

struct Ellipse {
  double major_m, minor_m, azimuth_rad;
};

std::optional<Ellipse> ellipse_of(const Eigen::Matrix3d& covariance, const std::array<int, 3>& column) {
  if (column[0] < 0 || column[1] < 0) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  const Eigen::Vector2d major = eigen.eigenvectors().col(1);
  double azimuth = std::atan2(major.y(), major.x());
  if (azimuth < 0.0) azimuth += std::numbers::pi;
  return Ellipse{std::sqrt(std::max(eigen.eigenvalues()[1], 0.0)),
                 std::sqrt(std::max(eigen.eigenvalues()[0], 0.0)), azimuth};
}

double sigma_of(const AdjustedNetwork& a, std::size_t point, std::size_t axis) {
  const auto i = static_cast<Eigen::Index>(axis);
  return std::sqrt(std::max(a.solved.solution.point_covariances_m2[point](i, i), 0.0));
}

Json points_json(const AdjustedNetwork& a, const calib::NetworkColumns& columns) {
  Json list = Json::array();
  for (std::size_t p = 0; p < a.solved.network.points.size(); ++p) {
    const NetworkPoint& point = a.solved.network.points[p];
    Json position = Json::array(), sigma = Json::array(), role = Json::array();
    for (std::size_t i = 0; i < 3; ++i) {
      const CoordinateRole r = point.role[i];
      const bool absent = r == CoordinateRole::kAbsent, fixed = r == CoordinateRole::kFixed;
      const int c = columns.point[p][i];
      position.push_back(absent ? Json(nullptr) : Json(a.solved.solution.points_m[p][static_cast<int>(i)]));
      sigma.push_back(c >= 0 ? Json(sigma_of(a, p, i)) : fixed ? Json(0.0) : Json(nullptr));
      role.push_back(absent  ? Json(nullptr)
                     : fixed ? "fixed"
                             : Json(r == CoordinateRole::kDatum ? "datum" : "adjusted"));
    }
    Json entry = {{"id", point.id}, {"position_m", position}, {"sigma_m", sigma}, {"role", role}};
    entry["approximate_computed"] = std::ranges::count(a.solved.computed, point.id) > 0;
    const auto ellipse = ellipse_of(a.solved.solution.point_covariances_m2[p], columns.point[p]);
    entry["ellipse"] = ellipse ? Json{{"major_m", ellipse->major_m},
                                      {"minor_m", ellipse->minor_m},
                                      {"azimuth_rad", ellipse->azimuth_rad}}
                               : Json(nullptr);
    list.push_back(std::move(entry));
  }
  return list;
}

/// Covariance of the adjusted coordinates; null for a large network.
Json covariance_json(const AdjustedNetwork& a, const calib::NetworkColumns& columns) {
  if (a.solved.solution.covariance.size() == 0) return nullptr;
  Json names = Json::array(), rows = Json::array();
  for (std::size_t p = 0; p < columns.point.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (columns.point[p][i] >= 0) names.push_back(a.solved.network.points[p].id + "/" + kAxes[i]);
  for (int r = 0; r < columns.first_set; ++r) {
    const Eigen::RowVectorXd row = a.solved.solution.covariance.row(r).head(columns.first_set);
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return {{"coordinates", names}, {"matrix_m2", rows}};
}

Json observations_json(const AdjustedNetwork& a) {
  const auto id = [&](int p) {
    return p < 0 ? Json(nullptr) : Json(a.solved.network.points[static_cast<std::size_t>(p)].id);
  };
  Json list = Json::array();
  for (std::size_t i = 0; i < a.solved.network.observations.size(); ++i) {
    const SurveyObservation& o = a.solved.network.observations[i];
    const calib::ObservationResult& r = a.solved.solution.observations[i];
    const double sign = sign_of(a.file, o.kind);
    const bool checked = std::isfinite(r.detectable_bias);
    list.push_back({{"kind", name_of(o.kind)},
                    {"from", id(o.from)},
                    {"to", id(o.to)},
                    {"second", id(o.second)},
                    {"line", o.line},
                    {"unit", is_angle(o.kind) ? "rad" : "m"},
                    {"observed", value_in_file(a.file, o, o.value)},
                    {"sigma", o.sigma},
                    {"adjusted", value_in_file(a.file, o, o.value + r.residual)},
                    {"residual", sign * r.residual},
                    {"redundancy", r.redundancy},
                    {"w", checked ? Json(sign * r.w) : Json(nullptr)},
                    {"detectable_bias", checked ? Json(r.detectable_bias) : Json(nullptr)}});
  }
  return list;
}

std::string observation_in_words(const AdjustedNetwork& a, const SurveyObservation& o) {
  std::string words = name_of(o.kind);
  std::ranges::replace(words, '_', ' ');
  for (const int p : {o.from, o.to, o.second})
    if (p >= 0) words += fmt::format(" {}", a.solved.network.points[static_cast<std::size_t>(p)].id);
  return words;
}

std::string line_in_words(const SurveyObservation& o) {
  return o.line > 0 ? fmt::format(" (line {})", o.line) : "";
}

std::string points_text(const AdjustedNetwork& a, const calib::NetworkColumns& columns) {
  Table table{"lrrrrrr", {{"point", "x [m]", "y", "z", "sx [mm]", "sy", "sz"}}};
  for (std::size_t p = 0; p < columns.point.size(); ++p) {
    const NetworkPoint& point = a.solved.network.points[p];
    std::vector<std::string> row = {point.id};
    for (std::size_t i = 0; i < 3; ++i)
      row.push_back(point.role[i] == CoordinateRole::kAbsent
                        ? "-"
                        : fmt::format("{:.5f}", a.solved.solution.points_m[p][static_cast<int>(i)]));
    for (std::size_t i = 0; i < 3; ++i)
      row.push_back(columns.point[p][i] >= 0                  ? fmt::format("{:.3f}", 1e3 * sigma_of(a, p, i))
                    : point.role[i] == CoordinateRole::kFixed ? "fixed"
                                                              : "-");
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

std::string observations_text(const AdjustedNetwork& a) {
  Table table{"lrrrrr", {{"observation", "residual", "sigma", "redundancy", "w", "detectable"}}};
  for (std::size_t i = 0; i < a.solved.network.observations.size(); ++i) {
    const SurveyObservation& o = a.solved.network.observations[i];
    const calib::ObservationResult& r = a.solved.solution.observations[i];
    const double scale = is_angle(o.kind) ? kMilligonPerRad : 1e3;
    const char* unit = is_angle(o.kind) ? "mgon" : "mm";
    const double sign = sign_of(a.file, o.kind);
    const bool checked = std::isfinite(r.detectable_bias);
    table.rows.push_back({observation_in_words(a, o),
                          fmt::format("{:.3f} {}", scale * sign * r.residual, unit),
                          fmt::format("{:.3f}", scale * o.sigma), fmt::format("{:.3f}", r.redundancy),
                          checked ? fmt::format("{:.2f}", sign * r.w) : "-",
                          checked ? fmt::format("{:.3f}", scale * r.detectable_bias) : "-"});
  }
  return table.text();
}

}  // namespace

std::string datum_in_words(const AdjustedNetwork& a) {
  const std::string fixed = points_in_words(a, CoordinateRole::kFixed);
  std::string words = fixed.empty() ? "" : "fixed points " + fixed;
  if (a.solved.solution.defect > 0)
    words += fmt::format("{}inner constraints over the datum points {}, which remove a defect of {}",
                         words.empty() ? "free network: " : "; ", points_in_words(a, CoordinateRole::kDatum),
                         a.solved.solution.defect);
  return words.empty() ? "given by observed coordinates" : words;
}

Json network_json(const AdjustedNetwork& a) {
  const calib::NetworkColumns columns = calib::network_columns(a.solved.network);
  return {{"description", a.file.description},
          {"datum", datum_in_words(a)},
          {"iterations", a.solved.solution.iterations},
          {"unknowns", columns.size},
          {"defect", a.solved.solution.defect},
          {"redundancy", a.solved.solution.redundancy},
          {"sigma_unit", a.file.sigma_unit},
          {"variance_factor",
           a.solved.solution.redundancy > 0 ? Json(a.solved.solution.variance_factor) : Json(nullptr)},
          {"sigmas", a.file.sigmas_a_posteriori ? "a_posteriori" : "a_priori"},
          {"points", points_json(a, columns)},
          {"covariance", covariance_json(a, columns)},
          {"observations", observations_json(a)}};
}

std::string network_text(const AdjustedNetwork& a, bool all_observations) {
  const calib::NetworkColumns columns = calib::network_columns(a.solved.network);
  std::string text = points_text(a, columns) + "\n";
  text += named_line("datum", datum_in_words(a));
  if (!a.solved.computed.empty())
    text += named_line("approximate", fmt::format("computed for {} points", a.solved.computed.size()));
  text += named_line("observations",
                     fmt::format("{}, {} unknowns, redundancy {}", a.solved.solution.observations.size(),
                                 columns.size, a.solved.solution.redundancy));
  text += named_line("variance factor", a.solved.solution.redundancy > 0
                                            ? fmt::format("{:.4g}", a.solved.solution.variance_factor)
                                            : "unknown: the network has no redundancy");
  text += named_line("sigmas", a.file.sigmas_a_posteriori ? "scaled by the variance factor" : "as stated");
  if (all_observations) text += "\n" + observations_text(a);
  return text;
}

std::vector<std::string> left_out_in_words(const AdjustedNetwork& a) {
  std::vector<std::string> words;
  const auto points = [&](const std::vector<std::string>& names, const char* reason) {
    if (!names.empty()) words.push_back(fmt::format("{}: {}.", reason, fmt::join(names, ", ")));
  };
  points(a.solved.unlocated,
         "Points left out that the observations do not locate (give coordinates or add observations)");
  points(a.solved.undetermined, "Points left out that the observations and the datum do not determine");
  if (a.solved.unusable > 0)
    words.push_back(fmt::format(
        "{} observations are left out because a point of theirs is neither fixed nor adjusted, or "
        "because their set of directions has one target.",
        a.solved.unusable));
  constexpr std::size_t kMostNamed = 10;
  const std::string reason =
      a.file.outlier_limit_m > 0.0
          ? fmt::format(
                "at the approximate coordinates it deviates by more than {} m. Check it, the "
                "coordinates, and the limit",
                a.file.outlier_limit_m)
          : "it does not agree with the others (a reflection?)";
  for (const SurveyObservation& o : a.solved.outlying | std::views::take(kMostNamed))
    words.push_back(
        fmt::format("The {}{} is left out: {}.", observation_in_words(a, o), line_in_words(o), reason));
  if (a.solved.outlying.size() > kMostNamed)
    words.push_back(fmt::format("{} more observations are left out for the same reason.",
                                a.solved.outlying.size() - kMostNamed));
  return words;
}

std::vector<std::string> suspicious_observations(const AdjustedNetwork& a) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < a.solved.solution.observations.size(); ++i)
    if (std::abs(a.solved.solution.observations[i].w) > calib::kCriticalW) order.push_back(i);
  std::ranges::sort(order, std::greater{},
                    [&](std::size_t i) { return std::abs(a.solved.solution.observations[i].w); });
  std::vector<std::string> words;
  for (const std::size_t i : order) {
    const SurveyObservation& o = a.solved.network.observations[i];
    words.push_back(fmt::format(
        "The {}{} does not agree with the others: w is {:.1f} (limit {}). Check it first if it is "
        "the largest.",
        observation_in_words(a, o), line_in_words(o), std::abs(a.solved.solution.observations[i].w),
        calib::kCriticalW));
  }
  return words;
}

}  // namespace octant::app

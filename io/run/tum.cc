// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/tum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "io/text/bounds.h"
#include "io/text/text.h"
#include "io/tof/continued_clock.h"
#include "io/tof/run_parts.h"
#include "models/physics/unit_rotation.h"
#include "models/support/largest.h"

namespace octant::io {
namespace {

constexpr const char* kExpected = "time_s x y z qx qy qz qw, separated by blanks";

/// Reads the lines of a TUM text; the first error sticks.
class TumReader {
 public:
  TumReader(std::string_view text, const std::string& file, ContinuedClock* clock)
      : text_(without_bom(text)), file_(file), clock_(clock) {}

  Result<std::vector<TimedPose>> read() {
    if (auto ok = check_lines(text_, file_); !ok) return fail(ok.error());
    std::vector<TimedPose> poses;
    for (; !text_.empty() && !error_; ++line_) {
      const std::string_view line = take_line(text_);
      std::array<double, 8> v{};
      if (!read_numbers(line.substr(0, line.find('#')), v)) continue;
      const double stated_s = v[0];
      if (clock_ != nullptr && !poses.empty()) v[0] = clock_->continued(stated_s, poses.back().time_s, line_);
      if (!poses.empty() && !(v[0] > poses.back().time_s)) {
        const double last_s = poses.back().time_s - (v[0] - stated_s);
        note(0, fmt::format("time_s {} after {}", exact(stated_s), exact(last_s)),
             "strictly increasing times", "sort the rows and keep one for each time");
        break;
      }
      const auto q = unit_rotation(v[4], v[5], v[6], v[7]);
      if (!q) {
        note(0, "a quaternion of no length", "qx qy qz qw of length 1 (0 0 0 1 for no rotation)");
        break;
      }
      poses.push_back({v[0], {{v[1], v[2], v[3]}, *q}});
    }
    if (error_) return fail(*error_);
    return poses;
  }

 private:
  /// False for a line without fields, and on error.
  bool read_numbers(std::string_view line, std::array<double, 8>& values) {
    std::size_t count = 0;
    for (std::size_t at = 0;;) {
      at = line.find_first_not_of(" \t\r", at);
      if (at == std::string_view::npos) break;
      const std::size_t stop = std::min(line.find_first_of(" \t\r", at), line.size());
      const std::string_view word = line.substr(at, stop - at);
      if (count == values.size()) return note(at + 1, "more than 8 fields", kExpected);
      if (parse_number(word, values[count]) != NumberText::kNumber || !std::isfinite(values[count])) {
        const bool commas = word.find(',') != std::string_view::npos;
        return note(at + 1, in_quotes(word), commas ? kExpected : "a finite number",
                    commas ? "no commas" : "");
      }
      const bool is_length = count >= 1 && count <= 3;
      if (is_length && std::abs(values[count]) > kLargestLength_m)
        return note(at + 1, in_quotes(word), kExpectedLength);
      ++count;
      at = stop;
    }
    if (count == 0) return false;
    return count == values.size() || note(0, fmt::format("{} field{}", count, count == 1 ? "" : "s"),
                                          kExpected, "the row may be cut off");
  }

  bool note(std::size_t column, std::string found, std::string expected, std::string advice = "") {
    error_ = Error{.file = file_,
                   .line = line_,
                   .column = static_cast<int>(column),
                   .found = std::move(found),
                   .expected = std::move(expected),
                   .advice = std::move(advice)};
    return false;
  }

  std::string_view text_;
  const std::string& file_;
  ContinuedClock* clock_;
  int line_ = 1;
  std::optional<Error> error_;
};

void append_tum(std::string& text, double time_s, const Pose& T) {
  const auto& p = T.translation_m;
  const auto& q = T.rotation;
  fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}\n", time_s, p.x(), p.y(), p.z(), q.x(),
                 q.y(), q.z(), q.w());
}

constexpr const char* kTumHeader = "# time_s x y z qx qy qz qw\n";

/// Variance of the heading of a spatial pose: with f = R e_x and w = R delta the rotation in the map,
///   d heading = w_z - f_z (f_x w_x + f_y w_y) / (f_x^2 + f_y^2).
double heading_variance(const Fix& fix) {
  if (fix.covariance.rows() == 3) return fix.covariance(2, 2);
  const Eigen::Matrix3d R = fix.T_map_vehicle.rotation.toRotationMatrix();
  const Eigen::Vector3d f = R.col(0);
  const double level = f.x() * f.x() + f.y() * f.y();
  const Eigen::RowVector3d by_map(-f.z() * f.x() / level, -f.z() * f.y() / level, 1.0);
  const Eigen::RowVector3d by_body = by_map * R;
  return by_body * fix.covariance.block<3, 3>(3, 3) * by_body.transpose();
}

/// A standard deviation as a field; empty for NaN.
std::string sigma_field(double variance) { return number_field(std::sqrt(variance)); }

constexpr std::array<const char*, 6> kVelocities = {"velocity_x_mps",    "velocity_y_mps",
                                                    "velocity_z_mps",    "turn_rate_x_radps",
                                                    "turn_rate_y_radps", "turn_rate_z_radps"};
/// Components of a pose in the names of the covariance's columns.
constexpr std::array<const char*, 6> kComponents = {"x", "y", "z", "turn_x", "turn_y", "turn_z"};

/// Fields of the velocity and of the upper triangle of the covariance.
void append_motion(std::string& text, const Fix& fix) {
  for (Eigen::Index i = 0; i < 6; ++i)
    text += "," + (fix.ok() && fix.velocity ? number_field(fix.velocity->mean[i]) : "");
  const bool known = fix.ok() && fix.covariance.rows() > 0;
  const Eigen::Matrix<double, 6, 6> C = covariance_in_map(fix.covariance, fix.T_map_vehicle);
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = i; j < 6; ++j) text += "," + (known ? number_field(C(i, j)) : "");
}

void append_csv(std::string& text, const Fix& fix, const NameTable& names) {
  const auto out = std::back_inserter(text);
  const bool named = fix.vehicle.valid() && fix.vehicle.index() < names.vehicles.size();
  fmt::format_to(out, "{},{},", fix.time_s, named ? csv_field(names.vehicles[fix.vehicle.index()]) : "");
  if (fix.ok()) {
    const auto& p = fix.T_map_vehicle.translation_m;
    fmt::format_to(out, "{},{},{},{},", p.x(), p.y(), p.z(), fix.T_map_vehicle.heading_rad());
    const auto n = fix.covariance.rows();
    if (n == fix.covariance.cols() && (n == 3 || n == 6)) {
      fmt::format_to(out, "{},{},{},", sigma_field(fix.covariance(0, 0)), sigma_field(fix.covariance(1, 1)),
                     sigma_field(heading_variance(fix)));
    } else {
      text += ",,,";
    }
    text += fix.protection_level_m > 0.0 ? exact(fix.protection_level_m) : "";
  } else {
    text += ",,,,,,,";
  }
  fmt::format_to(out, ",{},{},{},{},{}", fix.arrivals_used, fix.arrivals_rejected, to_string(fix.status),
                 to_string(integrity(fix)), integrity_reason(fix));
  append_motion(text, fix);
  text += '\n';
}

}  // namespace

Result<std::vector<TimedPose>> tum_from_text(std::string_view text, const std::string& file,
                                             ContinuedClock* clock) {
  return TumReader(text, file, clock).read();
}

std::vector<OdometryStep> steps_between(const std::vector<TimedPose>& poses, VehicleId vehicle) {
  std::vector<OdometryStep> steps(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    steps[i].time_s = poses[i].time_s;
    steps[i].vehicle = vehicle;
    if (i > 0) steps[i].set_pose(poses[i - 1].T_map_vehicle.inverse() * poses[i].T_map_vehicle);
  }
  return steps;
}

std::string poses_to_tum(const std::vector<TimedPose>& poses) {
  std::string text = kTumHeader;
  for (const TimedPose& pose : poses) append_tum(text, pose.time_s, pose.T_map_vehicle);
  return text;
}

std::string fixes_to_tum(const std::vector<Fix>& fixes) {
  std::string text = kTumHeader;
  for (const Fix& fix : fixes) {
    if (fix.ok()) append_tum(text, fix.time_s, fix.T_map_vehicle);
  }
  return text;
}

std::string fixes_to_csv(const std::vector<Fix>& fixes, const NameTable& names) {
  std::string text =
      "time_s,vehicle,x_m,y_m,z_m,heading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad,protection_level_m,"
      "arrivals_used,"
      "arrivals_rejected,status,integrity,integrity_reason";
  for (const char* name : kVelocities) text += fmt::format(",{}", name);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i; j < 6; ++j)
      text += fmt::format(",covariance_{}_{}", kComponents[i], kComponents[j]);
  text += '\n';
  for (const Fix& fix : fixes) append_csv(text, fix, names);
  return text;
}

}  // namespace octant::io

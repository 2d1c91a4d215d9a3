// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/exchange/firmware.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <Eigen/QR>

#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/common/open_attitude.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/parameter.h"

namespace octant::app {
namespace {

constexpr double kFarFromOrigin_m = 1000.0;  ///< beyond it a float resolves less than a tenth of a millimetre
constexpr double kPolynomialReach_degC = 50.0;
constexpr int kPolynomial = 7;              ///< coefficients of the speed
constexpr std::size_t kMostNumbered = 255;  ///< numbers of beacons and receivers are bytes

/// Numbers as C source in the chosen precision.
class Source {
 public:
  explicit Source(bool single) : single_(single) {}
  [[nodiscard]] std::string number(double x) const {
    return single_ ? fmt::format("{:#.9g}f", x) : fmt::format("{:#.17g}", x);
  }
  template <class Range>
  [[nodiscard]] std::string list(const Range& numbers) const {
    std::string out = "{";
    for (const double x : numbers) out += (out.size() > 1 ? ", " : "") + number(x);
    return out + "}";
  }
  [[nodiscard]] bool single() const { return single_; }

 private:
  bool single_;
};

/// Rows of the joint covariance that the arrivals of one vehicle depend on, renumbered.
class Columns {
 public:
  explicit Columns(const JointCovariance& joint) : joint_(joint), at_(joint.parameters) {}
  int add(int row) {
    if (row < 0 || joint_.matrix.rows() == 0) return -1;
    const auto known = std::ranges::find(rows_, row);
    if (known != rows_.end()) return static_cast<int>(known - rows_.begin());
    rows_.push_back(row);
    return static_cast<int>(rows_.size()) - 1;
  }
  int add(const ParameterId& id) { return add(at_[id]); }
  std::string add(const std::array<int, 4>& rows) {
    return fmt::format("{{{}, {}, {}, {}}}", add(rows[0]), add(rows[1]), add(rows[2]), add(rows[3]));
  }
  [[nodiscard]] const ParameterIndex& at() const { return at_; }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] std::vector<double> lower_triangle() const {
    std::vector<double> out;
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) out.push_back(joint_.matrix(rows_[i], rows_[j]));
    out.push_back(0.0);  // C has no empty arrays
    return out;
  }

 private:
  const JointCovariance& joint_;
  ParameterIndex at_;
  std::vector<int> rows_;
};

/// Names as identifiers in C, each different.
class Identifiers {
 public:
  std::string operator()(const std::string& prefix, const std::string& name) {
    std::string id = prefix;
    for (const char c : name)
      id += std::isalnum(static_cast<unsigned char>(c)) != 0
                ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                : '_';
    while (!used_.insert(id).second) id += "_";
    return id;
  }

 private:
  std::set<std::string> used_;
};

/// Coefficients of the speed by the temperature, from Chebyshev nodes about that of the deployment, which is
/// met exactly.
std::array<double, kPolynomial> speed_polynomial(const Deployment& d) {
  Eigen::Matrix<double, kPolynomial, kPolynomial> A;
  Eigen::Matrix<double, kPolynomial, 1> speeds;
  for (int i = 0; i < kPolynomial; ++i) {
    const double x =
        2 * i + 1 == kPolynomial ? 0.0 : std::cos(std::numbers::pi * (2 * i + 1) / (2 * kPolynomial));
    for (int k = 0; k < kPolynomial; ++k) A(i, k) = std::pow(x, k);
    speeds[i] = d.speed_mps(d.medium.temperature_degC + kPolynomialReach_degC * x);
  }
  const Eigen::Matrix<double, kPolynomial, 1> solved = A.colPivHouseholderQr().solve(speeds);
  std::array<double, kPolynomial> out{};
  std::copy_n(solved.data(), kPolynomial, out.begin());
  out[0] = d.speed_mps(d.medium.temperature_degC);
  return out;
}

Eigen::Vector3d origin_of(const Deployment& d, bool single) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double largest = 0.0;
  for (const DeploymentBeacon& b : d.beacons) {
    sum += b.position_m;
    largest = std::max(largest, b.position_m.cwiseAbs().maxCoeff());
  }
  Eigen::Vector3d origin =
      (sum / std::max<double>(static_cast<double>(d.beacons.size()), 1.0)).array().round();
  if (!single || largest < kFarFromOrigin_m) origin.setZero();
  if (d.motion == Motion::kPlanar) origin.z() = 0.0;  // planar vehicles are at height 0
  return origin;
}

std::string beacon_row(const Deployment& d, const EpochFixModel& model, std::size_t b,
                       const Eigen::Vector3d& origin, Columns& columns, const Source& source) {
  const DeploymentBeacon& beacon = d.beacons[b];
  const bool usable = beacon.status != BeaconStatus::kUndetermined;
  std::vector<double> covariance;
  for (int i = 0; i < 5; ++i)
    for (int j = i; j < 5; ++j) covariance.push_back(model.beacon_covariance[b](i, j));
  const Eigen::Vector3d p = usable ? Eigen::Vector3d(beacon.position_m - origin) : Eigen::Vector3d::Zero();
  return fmt::format("    {{{}, {}, {},\n     {},\n     {}, {}}},\n", source.list(p),
                     source.number(beacon.delay_s),
                     source.number(d.attenuation ? std::log(beacon.gain) : 0.0), source.list(covariance),
                     columns.add(columns.at().beacon(b)), usable ? 1 : 0);
}

std::string receiver_row(const Deployment& d, const EpochFixModel& model, std::size_t r,
                         const Eigen::Vector3d& centre, Columns& columns, const Source& source) {
  constexpr double kHearingMargin = 0.1;  // of models/localizers/least_squares/consensus.cc
  const DeploymentReceiver& receiver = d.receivers[r];
  const Eigen::Vector3d axis = receiver.axis.value_or(Eigen::Vector3d::Zero());
  const double limit = model.hearing_cosine[r] - kHearingMargin;
  return fmt::format("    {{{}, {}, {}, {}, {}, {}}},\n", source.list(receiver.position_m),
                     source.number(receiver.delay_s), source.list(axis),
                     source.number(limit * std::abs(limit)),
                     source.number(open_attitude_variance_m2(receiver.position_m - centre)),
                     columns.add(columns.at().receiver(r)));
}

/// Text for a comment of C: other characters than those of names and dates are replaced.
std::string in_comment(std::string text) {
  constexpr std::string_view kHarmless = " _.:+-";
  for (char& c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && kHarmless.find(c) == std::string_view::npos)
      c = '?';
  return text;
}

std::string header(const Deployment& d, const SiteVehicle& vehicle, std::size_t parameters, bool axes,
                   const Source& source) {
  Identifiers identifiers;
  std::string out =
      fmt::format("/* Dimensions of the deployment of site {}, by octant export --c. */\n#pragma once\n",
                  in_comment(d.site));
  if (source.single()) out += "#define OCTF_FLOAT\n";
  out += fmt::format(
      "#define OCTF_SPATIAL {}\n#define OCTF_BEACONS {}\n#define OCTF_RECEIVERS {}\n"
      "#define OCTF_PARAMETERS {}\n#define OCTF_ATTENUATION {}\n#define OCTF_DIRECTIONAL {}\n"
      "#define OCTF_AXES {}\n",
      d.motion == Motion::kSpatial ? 1 : 0, d.beacons.size(), vehicle.receiver_count, parameters,
      d.attenuation ? 1 : 0, d.attenuation && d.attenuation->directional() ? 1 : 0, axes ? 1 : 0);
  out += "\n/* Numbers of beacons and receivers. */\nenum {\n";
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    out += fmt::format("  {} = {},\n", identifiers("OCTF_BEACON_", d.beacons[b].name), b);
  for (std::size_t r = 0; r < vehicle.receiver_count; ++r)
    out += fmt::format("  {} = {},\n",
                       identifiers("OCTF_RECEIVER_", d.receivers[vehicle.first_receiver + r].name), r);
  return out + "};\n";
}

/// Text without its licence comment, which octant_fix.c has once.
std::string_view without_licence(std::string_view text) {
  constexpr std::string_view kFirst = " * SPDX-License-Identifier: Apache-2.0\n";
  return text.substr(text.find(kFirst) + kFirst.size());
}

std::string joined_source() {
  std::string out =
      "/* SPDX-FileCopyrightText: 2026 Octant developers\n * SPDX-License-Identifier: Apache-2.0\n"
      " * Generated by octant export --c from apps/firmware; the names in comments are those of Octant. */\n";
  for (const std::string_view part :
       {firmware_model(), firmware_adjust(), firmware_protect(), firmware_consensus(), firmware_start_plane(),
        firmware_start_space(), firmware_fix(), firmware_filter()})
    out.append("\n/*\n").append(without_licence(part));
  return out;
}

Result<std::size_t> vehicle_of(const Deployment& d, const std::string& name) {
  std::string known;
  for (std::size_t v = 0; v < d.vehicles.size(); ++v) {
    if (d.vehicles[v].name == name || (name.empty() && d.vehicles.size() == 1)) return v;
    known += (v > 0 ? ", " : "") + d.vehicles[v].name;
  }
  return fail({.code = Errc::kUsage,
               .found = name.empty() ? "a deployment with several vehicles" : "--vehicle " + name,
               .expected = "the vehicle that the firmware is for, one of " + known,
               .advice = "add --vehicle NAME"});
}

Result<void> check_covered(const Deployment& d, const SiteVehicle& vehicle) {
  const auto not_covered = [](const std::string& found, const std::string& expected) {
    return fail({.code = Errc::kUsage, .found = found, .expected = expected});
  };
  if (d.timing.clock == Clock::kCycleOffset)
    return not_covered("a clock with an offset in each cycle",
                       "synchronised clocks, which the firmware edition needs");
  if (d.medium.profile)
    return not_covered("a profile of the speed of sound", "one speed, which the firmware edition needs");
  if (vehicle.receiver_count == 0)
    return not_covered("a vehicle without receivers", "a vehicle that receives beacons");
  if (d.beacons.empty() || std::max(d.beacons.size(), vehicle.receiver_count) > kMostNumbered)
    return not_covered(fmt::format("{} beacons and {} receivers", d.beacons.size(), vehicle.receiver_count),
                       fmt::format("1 to {} of each", kMostNumbered));
  return {};
}

}  // namespace

Result<std::vector<FirmwareFile>> firmware_files(const Deployment& d, const FirmwareOptions& options) {
  const auto number = vehicle_of(d, options.vehicle);
  if (!number) return tl::unexpected(number.error());
  const SiteVehicle& vehicle = d.vehicles[*number];
  if (const auto covered = check_covered(d, vehicle); !covered) return tl::unexpected(covered.error());
  const Source source(options.single_precision);
  const EpochFixModel model = epoch_fix_model(d);
  const Eigen::Vector3d origin = origin_of(d, options.single_precision),
                        centre = receiver_centre_m(d, VehicleId(*number));
  Columns columns(d.covariance);
  std::string beacons, receivers, amplitudes;
  bool axes = false;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    beacons += beacon_row(d, model, b, origin, columns, source);
  for (std::size_t r = vehicle.first_receiver; r < vehicle.first_receiver + vehicle.receiver_count; ++r) {
    receivers += receiver_row(d, model, r, centre, columns, source);
    axes = axes || d.receivers[r].axis.has_value();
  }
  const int delay = columns.add(parameters::site_delay()), speed = columns.add(parameters::speed());
  for (std::size_t i = 0; i < kAttenuationUnknowns; ++i)
    amplitudes +=
        fmt::format("{}{}", i > 0 ? ", " : "", d.attenuation ? columns.add(parameters::attenuation(i)) : -1);
  const CorrelatedNoise correlated = correlated_noise(d);
  const AttenuationModel a = d.attenuation.value_or(AttenuationModel{});
  const double temperature = d.medium.temperature_degC;
  const std::string table = fmt::format(
      "/* Deployment {} of {}, by octant export --c. */\n#include \"octant_fix.h\"\n\n"
      "const octf_site octf_site_table = {{\n    {{{:#.17g}, {:#.17g}, {:#.17g}}}, {:#.17g}, {},\n    {},\n"
      "    {}, {}, {},\n    {}, {}, {}, {}, {},\n    {{\n{}    }},\n    {{\n{}    }},\n    {}, {}, {{{}}},\n "
      "   {}}};\n",
      in_comment(d.digest), in_comment(d.created), origin.x(), origin.y(), origin.z(), d.timing.turnaround_s,
      source.number(d.timing.legs()), source.list(speed_polynomial(d)), source.number(temperature),
      source.number(temperature - kPolynomialReach_degC), source.number(temperature + kPolynomialReach_degC),
      source.number(single_arrival_sigma_s(d)),
      source.number(std::pow(correlated.sigma_s, 2) + std::pow(correlated.pair_sigma_s, 2)),
      source.number(correlated.any() ? 1.0 : 0.0),
      source.list(std::array{a.amplitude_1m_v, a.absorption_np_per_m, a.rise_time_s, a.half_power_angle_rad,
                             a.threshold_v}),
      source.list(centre), beacons, receivers, delay, speed, amplitudes,
      source.list(columns.lower_triangle()));
  return std::vector<FirmwareFile>{{"octant_fix.h", std::string(firmware_header())},
                                   {"octant_fix.c", joined_source()},
                                   {"octant_site.h", header(d, vehicle, columns.size(), axes, source)},
                                   {"octant_site.c", table}};
}

}  // namespace octant::app

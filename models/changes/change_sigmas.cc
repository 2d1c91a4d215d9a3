// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/change_sigmas.h"

#include <cmath>
#include <cstddef>
#include <optional>

namespace octant {
namespace {

/// Visitor: see visit_parameter.
struct SigmaOf : HasNothing<double> {
  const ChangeSigmas& sigmas;
  explicit SigmaOf(const ChangeSigmas& of) : sigmas(of) {}
  [[nodiscard]] double beacon_position(std::size_t, std::size_t) const { return sigmas.beacon_m; }
  [[nodiscard]] double beacon_delay(std::size_t) const { return sigmas.delay_s; }
  [[nodiscard]] double beacon_gain(std::size_t) const { return sigmas.log_gain; }
  [[nodiscard]] double receiver_position(std::size_t, std::size_t) const { return sigmas.receiver_m; }
  [[nodiscard]] double speed(std::size_t) const { return sigmas.speed_mps; }
};

/// Differences between two visits of one day, and standard deviations a year.
struct DriftOfKind {
  double beacon_m[2], delay_m[2], receiver_m[2], speed_mps[2];
};

DriftOfKind drift_of_kind(MediumKind kind) {
  switch (kind) {
    case MediumKind::kAir: return {{1e-3, 1.2e-3}, {1e-3, 1.2e-3}, {5e-4, 6e-4}, {0.3, 0.36}};
    case MediumKind::kWater: return {{0.02, 0.1}, {0.01, 0.02}, {5e-3, 5e-3}, {0.5, 0.5}};
    case MediumKind::kRadio: break;
  }
  return {{5e-3, 5e-3}, {0.02, 0.03}, {2e-3, 2e-3}, {0.3, 0.36}};
}

}  // namespace

double ChangeSigmas::of(const ParameterId& parameter) const {
  return visit_parameter(parameter, SigmaOf(*this));
}

MediumKind medium_kind(double speed_mps) {
  constexpr double kFastestGas_mps = 1.0e3, kFastestSound_mps = 1.0e5;
  return speed_mps < kFastestGas_mps     ? MediumKind::kAir
         : speed_mps < kFastestSound_mps ? MediumKind::kWater
                                         : MediumKind::kRadio;
}

ChangeSigmas usual_changes(double speed_mps) {
  switch (medium_kind(speed_mps)) {
    case MediumKind::kAir: return {0.3, 0.17 / speed_mps, 0.03, 10.0, 1.0};
    case MediumKind::kWater: return {3.0, 1.0 / speed_mps, 0.1, 10.0, 1.0};
    case MediumKind::kRadio: break;
  }
  return {1.0, 0.5 / speed_mps, 0.1, 10.0, 1.0};
}

ChangeSigmas released_sigmas(double speed_mps) {
  const double beacon_m = medium_kind(speed_mps) == MediumKind::kWater ? 100.0 : 10.0;
  return {beacon_m, 10.0 / speed_mps, 1.0, 30.0, 3.0};
}

Drift drift_after(double months, const DriftRates& rates, double speed_mps) {
  constexpr double kGainAYear = 0.06;
  const DriftOfKind kind = drift_of_kind(medium_kind(speed_mps));
  const double years = months > 0 ? months / 12.0 : 0.0;
  const auto total = [years](double at_once, double a_year) { return std::hypot(at_once, years * a_year); };
  const auto of = [&total](const double(&drift)[2], std::optional<double> rate) {
    return total(drift[0], rate.value_or(drift[1]));
  };
  const Drift gain;
  return {of(kind.beacon_m, rates.beacon_m_per_year),
          of(kind.delay_m, rates.delay_m_per_year) / speed_mps,
          of(kind.receiver_m, rates.receiver_m_per_year),
          of(kind.speed_mps, rates.speed_mps_per_year),
          total(gain.log_gain, kGainAYear),
          total(gain.attenuation, kGainAYear)};
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "models/physics/speed_profile.h"

namespace octant {

enum class MediumModel { kConstant, kLinearTemperature, kCramer1993 };

/// Medium of propagation: model of the speed and reference state.
struct Medium {
  MediumModel model = MediumModel::kConstant;
  double speed_mps = 343.0;        ///< kConstant only
  double temperature_degC = 20.0;  ///< reference temperature; a run or an arrival may state its own
  double relative_humidity = 0.5;  ///< 0..1, kCramer1993
  double pressure_pa = 101325.0;   ///< kCramer1993
  /// Speed by height, kConstant only; each arrival then has the speed of its ray. Null: the same everywhere.
  std::shared_ptr<const SpeedProfile> profile = nullptr;
};

/// Speed of propagation at a temperature. kConstant: speed_mps. kLinearTemperature: 331.3 + 0.606 T (Chang,
/// eq. 2). kCramer1993: O. Cramer, J. Acoust. Soc. Am. 93 (1993) 2510, eq. 15, with 400 ppm of CO2; stated
/// uncertainty below 300 ppm for 0-30 degC and 75-102 kPa.
/// @param temperature_degC degrees Celsius  @return m/s
[[nodiscard]] double speed_mps(const Medium& medium, double temperature_degC);
[[nodiscard]] inline double speed_mps(const Medium& medium) {
  return speed_mps(medium, medium.temperature_degC);
}

/// Air temperature at which the model yields a given speed, by bisection to 1e-9 degC.
/// @return degrees Celsius; no value outside -60 to 60 degC, or if the speed does not depend on the
/// temperature
[[nodiscard]] std::optional<double> temperature_at(const Medium& medium, double wanted_mps);

[[nodiscard]] std::string_view to_string(MediumModel model);

/// Absorption of sound in air, ISO 9613-1:1993. Check: 20 degC, 50 %, 101325 Pa, 40 kHz: 1.318 dB/m.
/// @return Np/m (1 Np = 8.686 dB)
[[nodiscard]] double air_absorption_np_per_m(double frequency_hz, double temperature_degC,
                                             double relative_humidity, double pressure_pa);

}  // namespace octant

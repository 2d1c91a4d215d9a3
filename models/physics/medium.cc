// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/medium.h"

#include <cmath>

#include "models/support/enum_names.h"

namespace octant {
namespace {

/// Cramer 1993, eq. 15, with his enhancement factor and saturation vapour pressure (eq. A1-A3).
double cramer_mps(double t, double relative_humidity, double p) {
  constexpr double a[16] = {331.5024,  0.603055,  -0.000528, 51.471935, 0.1495874, -0.000782,
                            -1.82e-7,  3.73e-8,   -2.93e-10, -85.20931, -0.228525, 5.91e-5,
                            -2.835149, -2.15e-13, 29.179762, 0.000486};
  constexpr double xc = 4e-4;  // mole fraction of CO2
  const double kelvin = t + 273.15;
  const double enhancement = 1.00062 + 3.14e-8 * p + 5.6e-7 * t * t;
  // Saturation vapour pressure of the CIPM formula for the density of moist air (Giacomo 1982, constants of
  // Davis 1992).
  const double saturation_pa =
      std::exp(1.2378847e-5 * kelvin * kelvin - 1.9121316e-2 * kelvin + 33.93711047 - 6343.1645 / kelvin);
  const double xw = relative_humidity * enhancement * saturation_pa / p;
  return a[0] + a[1] * t + a[2] * t * t + (a[3] + a[4] * t + a[5] * t * t) * xw +
         (a[6] + a[7] * t + a[8] * t * t) * p + (a[9] + a[10] * t + a[11] * t * t) * xc + a[12] * xw * xw +
         a[13] * p * p + a[14] * xc * xc + a[15] * xw * p * xc;
}

}  // namespace

double speed_mps(const Medium& medium, double temperature_degC) {
  switch (medium.model) {
    case MediumModel::kConstant: return medium.speed_mps;
    case MediumModel::kLinearTemperature: return 331.3 + 0.606 * temperature_degC;
    case MediumModel::kCramer1993:
      return cramer_mps(temperature_degC, medium.relative_humidity, medium.pressure_pa);
  }
  return medium.speed_mps;
}

std::optional<double> temperature_at(const Medium& medium, double wanted_mps) {
  double low = -60.0, high = 60.0;
  if (!(speed_mps(medium, low) < wanted_mps && wanted_mps < speed_mps(medium, high))) return {};
  for (int i = 0; i < 40; ++i)
    (speed_mps(medium, 0.5 * (low + high)) < wanted_mps ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

std::string_view to_string(MediumModel model) {
  static constexpr auto kNames = enum_names<MediumModel>("constant", "linear_temperature", "cramer1993");
  return kNames[model];
}

double air_absorption_np_per_m(double frequency_hz, double temperature_degC, double relative_humidity,
                               double pressure_pa) {
  // ISO 9613-1:1993, eq. 3-5 and annex B; reference 20 degC, 101.325 kPa, triple point of water 273.16 K.
  const double kelvin = temperature_degC + 273.15;
  const double p = pressure_pa / 101325.0;
  const double t = kelvin / 293.15;
  const double saturation = std::pow(10.0, -6.8346 * std::pow(273.16 / kelvin, 1.261) + 4.6151);
  const double h =
      100.0 * relative_humidity * saturation / p;  // molar concentration of water vapour, percent
  const double relax_o2 = p * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
  const double relax_n2 =
      p / std::sqrt(t) * (9.0 + 280.0 * h * std::exp(-4.170 * (std::pow(t, -1.0 / 3.0) - 1.0)));
  const double f2 = frequency_hz * frequency_hz;
  // The bracket of the standard times f^2 is in Np/m; its factor 8.686 converts to decibels.
  return f2 * (1.84e-11 / p * std::sqrt(t) +
               std::pow(t, -2.5) * (0.01275 * std::exp(-2239.1 / kelvin) / (relax_o2 + f2 / relax_o2) +
                                    0.1068 * std::exp(-3352.0 / kelvin) / (relax_n2 + f2 / relax_n2)));
}

}  // namespace octant

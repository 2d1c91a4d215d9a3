// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/deployment.h"
#include "survey/trend/trend.h"

namespace octant::survey {

/// Result of one calibration of a site.
struct CalibrationRecord {
  double time_s = 0.0;
  std::vector<DeploymentBeacon> beacons;  ///< only the diagonal of the covariance is used
  double speed_mps = 0.0;                 ///< at temperature_degC
  double speed_sigma_mps = 0.0;           ///< 0: fixed
  double speed_offset_mps = 0.0;          ///< from the medium's model at that temperature
  double temperature_degC = 0.0;
};

enum class TrendQuantity { kX, kY, kZ, kDelay, kSpeedOffset };
[[nodiscard]] const char* to_string(
    TrendQuantity quantity);  ///< "x_m", "y_m", "z_m", "delay_s", "speed_offset_mps"

struct QuantityTrend {
  std::string subject;  ///< the beacon; "medium" for the speed
  TrendQuantity quantity = TrendQuantity::kX;
  ControlChart chart;
  double limit = 0.0;  ///< largest change that may be, of the quantity's unit
  std::optional<Forecast> forecast;
};

struct SiteTrend {
  std::vector<QuantityTrend> quantities;
  double cusum_h = 0.0;        ///< decision limit of all charts
  double visits_an_alarm = 0;  ///< mean number of visits between false alarms, of all charts together
  /// The quantity whose drift makes the next recalibration due first, and the one that may do so first;
  /// indices into quantities.
  std::optional<std::size_t> due, earliest;
};

struct TrendOptions {
  double limit_m =
      0.05;  ///< largest error of a range by a drift; the limits of a delay and of the speed follow from it
  double visits_an_alarm = 100.0;
  double cusum_k = 0.5;  ///< in sigmas of a calibration: shifts of twice this are found fastest
};

/// Control charts of all coordinates and delays of a site's beacons and of the speed's offset from its model.
/// The threshold makes a false alarm in any of them as rare as stated. Quantities that are always fixed at
/// one value have no chart. Calibrations are assumed to be independent. If one was the prior of the next,
/// deviations are smaller than they should be, and alarms are later.
[[nodiscard]] SiteTrend site_trend(const std::vector<CalibrationRecord>& records,
                                   const TrendOptions& options = {});

}  // namespace octant::survey

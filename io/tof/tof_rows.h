// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the content of a row of tof.csv, and the general method of reading one. It handles all
// unusual forms and describes errors.

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/text/csv.h"
#include "io/tof/order_watch.h"
#include "io/tof/run_parts.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/largest.h"

namespace octant::io {

/// Conversion of distances to times of flight: tof_s = per_m_s distance_m + offset_s. Zero: the speed is not
/// known.
struct DistanceAsTime {
  double per_m_s = 0.0, offset_s = 0.0;
};

/// Columns of tof.csv by name, -1 if missing.
struct TofColumns {
  int time, beacon;
  bool distance;  ///< `tof` is distance_m, in metres
  int tof, epoch, vehicle, receiver, amplitude, level, temperature, received;
  TofColumns(CsvReader& csv, const DistanceAsTime& distance);
};

/// Amplitude [V]; NaN if the logged value is not positive and finite.
[[nodiscard]] inline double usable_amplitude(double amplitude_v) {
  return amplitude_v > 0.0 && !std::isinf(amplitude_v) ? amplitude_v
                                                       : std::numeric_limits<double>::quiet_NaN();
}
/// Effective voltage of a power into 50 ohm: V = sqrt(R P), P = 1 mW 10^(dBm / 10).
[[nodiscard]] double amplitude_of_level(double level_dbm);
/// Time from an instant until its reception; NaN if the latter is not finite.
[[nodiscard]] inline float reception_delay_s(double time_s, double received_s) {
  const auto delay_s = static_cast<float>(received_s - time_s);
  return std::isfinite(delay_s) ? delay_s : std::numeric_limits<float>::quiet_NaN();
}
/// NaN: not logged.
[[nodiscard]] inline bool is_temperature(double temperature_degC) {
  return std::isnan(temperature_degC) || std::abs(temperature_degC) <= 100.0;
}

/// Reason why a row is not a measurement.
enum class Refusal { kNone, kEmpty, kNotANumber, kNotPositive, kTooLarge, kRepeated };
/// Negative times are legal where the receiver's clock has an unknown offset.
[[nodiscard]] inline Refusal refusal_of(std::string_view text, double tof_s, Clock clock) {
  if (text.empty()) return Refusal::kEmpty;
  if (!std::isfinite(tof_s)) return Refusal::kNotANumber;
  if (std::abs(tof_s) > kLargestTof_s) return Refusal::kTooLarge;
  return tof_s > 0.0 || clock == Clock::kCycleOffset ? Refusal::kNone : Refusal::kNotPositive;
}

/// Rows that are no measurement of their own, each with its reason, and one warning for each reason.
class TofRefusals {
 public:
  void add(Refusal refusal, int line, std::string_view text);
  /// Refused rows since the last call, by line: repeated rows are found after the others of their piece.
  [[nodiscard]] std::vector<RejectedRow> take();
  void warn(const std::string& file, std::vector<std::string>& warnings) const;

 private:
  struct CountOfKind {
    int first_line = 0;
    std::string first_text;
    std::size_t count = 0;
  };
  std::vector<RejectedRow> rows_;
  std::array<CountOfKind, 6> counts_;
};

/// Reads the current row; false after logging an error.
bool read_tof_row(CsvReader& csv, const TofColumns& columns, const NameLookup& names, OrderWatch& order,
                  Arrival& arrival);

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/localizers/common/counter_times.h"
#include "models/localizers/kleeman/kleeman_sync.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

// Logs of other programs and devices, as `octant convert` makes run folders of them.
namespace octant::io {

/// True if one of the first lines is a message of a CARMEN log.
[[nodiscard]] bool is_carmen_log(const std::string& path);
/// Reads a CARMEN log (text): laser scans of FLASER and ROBOTLASER1 lines, odometry of ODOM lines and of the
/// scans. Other messages are skipped and listed in the warnings. Times are those of the logger, the last
/// number of a line. Lines with an earlier time than one before are left out and counted in a warning. FLASER
/// does not state its angles: the field of view is 180 degrees ahead, in steps of 180 degrees over the number
/// of beams (180, 360), or over one less (181, 361). Ranges of 80 m and more are beams without a return.
/// Errors: kBadInput with line and expected content.
[[nodiscard]] Result<MeasurementLog> read_carmen_log(const std::string& path);

/// Counter values of a counter card, CSV: time_s, beacon, counts; optional epoch, vehicle, receiver. Rows of
/// the same epoch (without epochs: of the same time) keep their order.
[[nodiscard]] Result<std::vector<CounterReading>> read_counter_log(const std::string& path,
                                                                   const NameTable& names);

/// Pulses of threshold detectors, CSV: time_s, channel, duration_s, amplitude_v; channels count from 0, time
/// does not decrease by more than a pulse.
[[nodiscard]] Result<std::vector<PulseArrival>> read_pulse_log(const std::string& path);

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "survey/report/report.h"

namespace octant::survey {

[[nodiscard]] DeploymentBeacon test_beacon(const std::string& name, double x_m, double y_m, double sigma_m,
                                           BeaconStatus status);
/// Three beacons on 10 x 8 m, all sections of a report filled.
[[nodiscard]] ReportInput full_report();
/// A report in which every text from people or files is replaced.
[[nodiscard]] ReportInput report_full_of(const std::string& text);

}  // namespace octant::survey

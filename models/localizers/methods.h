// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/kleeman/kleeman_heading.h"
#include "models/localizers/line_map/line_map_localizer.h"
#include "models/run.h"
#include "models/support/result.h"

namespace octant {

/// The ways of finding a vehicle, by the names of the command line.
enum class Method {
  kAuto,
  kKleeman,
  kHeadTail,
  kOneBeacon,
  kRail,
  kReflectors,
  kLineMap,
  kBinaural,
  kLeastSquares,
  kTracker
};
[[nodiscard]] const char* to_string(Method method);
/// All of them in the order of the enumeration.
[[nodiscard]] const std::vector<std::pair<std::string_view, Method>>& method_names();

/// Why fixes of a method have no protection level; empty where they have one as soon as there is a beacon to
/// spare.
[[nodiscard]] const char* why_no_level(Method method);

/// What a method may be given beside deployment and run.
struct MethodInput {
  std::optional<LineMap> line_map{};  ///< Method::kLineMap
  KleemanHeading kleeman_heading = KleemanHeading::kInterpolation;
};

/// Whether a method can work on a run of a site; the error says what is missing.
[[nodiscard]] Result<void> method_fits(Method method, const Deployment& deployment, const MeasurementLog& run,
                                       const MethodInput& input = {});

/// A localizer of single poses by arrivals or bearings; none for kAuto, kLineMap and kTracker. The deployment
/// fits (method_fits).
[[nodiscard]] std::unique_ptr<Localizer> make_localizer(Method method, const Deployment& deployment,
                                                        const MethodInput& input = {});

/// What Method::kAuto stands for on a run, and why in a few words: the most exact method that deployment and
/// log allow.
struct MethodChoice {
  Method method = Method::kLeastSquares;
  const char* why = "";
};
[[nodiscard]] MethodChoice choose_method(const Deployment& deployment, const MeasurementLog& run,
                                         const MethodInput& input = {});

/// All fixes of a run, in the order of time, those without a pose included with their reason. Localizers of
/// single poses get epoch by epoch; without epochs, what arrives within five milliseconds of each other.
/// Rows whose beacon or receiver is none of the deployment's take no part.
/// Errors: those of method_fits.
[[nodiscard]] Result<std::vector<Fix>> locate_run(Method method, const Deployment& deployment,
                                                  const MeasurementLog& all_rows,
                                                  const MethodInput& input = {});

}  // namespace octant

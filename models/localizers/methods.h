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

/// Localization methods, with the names that the command line uses.
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
/// All methods in the order of the enumeration.
[[nodiscard]] const std::vector<std::pair<std::string_view, Method>>& method_names();

/// Reason for which fixes of a method have no protection level. Empty for methods that compute one whenever
/// there is a redundant beacon.
[[nodiscard]] const char* why_no_level(Method method);

/// Inputs of a method besides deployment and run.
struct MethodInput {
  std::optional<LineMap> line_map{};  ///< required by Method::kLineMap
  KleemanHeading kleeman_heading = KleemanHeading::kInterpolation;
};

/// Checks that a method can process a run of a site. The error states what is missing.
[[nodiscard]] Result<void> method_fits(Method method, const Deployment& deployment, const MeasurementLog& run,
                                       const MethodInput& input = {});

/// Creates a localizer of single poses from arrivals or bearings. Null for kAuto, kLineMap and kTracker. The
/// deployment must pass method_fits().
[[nodiscard]] std::unique_ptr<Localizer> make_localizer(Method method, const Deployment& deployment,
                                                        const MethodInput& input = {});

/// Method that Method::kAuto selects for a run, with the reason in a few words. It is the most accurate
/// method that deployment and log allow.
struct MethodChoice {
  Method method = Method::kLeastSquares;
  const char* why = "";
};
[[nodiscard]] MethodChoice choose_method(const Deployment& deployment, const MeasurementLog& run,
                                         const MethodInput& input = {});

/// All fixes of a run in order of time, including those without a pose. Localizers of single poses process
/// one epoch at a time; without epochs, the arrivals within five milliseconds of each other. Rows whose
/// beacon or receiver is not part of the deployment are ignored. Errors are those of method_fits.
[[nodiscard]] Result<std::vector<Fix>> locate_run(Method method, const Deployment& deployment,
                                                  const MeasurementLog& all_rows,
                                                  const MethodInput& input = {});

}  // namespace octant

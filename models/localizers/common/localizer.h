// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "models/fix.h"
#include "models/run.h"

namespace octant {

/// What one pose of one vehicle is fixed from: the arrivals and bearings of an epoch, in the order of the
/// run.
struct Observations {
  std::span<const Arrival> arrivals;
  std::span<const Bearing> bearings;
};

/// Makes a fix a new one without giving its memory back.
inline void clear(Fix& fix) {
  std::vector<Rejection> rejections = std::move(fix.rejections);
  rejections.clear();
  fix = Fix{};
  fix.rejections = std::move(rejections);
}

/// A way of finding a vehicle, constructed from a `Deployment`. All memory is taken at construction: a call
/// allocates nothing once `fix` has held a fix of as many arrivals, throws nothing, and ends in bounded time.
/// What cannot be fixed is a fix with the reason in its status, never NaN.
class Localizer {
 public:
  virtual ~Localizer() = default;

  /// Overwrites `fix`, reusing its memory; `fix.rejections` gets one entry an arrival (an entry a bearing
  /// where the method takes bearings alone). Methods that keep a state (where the vehicle was) update it only
  /// when the fix is kOk.
  virtual void locate(const Observations& observations, Fix& fix) noexcept = 0;

  [[nodiscard]] Fix locate(const Observations& observations) {
    Fix fix;
    locate(observations, fix);
    return fix;
  }

 protected:
  Localizer() = default;
  Localizer(const Localizer&) = default;
  Localizer& operator=(const Localizer&) = default;
};

}  // namespace octant

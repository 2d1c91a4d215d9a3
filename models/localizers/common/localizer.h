// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/support/result.h"

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

/// Sets instant (the middle row's), vehicle and epoch of a fix from the arrivals or bearings given, and all
/// else as if nothing were known.
template <class Row>
void begin_fix(std::span<const Row> rows, Fix& fix) {
  clear(fix);
  if (rows.empty()) return;
  fix.vehicle = rows.front().vehicle;
  fix.epoch = rows.front().epoch;
  fix.time_s = rows[rows.size() / 2].time_s;
}

/// Counts what a fix's rejections leave in use.
inline void count_rejections(Fix& fix) {
  fix.arrivals_used = static_cast<int>(std::ranges::count(fix.rejections, Rejection::kUsed));
  fix.arrivals_rejected = static_cast<int>(fix.rejections.size()) - fix.arrivals_used;
}

/// A way of finding a vehicle, constructed from a `Deployment`. All memory is taken at construction: a call
/// allocates nothing once `fix` has held a fix of as many arrivals, throws nothing, and ends in bounded time.
/// What cannot be fixed is a fix with the reason in its status, never NaN. Ids and times of flight may be
/// any: what is none of the deployment's, and what is beyond kLargestTof_s, is left out before a method sees
/// it (Rejection::kUnknownId, kOutOfRange; room for it may then be taken).
class Localizer {
 public:
  virtual ~Localizer() = default;

  /// Overwrites `fix`, reusing its memory; `fix.rejections` gets one entry an arrival (an entry a bearing
  /// where the method takes bearings alone). Methods that keep a state (where the vehicle was) update it only
  /// when the fix is kOk.
  void locate(const Observations& observations, Fix& fix) noexcept;

  [[nodiscard]] Fix locate(const Observations& observations) {
    Fix fix;
    locate(observations, fix);
    return fix;
  }

 protected:
  /// Which observations `fix.rejections` has an entry for.
  enum class RejectionsOf { kArrivals, kBearings };
  explicit Localizer(const Deployment& deployment, RejectionsOf rejections_of = RejectionsOf::kArrivals)
      : beacons_(deployment.beacons.size()),
        receivers_(deployment.receivers.size()),
        rejections_of_(rejections_of) {}
  Localizer(const Localizer&) = default;
  Localizer& operator=(const Localizer&) = default;

 private:
  /// The method: every beacon, receiver and labelled reflector is the deployment's.
  virtual void locate_known(const Observations& observations, Fix& fix) noexcept = 0;
  [[nodiscard]] bool knows(const Arrival& arrival) const noexcept;
  [[nodiscard]] bool knows(const Bearing& bearing) const noexcept;

  std::size_t beacons_, receivers_;
  RejectionsOf rejections_of_;
  std::vector<Arrival> known_arrivals_;
  std::vector<Bearing> known_bearings_;
};

/// Beacons of a deployment that localizers use.
[[nodiscard]] std::size_t usable_beacons(const Deployment& deployment);

/// Why a method does not fit a deployment, in words that begin with its name.
class MisfitOf {
 public:
  explicit MisfitOf(const char* method) : method_(method) {}
  [[nodiscard]] tl::unexpected<Error> operator()(const std::string& found, std::string expected) const;
  /// The misfit of a method that needs motion in the plane and synchronised clocks, if there is one.
  [[nodiscard]] Result<void> in_the_plane(const Deployment& deployment) const;

 private:
  const char* method_;
};

/// The rows of a log whose beacons and receivers are the deployment's and whose times are possible: the log
/// itself, or what is left of it, in `room`.
[[nodiscard]] const MeasurementLog& known_rows(const MeasurementLog& log, const Deployment& deployment,
                                               MeasurementLog& room);

}  // namespace octant

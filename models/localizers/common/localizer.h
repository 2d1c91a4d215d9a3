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

/// Observations that one pose of one vehicle is computed from: arrivals and bearings of an epoch, in the
/// order of the run.
struct Observations {
  std::span<const Arrival> arrivals;
  std::span<const Bearing> bearings;
};

/// Resets a fix and keeps its allocated memory.
inline void clear(Fix& fix) {
  std::vector<Rejection> rejections = std::move(fix.rejections);
  rejections.clear();
  fix = Fix{};
  fix.rejections = std::move(rejections);
}

/// Sets time (of the middle row), vehicle and epoch of a fix from the given arrivals or bearings, and resets
/// everything else.
template <class Row>
void begin_fix(std::span<const Row> rows, Fix& fix) {
  clear(fix);
  if (rows.empty()) return;
  fix.vehicle = rows.front().vehicle;
  fix.epoch = rows.front().epoch;
  fix.time_s = rows[rows.size() / 2].time_s;
}

/// Counts the used and rejected observations of a fix.
inline void count_rejections(Fix& fix) {
  fix.arrivals_used = static_cast<int>(std::ranges::count(fix.rejections, Rejection::kUsed));
  fix.arrivals_rejected = static_cast<int>(fix.rejections.size()) - fix.arrivals_used;
}

/// Interface of the localization methods, constructed from a `Deployment`. All memory is allocated at
/// construction. A call does not allocate if `fix` has been used for as many arrivals before. It does not
/// throw and its time is bounded. Without a pose, the fix has the reason in its status; it is never NaN. Ids
/// and times of flight may have any value: rows with ids outside the deployment, or times beyond
/// kLargestTof_s, are removed before the method runs (Rejection::kUnknownId, kOutOfRange). This case may
/// allocate.
class Localizer {
 public:
  virtual ~Localizer() = default;

  /// Overwrites `fix` and reuses its memory. `fix.rejections` gets one entry for each arrival, or for each
  /// bearing if the method uses bearings only. Methods with a state, such as the previous position, update it
  /// only when the fix is kOk.
  void locate(const Observations& observations, Fix& fix) noexcept;

  [[nodiscard]] Fix locate(const Observations& observations) {
    Fix fix;
    locate(observations, fix);
    return fix;
  }

 protected:
  /// Observations that the entries of `fix.rejections` refer to.
  enum class RejectionsOf { kArrivals, kBearings };
  explicit Localizer(const Deployment& deployment, RejectionsOf rejections_of = RejectionsOf::kArrivals)
      : beacons_(deployment.beacons.size()),
        receivers_(deployment.receivers.size()),
        rejections_of_(rejections_of) {}
  Localizer(const Localizer&) = default;
  Localizer& operator=(const Localizer&) = default;

 private:
  /// Computes the fix. All beacons, receivers and labelled reflectors belong to the deployment.
  virtual void locate_known(const Observations& observations, Fix& fix) noexcept = 0;
  [[nodiscard]] bool knows(const Arrival& arrival) const noexcept;
  [[nodiscard]] bool knows(const Bearing& bearing) const noexcept;

  std::size_t beacons_, receivers_;
  RejectionsOf rejections_of_;
  std::vector<Arrival> known_arrivals_;
  std::vector<Bearing> known_bearings_;
};

/// Number of beacons that localizers may use.
[[nodiscard]] std::size_t usable_beacons(const Deployment& deployment);

/// Builds errors that explain why a method does not suit a deployment, beginning with the method's name.
class MisfitOf {
 public:
  explicit MisfitOf(const char* method) : method_(method) {}
  [[nodiscard]] tl::unexpected<Error> operator()(const std::string& found, std::string expected) const;
  /// Error if the method needs planar motion and synchronised clocks and the deployment lacks one of them.
  [[nodiscard]] Result<void> in_the_plane(const Deployment& deployment) const;

 private:
  const char* method_;
};

/// Rows of a log with known beacons and receivers and with possible times. Returns the log itself if all rows
/// qualify, else a filtered copy in `room`.
[[nodiscard]] const MeasurementLog& known_rows(const MeasurementLog& log, const Deployment& deployment,
                                               MeasurementLog& room);

}  // namespace octant

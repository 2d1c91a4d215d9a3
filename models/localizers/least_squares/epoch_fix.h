// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/run.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Part of a segment that belongs to one of its nodes (epochs linked by odometry): its arrivals, bearings and
/// poses.
[[nodiscard]] Segment node_segment(const Trajectory& trajectory, const Segment& segment, std::size_t node);

/// Robust least-squares fix of one segment (a stationary epoch: one node) without an initial value. A coarse
/// search over poses that pairs of arrivals allow finds the largest consensus under a one-sided loss, and the
/// arrivals that agree are adjusted. The result is their least-squares estimate. Its covariance is that of
/// their noise (and the range uncertainty) for fixed shared parameters. If the heading is not determined (one
/// receiver on the axis, no bearings), the position is still a fix and the sigma of the heading is pi.
///
/// Sets the node and marks the arrivals of the segment as used or rejected. With correlated noise their
/// sigmas are left as the weights of the adjustment. The node counts as placed only if the fix is kOk, but
/// always contains the best pose.
[[nodiscard]] Fix fix_epoch(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                            const EpochFixOptions& options = {});
/// Writes into an existing fix and reuses its memory.
void fix_epoch(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
               const EpochFixOptions& options, Fix& fix);

struct PlaceModel;

/// Robust least-squares localizer: one fix for each epoch, with labelled bearings if there are any. In space
/// an epoch that does not determine the attitude gives a position (place_fix.h).
class LeastSquaresLocalizer final : public Localizer {
 public:
  explicit LeastSquaresLocalizer(Deployment deployment, EpochFixOptions options = {});

  using Localizer::locate;
  /// Fix from the arrivals of one epoch of one vehicle.
  [[nodiscard]] Fix locate(std::span<const Arrival> arrivals) { return locate(Observations{arrivals, {}}); }
  /// Fixes of all epochs of a run in order, including those without a pose.
  [[nodiscard]] std::vector<Fix> locate(const MeasurementLog& all_rows);

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  void fix_segment(Trajectory& trajectory, const Segment& epoch, Fix& fix) const;
  void protect(Trajectory& trajectory, const Segment& epoch, const EpochFixModel& model, Fix& fix) const;
  bool adjust_again(Trajectory& trajectory, const Segment& epoch, const EpochFixModel& model, Fix& fix) const;

  Deployment deployment_;
  EpochFixOptions options_;
  EpochFixModel model_;
  std::shared_ptr<const PlaceModel> place_;  ///< in space
  CalibrationPart calibration_;
  TrajectoryModel trajectory_model_;
  Trajectory epoch_;
  Scratch scratch_;
};

/// Marks all arrivals and bearings of a segment as used, except those of unusable beacons.
void reset_rejections(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model);

/// Covariance of the pose of an adjusted node due to noise; false if the position is not determined. An
/// undetermined heading gets the sigma pi.
bool pose_covariance(const Trajectory& trajectory, const NodeBlock& information, PoseCovariance& covariance);

}  // namespace octant

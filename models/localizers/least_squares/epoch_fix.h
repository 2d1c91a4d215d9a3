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

/// The part of a segment that belongs to one of its nodes alone (epochs chained by odometry): its arrivals,
/// bearings, poses.
[[nodiscard]] Segment node_segment(const Trajectory& trajectory, const Segment& segment, std::size_t node);

/// Robust least-squares fix of one segment (a stationary epoch: one node) from nothing: a coarse search over
/// poses that pairs of arrivals allow, the largest consensus under a one-sided loss, then a plain adjustment
/// of the arrivals that agree. The result is the least-squares estimate of the arrivals used; its covariance
/// is that of their noise (and the uncertainty), with the shared parameters held. Where nothing tells the
/// heading (one receiver on the axis, no bearings) the position is still a fix, and the heading's sigma is
/// pi. Sets the node, marks the arrivals of the segment used or rejected; where the model states correlated
/// noise, they are left with the sigmas that they were weighed by. The node counts as placed only if the fix
/// is kOk; it holds the best pose found in any case.
[[nodiscard]] Fix fix_epoch(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                            const EpochFixOptions& options = {});
/// The same into a fix whose memory is used again.
void fix_epoch(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
               const EpochFixOptions& options, Fix& fix);

struct PlaceModel;

/// Robust least-squares localizer: one fix an epoch, by the labelled bearings too where there are any. In
/// space an epoch that leaves the attitude open gives a place (place_fix.h).
class LeastSquaresLocalizer final : public Localizer {
 public:
  explicit LeastSquaresLocalizer(Deployment deployment, EpochFixOptions options = {});

  using Localizer::locate;
  /// Fix from the arrivals of one epoch of one vehicle.
  [[nodiscard]] Fix locate(std::span<const Arrival> arrivals) { return locate(Observations{arrivals, {}}); }
  /// All epochs of a run, in order; epochs without a fix included with their reason.
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

/// All arrivals and bearings of a segment in use, but those of beacons that are not.
void reset_rejections(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model);

/// Covariance of the pose of an adjusted node, noise alone; false where the position is not determined. A
/// heading without information gets the sigma pi.
bool pose_covariance(const Trajectory& trajectory, const NodeBlock& information, PoseCovariance& covariance);

}  // namespace octant

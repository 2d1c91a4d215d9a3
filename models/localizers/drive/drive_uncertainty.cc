// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_uncertainty.h"

#include <algorithm>
#include <set>
#include <vector>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/chain/chain_protection.h"
#include "models/localizers/common/separation.h"

namespace octant {

void set_uncertainty(const Trajectory& t, const Segment& segment, const EpochFixModel& model,
                     const CalibrationPart& calibration, const DriveUncertaintyOptions& options,
                     std::span<const DriveInstant> instants, std::span<Fix> fixes) {
  const int dof = pose_dof(t.motion);
  const CalibrationErrors errors(t, segment, model.state.receiver_p_vehicle_m.size(), calibration,
                                 model.correlated.pair_sigma_s);
  std::vector<double> widened(instants.size());
  std::vector<ChainVariant> variants;
  variants.push_back(
      {BeaconId(), errors.columns(),
       [&errors](const ObservationRow& row, Eigen::RowVectorXd& e) { return errors.of(row, e); },
       [&](const ChainWindow& window) {
         for_each_instant(window, instants, [&](std::size_t i) {
           const PoseCovariance noise = window.covariance_at(instants[i], dof);
           const ChainWindow::Matrix x = window.solution_at(instants[i], dof);
           fixes[i].covariance = noise + x * x.transpose();
           widened[i] = std::max(1.0, horizontal_variance(fixes[i].covariance) / horizontal_variance(noise));
         });
       }});
  DriveSeparation separation(instants, widened, dof);
  if (options.protect) {
    std::set<BeaconId> beacons;
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
      if (t.arrivals[i].rejection == Rejection::kUsed) beacons.insert(t.arrivals[i].beacon);
    for (const BeaconId beacon : beacons) variants.push_back(separation.without(beacon));
  }
  const std::vector<bool> determined = solve_by_windows(t, segment, model.state, variants, options.threads);
  // A drive that is lost without one of its beacons has no bound anywhere.
  const bool is_protected = variants.size() > 1 && std::ranges::find(determined, false) == determined.end();
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (!determined.front()) fixes[i].status = FixStatus::kPoorGeometry;
    if (is_protected)
      fixes[i].protection_level_m = separation.level_m(i, horizontal_variance(fixes[i].covariance));
  }
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_calibration.h"

#include <cmath>

#include "models/support/decompositions.h"

namespace octant {

CalibrationErrors::CalibrationErrors(const Trajectory& t, const Segment& segment, std::size_t receivers,
                                     const CalibrationPart& calibration, double pair_sigma_s)
    : calibration_(calibration),
      receivers_(receivers),
      pair_sigma_s_(pair_sigma_s),
      place_(static_cast<std::size_t>(calibration.covariance().cols()), -1) {
  std::vector<int> touched;
  const auto touch = [&](int at) {
    int& place = place_[static_cast<std::size_t>(at)];
    if (place >= 0) return;
    place = static_cast<int>(touched.size());
    touched.push_back(at);
  };
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    const std::size_t pair = pair_of(a.beacon, a.receiver);
    if (pair >= pair_place_.size()) pair_place_.resize(pair + 1, -1);
    if (pair_place_[pair] >= 0) continue;
    pair_place_[pair] = static_cast<int>(pairs_++);
    calibration.for_each_parameter(a.beacon, a.receiver, touch);
  }
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i)
    if (t.bearings[i].rejection == Rejection::kUsed && t.bearings[i].reflector.valid())
      calibration.for_each_parameter(t.bearings[i].reflector, ReceiverId(), touch);
  if (!(pair_sigma_s > 0)) pairs_ = 0;
  root_ = covariance_root(calibration.covariance()(touched, touched));
}

bool CalibrationErrors::of(const ObservationRow& row, Eigen::RowVectorXd& errors) const {
  if (!row.has_shared) return false;
  errors.setZero();
  calibration_.for_each_coupling(row, [&](int at, double derivative) {
    errors.head(root_.cols()) += derivative * root_.row(place_[static_cast<std::size_t>(at)]);
  });
  if (pairs_ > 0 && row.kind == RowKind::kTof)
    errors[root_.cols() + pair_place_[pair_of(row.beacon, row.receiver)]] = row.by(kByDelay) * pair_sigma_s_;
  return true;
}

void node_calibration(const Trajectory& t, const Segment& segment, const SharedState& state,
                      const ChainFactor& chain, const CalibrationPart& calibration, std::size_t node,
                      NodeCalibration& out) {
  // Rows of H^-1 for the pose of the node, computed by columns.
  const int n = t.block_size(), dof = pose_dof(t.motion);
  std::pmr::vector<NodeBlock> z(chain.inverse.size(), NodeBlock::Zero(n, dof), scratch());
  z[node - segment.first_node].topRows(dof).setIdentity();
  chain.solve(z);
  out.by_parameter.setZero();
  out.by_pair.setZero();
  const std::size_t receivers = state.receiver_p_vehicle_m.size();
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    const std::size_t k = row.node - segment.first_node;
    NodeVector gain = z[k].transpose() * row.by_node.transpose();
    if (row.has_next) gain += z[k + 1].transpose() * row.by_next.transpose();
    // The state follows a parameter error so that residuals stay small, hence the opposite sign.
    calibration.for_each_coupling(
        row, [&](int at, double derivative) { out.by_parameter.col(at) -= derivative * gain; });
    if (row.kind == RowKind::kTof && out.by_pair.cols() > 0)
      out.by_pair.col(static_cast<Eigen::Index>(row.beacon.index() * receivers + row.receiver.index())) -=
          row.by(kByDelay) * gain;
  });
}

}  // namespace octant

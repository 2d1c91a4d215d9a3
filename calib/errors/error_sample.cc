// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_sample.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/adjust/leverage.h"
#include "models/physics/pose.h"
#include "models/support/decompositions.h"
#include "models/support/observed.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

constexpr std::size_t kStretches = 8;  ///< number of segments of a long log
/// Share of the sample up to which a drive is cut; cuts lose the information between states.
constexpr double kShareOfLongDrive = 0.1;

/// Eliminates the states of a segment under least squares. @return the first coordinate of each state
std::vector<std::uint32_t> add_chain(const Trajectory& t, const Segment& segment, const SharedState& state,
                                     StateChains& chains) {
  ChainSystem system;
  build_chain_system(t, segment, state, {}, system);
  const std::size_t count = system.D.size();
  const auto keep = [&chains](const NodeBlock& block) {
    chains.blocks.insert(chains.blocks.end(), block.data(), block.data() + block.size());
    return chains.blocks.size() - static_cast<std::size_t>(block.size());
  };
  std::vector<std::uint32_t> first;
  NodeBlock A = system.D[0];
  for (std::size_t k = 0; k < count; ++k) {
    A.diagonal().array() += kStepFloor * (1.0 + system.D[k].diagonal().maxCoeff());
    StateChains::Link link;
    link.first = chains.coordinates;
    link.size = static_cast<int>(A.rows());
    first.push_back(link.first);
    chains.coordinates += static_cast<std::uint32_t>(link.size);
    const Eigen::LLT<NodeBlock> factor(A);
    link.inverse = keep(factor.solve(NodeBlock::Identity(A.rows(), A.rows())));
    if (k + 1 < count) {
      const NodeBlock onward = factor.solve(system.U[k]);
      link.next_size = static_cast<int>(onward.cols());
      link.onward = keep(onward);
      A = system.D[k + 1] - system.U[k].transpose() * onward;
    }
    chains.links.push_back(link);
  }
  return first;
}

class SampleBuilder {
 public:
  SampleBuilder(const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                const SharedState& state, const Covariance& C, std::size_t most)
      : trajectories_(trajectories), state_(state), sweep_(layout, C), most_(most) {}

  ErrorSample build() {
    sample_.J.first = {0};
    sample_.L = sweep_.root();
    std::size_t all = 0;
    for (const Trajectory& t : trajectories_) all += t.arrivals.size() + t.bearings.size();
    for (const Trajectory& t : trajectories_) {
      const auto mine = static_cast<double>(t.arrivals.size() + t.bearings.size());
      add_segments(
          t, std::min(1.0, static_cast<double>(most_) / static_cast<double>(std::max<std::size_t>(all, 1))),
          mine);
    }
    sample_.residual = Eigen::Map<const Eigen::VectorXd>(residual_.data(), std::ssize(residual_));
    const Eigen::Index rank = sample_.L.cols();
    sample_.F.conservativeResize(sample_.residual.size(), rank);
    sample_.prior_root =
        symmetric_root(Eigen::MatrixXd::Identity(rank, rank) - sample_.F.transpose() * sample_.F);
    sample_.share = seen_ > 0 ? static_cast<double>(seen_) / static_cast<double>(all) : 1.0;
    return std::move(sample_);
  }

 private:
  /// All segments of a trajectory, or an evenly spaced part of them.
  void add_segments(const Trajectory& t, double share, double observations) {
    const std::size_t segments = t.segments.size();
    if (share < kShareOfLongDrive && segments == 1 && is_long_chain(t.segments[0])) {
      add_stretches(t, share);
      return;
    }
    if (share >= 1.0 || segments < 4 * kStretches || observations < 1.0) {
      add_segments(t, 0, segments);
      return;
    }
    const std::size_t pitch = segments / kStretches;
    const auto length =
        std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(pitch)));
    for (std::size_t i = 0; i < kStretches; ++i) add_segments(t, i * pitch, i * pitch + length);
  }

  /// Segments of a long drive, each solved separately, because within a chain neighbours affect the
  /// residuals.
  void add_stretches(const Trajectory& t, double share) {
    const Segment& whole = t.segments[0];
    const double nodes = share * static_cast<double>(whole.last_node - whole.first_node) / kStretches;
    Trajectory some = pick_segments(
        t, spread_stretches(t, whole, kStretches, std::max<std::size_t>(2, static_cast<std::size_t>(nodes))));
    for (const Segment& s : some.segments)
      if (some.nodes[s.first_node].placed) solve_states(some, s, state_, {});
    add_segments(some, 0, some.segments.size());
  }

  void add_segments(const Trajectory& t, std::size_t first, std::size_t last) {
    const std::size_t rows = sample_.rows.size() + most_rows(t, first, last);  // largest size of a sample
    if (rows > static_cast<std::size_t>(sample_.F.rows())) {                   // rare: many small segments
      const std::size_t room = std::max(rows, sample_.rows.size() * 3 / 2);
      sample_.rows.reserve(room);
      sample_.F.conservativeResize(static_cast<Eigen::Index>(room), sample_.L.cols());
    }
    for (std::size_t s = first; s < last; ++s) {
      const Segment& segment = t.segments[s];
      seen_ += segment.last_arrival - segment.first_arrival + segment.last_bearing - segment.first_bearing;
      if (!t.nodes[segment.first_node].placed) continue;
      const std::vector<std::uint32_t> states = add_chain(t, segment, state_, sample_.chains);
      sweep_.sweep(t, state_, s, s + 1, 1, [&](const RowLeverage& l) {
        const std::size_t node = l.row.node - segment.first_node;
        add_taps(l.row.by_node, states[node]);
        if (l.row.has_next) add_taps(l.row.by_next, states[node + 1]);
        add(t, l);
      });
    }
  }

  void add_taps(const NodeRow& by, std::uint32_t state) {
    for (Eigen::Index a = 0; a < by.size(); ++a)
      sample_.J.taps.push_back({state + static_cast<std::uint32_t>(a), static_cast<float>(by[a])});
  }

  void add(const Trajectory& t, const RowLeverage& l) {
    using Kind = ErrorSample::Kind;
    ErrorSample::Row row;
    row.run = t.run;
    row.kind = l.row.kind == RowKind::kTof ? Kind::kArrival : Kind::kOther;
    if (row.kind == Kind::kArrival) {
      const ArrivalObservation& a = t.arrivals[l.row.index];
      row.beacon = static_cast<int>(a.beacon.value);
      row.receiver = static_cast<int>(a.receiver.value);
      row.time_s = a.time_s;
    } else if (l.row.kind == RowKind::kBearing && t.bearings[l.row.index].reflector.valid()) {
      row.kind = Kind::kBearing;
      row.beacon = static_cast<int>(t.bearings[l.row.index].reflector.value);
      row.time_s = t.nodes[l.row.node].time_s;
    }
    if (row.kind != Kind::kOther) {
      const Pose& T = t.nodes[l.row.node].T_map_vehicle;
      row.p_map_m = T.translation_m;
      if (row.kind == Kind::kArrival)
        row.p_map_m = T * state_.receiver_p_vehicle_m[static_cast<std::size_t>(row.receiver)];
      const Eigen::Vector3d v = state_.beacon_p_map_m[static_cast<std::size_t>(row.beacon)] - row.p_map_m;
      row.direction_rad = wrap_angle(std::atan2(v.y(), v.x()) - T.heading_rad());
      row.aspect_rad = std::atan2(-v.y(), -v.x());
      row.range_m = v.norm();
    }
    residual_.push_back(l.row.residual);
    sample_.F.row(static_cast<Eigen::Index>(sample_.rows.size())) = l.f;
    sample_.rows.push_back(row);
    sample_.J.first.push_back(static_cast<std::uint32_t>(sample_.J.taps.size()));
  }

  const std::vector<Trajectory>& trajectories_;
  const SharedState& state_;
  LeverageSweep sweep_;
  std::size_t most_, seen_ = 0;
  ErrorSample sample_;
  std::vector<double> residual_;
};

}  // namespace

ErrorSample error_sample(const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                         const SharedState& state, const Covariance& C, std::size_t most) {
  return SampleBuilder(layout, trajectories, state, C, most).build();
}

}  // namespace octant::calib

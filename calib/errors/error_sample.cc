// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include <Eigen/Cholesky>

#include "calib/adjust/leverage.h"
#include "calib/problem/ranges.h"
#include "models/physics/pose.h"
#include "models/support/observed.h"
#include "models/trajectory/decompositions.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

constexpr std::size_t kStretches = 8;  ///< of a long log
/// A drive is cut where the sample is at most this part: cuts cost what states know of each other.
constexpr double kShareOfLongDrive = 0.1;
constexpr std::size_t kShifts = 3;  ///< partitions of a component
constexpr double kLadder = 3.0;     ///< from one extent to the next

/// Eliminates the states of a segment, plain squares. @return the coordinate at which each state begins
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
  /// All segments of a trajectory, or stretches of them that lie evenly.
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

  /// Stretches of a long drive, each solved for itself: neighbours have a part in residuals within a chain.
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
    const std::size_t rows = sample_.rows.size() + most_rows(t, first, last);  // the most of a sample
    if (rows > static_cast<std::size_t>(sample_.F.rows())) {  // many small stretches: few times
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

/// Numbers keys from 0 in the order in which they come. @param keys  mixed
std::vector<std::int32_t> numbered(const std::vector<std::uint64_t>& keys, const std::vector<bool>& in,
                                   std::int32_t& count) {
  std::size_t size = 16;
  while (size < 2 * keys.size()) size *= 2;
  std::vector<std::pair<std::uint64_t, std::int32_t>> table(size, {0, -1});
  std::vector<std::int32_t> number(keys.size(), -1);
  count = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!in[i]) continue;
    std::size_t at = keys[i] & (size - 1);
    while (table[at].second >= 0 && table[at].first != keys[i]) at = (at + 1) & (size - 1);
    if (table[at].second < 0) table[at] = {keys[i], count++};
    number[i] = table[at].second;
  }
  return number;
}

class CellBuilder {
 public:
  CellBuilder(const ErrorSample& sample, bool bearings)
      : rows_(sample.rows), bearings_(bearings), in_(rows_.size()) {
    const auto kind = bearings ? ErrorSample::Kind::kBearing : ErrorSample::Kind::kArrival;
    for (std::size_t i = 0; i < rows_.size(); ++i) in_[i] = rows_[i].kind == kind;
  }

  void build(std::vector<ErrorCells>& out) {
    if (std::ranges::none_of(in_, [](bool in) { return in; })) return;
    const bool pairs = !bearings_ && several_receivers();
    add(out, ErrorGroup::kPair, ErrorAxis::kConstant, 0.0);
    if (pairs) add(out, ErrorGroup::kBeacon, ErrorAxis::kConstant, 0.0);
    if (pairs) add(out, ErrorGroup::kReceiver, ErrorAxis::kConstant, 0.0);
    const double step_s = usual_step_s(), span_s = longest_run_s();
    for (double extent = kLadder * step_s; step_s > 0 && extent < span_s; extent *= kLadder) {
      add(out, ErrorGroup::kPair, ErrorAxis::kTime, extent);
      if (pairs) add(out, ErrorGroup::kBeacon, ErrorAxis::kTime, extent);
    }
    const double size_m = path_size_m();
    for (const double part : {1.0 / 24, 1.0 / 8, 1.0 / 3})
      if (size_m > 0) {
        add(out, ErrorGroup::kPair, ErrorAxis::kPlace, part * size_m);
        if (pairs) add(out, ErrorGroup::kBeacon, ErrorAxis::kPlace, part * size_m);
      }
    if (size_m > 0) {
      for (const int sectors : {24, 8}) {
        add(out, ErrorGroup::kPair, ErrorAxis::kDirection, 2 * M_PI / sectors);
        add(out, ErrorGroup::kReceiver, ErrorAxis::kDirection, 2 * M_PI / sectors);
        add(out, pairs ? ErrorGroup::kBeacon : ErrorGroup::kPair, ErrorAxis::kAspect, 2 * M_PI / sectors);
      }
      add(out, ErrorGroup::kPair, ErrorAxis::kRange, longest_range_m() / 8);
    }
  }

 private:
  static std::uint64_t key_of(const ErrorSample::Row& row, ErrorGroup group) {
    const auto beacon = static_cast<std::uint64_t>(group == ErrorGroup::kReceiver ? 0 : row.beacon + 1);
    const auto receiver = static_cast<std::uint64_t>(group == ErrorGroup::kBeacon ? 0 : row.receiver + 1);
    return beacon << 32U | receiver;
  }

  static std::uint64_t mixed(std::uint64_t key, std::int64_t more) {  // splitmix64
    std::uint64_t z = key + 0x9e3779b97f4a7c15ULL * (static_cast<std::uint64_t>(more) + 0x1234567ULL);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }

  static std::int64_t cell(double value, double extent, double shift) {
    return static_cast<std::int64_t>(std::floor(value / extent + shift));
  }

  static std::int64_t sector(double angle_rad, double extent_rad, double shift) {
    const auto sectors = static_cast<std::int64_t>(std::lround(2 * M_PI / extent_rad));
    return ((cell(angle_rad + M_PI, extent_rad, shift) % sectors) + sectors) % sectors;
  }

  static std::uint64_t key_of(const ErrorSample::Row& row, std::uint64_t group, ErrorAxis axis, double extent,
                              double shift) {
    switch (axis) {
      case ErrorAxis::kConstant: return mixed(group, 0);
      case ErrorAxis::kTime:
        return mixed(mixed(group, static_cast<std::int64_t>(row.run)), cell(row.time_s, extent, shift));
      case ErrorAxis::kPlace:
        return mixed(
            mixed(mixed(group, cell(row.p_map_m.x(), extent, shift)), cell(row.p_map_m.y(), extent, shift)),
            cell(row.p_map_m.z(), extent, shift));
      case ErrorAxis::kDirection: return mixed(group, sector(row.direction_rad, extent, shift));
      case ErrorAxis::kAspect: return mixed(group, sector(row.aspect_rad, extent, shift));
      case ErrorAxis::kRange: return mixed(group, cell(row.range_m, extent, shift));
    }
    return group;
  }

  void add(std::vector<ErrorCells>& out, ErrorGroup group, ErrorAxis axis, double extent) {
    ErrorCells c;
    c.part = {bearings_, group, axis, extent, 0.0};
    const std::size_t shifts = axis == ErrorAxis::kConstant ? 1 : kShifts;
    for (std::size_t k = 0; k < shifts; ++k) {
      std::vector<std::uint64_t> keys(rows_.size());
      for (std::size_t i = 0; i < rows_.size(); ++i)
        if (in_[i])
          keys[i] = key_of(rows_[i], key_of(rows_[i], group), axis, extent,
                           static_cast<double>(k) / static_cast<double>(shifts));
      std::int32_t count = 0;
      c.partitions.push_back(numbered(keys, in_, count));
      c.counts.push_back(count);
    }
    out.push_back(std::move(c));
  }

  [[nodiscard]] bool several_receivers() const {
    int first = -1;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (!in_[i]) continue;
      if (first >= 0 && rows_[i].receiver != first) return true;
      first = rows_[i].receiver;
    }
    return false;
  }

  /// Median time between neighbours of a pair; 0 where there are none.
  [[nodiscard]] double usual_step_s() const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (in_[i]) order.push_back(i);
    const auto pair = [&](std::size_t i) {
      return std::tuple(rows_[i].run, rows_[i].beacon, rows_[i].receiver);
    };
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
      return std::tuple_cat(pair(a), std::tuple(rows_[a].time_s)) <
             std::tuple_cat(pair(b), std::tuple(rows_[b].time_s));
    });
    std::vector<double> steps;
    for (std::size_t k = 1; k < order.size(); ++k)
      if (pair(order[k - 1]) == pair(order[k]) && rows_[order[k]].time_s > rows_[order[k - 1]].time_s)
        steps.push_back(rows_[order[k]].time_s - rows_[order[k - 1]].time_s);
    return median(std::move(steps));
  }

  [[nodiscard]] double longest_run_s() const {
    double longest = 0.0;
    std::vector<std::pair<double, double>> span;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (!in_[i]) continue;
      if (rows_[i].run >= span.size()) span.resize(rows_[i].run + 1, {INFINITY, -INFINITY});
      auto& [from, to] = span[rows_[i].run];
      from = std::min(from, rows_[i].time_s);
      to = std::max(to, rows_[i].time_s);
      longest = std::max(longest, to - from);
    }
    return longest;
  }

  [[nodiscard]] double path_size_m() const {
    Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = Eigen::Array2d::Constant(-INFINITY);
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (in_[i])
        low = low.min(rows_[i].p_map_m.head<2>().array()),
        high = high.max(rows_[i].p_map_m.head<2>().array());
    return (high - low).maxCoeff();
  }

  [[nodiscard]] double longest_range_m() const {
    double longest = 1e-6;
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (in_[i]) longest = std::max(longest, rows_[i].range_m);
    return longest;
  }

  const std::vector<ErrorSample::Row>& rows_;
  bool bearings_;
  std::vector<bool> in_;
};

}  // namespace

ErrorSample error_sample(const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                         const SharedState& state, const Covariance& C, std::size_t most) {
  return SampleBuilder(layout, trajectories, state, C, most).build();
}

std::vector<ErrorCells> error_cells(const ErrorSample& sample) {
  std::vector<ErrorCells> out;
  for (const bool bearings : {false, true}) CellBuilder(sample, bearings).build(out);
  return out;
}

}  // namespace octant::calib

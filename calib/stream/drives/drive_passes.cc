// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/drive_passes.h"

#include <algorithm>
#include <tuple>

#include "calib/adjust/node_buffer.h"
#include "calib/adjust/reject.h"
#include "calib/problem/gates.h"
#include "calib/stream/long_log.h"
#include "calib/stream/side_by_side.h"
#include "calib/sums/over_ranks.h"
#include "models/trajectory/make_trajectory.h"
#include "models/trajectory/odometry_path.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

/// A step of a piece's states that gains a smaller share of their cost is the last; the reduction takes the
/// next one with it.
constexpr double kPieceAtRest = 1e-9;

}  // namespace

/// Pieces of chains, joined in their order whichever ends first. With ranks, each one waits for its own
/// pieces.
class DrivePasses::JoinedEnds {
 public:
  JoinedEnds(const DrivePasses& passes, Eigen::Index parameters)
      : passes_(passes),
        parameters_(parameters),
        chains_(passes.index_.chains().size(), EndChain(parameters, passes.block_size())),
        in_order_(passes.first_),
        waiting_(passes.task_.options.ranks != nullptr ? passes.kept_.size() : 0) {}

  void add(std::size_t piece, const OpenChain& system) {
    in_order_.add(piece, system, [this](std::size_t k, const OpenChain& next) {
      if (waiting_.empty())
        append(k, next);
      else
        waiting_[k] = next;
    });
  }
  std::vector<EndChain> chains() && {
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      const DrivePiece& piece = passes_.index_.pieces()[k];
      const Eigen::Index block = passes_.block_size(),
                         size = parameters_ + (piece.open_left ? block : 0) + (piece.open_right ? block : 0);
      OpenChain chain = std::move(waiting_[k]);
      if (chain.H.size() == 0) {  // another rank's, or nothing placed it
        chain.gradient.setZero(size);
        chain.H.setZero(size, size);
      }
      sum_over(passes_.task_.options.ranks, chain);
      if (!chain.H.isZero(0.0)) append(k, chain);
    }
    return std::move(chains_);
  }

 private:
  /// A piece without a placed state adds no information and has no ends.
  void append(std::size_t piece, const OpenChain& system) {
    if (system.H.size() > 0) chains_[passes_.index_.pieces()[piece].chain].append(system);
  }
  const DrivePasses& passes_;
  Eigen::Index parameters_;
  std::vector<EndChain> chains_;
  OrderedParts<OpenChain> in_order_;
  std::vector<OpenChain> waiting_;
};

DrivePasses::DrivePasses(const ReadingTask& task, const DriveIndex& index)
    : task_(task),
      index_(index),
      model_(trajectory_model(task.frame.site)),
      workers_(static_cast<std::size_t>(std::max(task.workers, 1))),
      kept_(index.pieces().size()) {
  std::tie(first_, last_) = parts_of(task.options.ranks, kept_.size());
  for (const DriveChain& chain : index.chains())
    like_.push_back(
        make_trajectory(without_lists(task.source.log(chain.run)), chain.run, chain.vehicle, model_));
}

/// work(piece, DriveWork&) for those of this rank, with the piece loaded, or widened to its neighbours.
template <class Do>
Result<void> DrivePasses::for_each_piece(bool widened, Do&& work) {
  const auto load = [&](std::size_t k, std::size_t worker) -> Result<void> {
    DriveWork& w = workers_[worker];
    const std::size_t run_before = w.piece == nullptr ? SIZE_MAX : index_.chains()[w.piece->chain].run;
    w.piece = &index_.pieces()[k];
    const DrivePiece piece = widened ? index_.widened(*w.piece) : *w.piece;
    const DriveChain& chain = index_.chains()[piece.chain];
    if (run_before != chain.run) begin_run(task_.source.log(chain.run), w.log);
    const auto first_bearing = index_.read(task_.source, piece, w.log);
    if (!first_bearing) return fail(first_bearing.error());
    w.trajectory.clear();
    w.trajectory.push_back(make_trajectory(w.log, chain.run, chain.vehicle, model_));
    for (BearingObservation& b : w.t().bearings) b.bearing += *first_bearing;
    if (w.t().arrivals.size() != piece.arrivals || w.t().nodes.size() != piece.nodes)
      return fail(changed_while_read(w.log));
    extend_back(w);
    work(k, w);
    return {};
  };
  return for_each_side_by_side(first_, last_, workers_.size(), task_.monitor, load);
}

/// Arrivals at the beginning of a piece may have been requested before it (two-way ranging).
void DrivePasses::extend_back(DriveWork& w) const {
  Trajectory& t = w.t();
  double asked_s = t.nodes.front().time_s, heard_s = asked_s;
  const auto is_asked_before = [&](const ArrivalObservation& a) {
    return a.two_way && a.time_s - a.tof_s < t.nodes.front().time_s;
  };
  for (const ArrivalObservation& a : t.arrivals) {
    if (!is_asked_before(a)) continue;
    asked_s = std::min(asked_s, a.time_s - a.tof_s);
    heard_s = std::max(heard_s, a.time_s);
  }
  if (asked_s == t.nodes.front().time_s) return;
  MeasurementLog rows = without_lists(w.log);
  rows.odometry = index_.odometry_within(task_.source, w.piece->chain, asked_s, heard_s);
  const OdometryPath path = odometry_path(rows, t.vehicle);
  for (const ArrivalObservation& a : t.arrivals) {
    if (!is_asked_before(a)) continue;
    if (const auto T_hear_send = hear_send_motion(path, w.log.arrivals[a.arrival]))
      t.T_hear_send[static_cast<std::size_t>(a.hear_send)] = *T_hear_send;
  }
}

void DrivePasses::restore(std::size_t piece, const Estimate& estimate, const std::vector<Node>& ends,
                          DriveWork& w) const {
  Trajectory& t = w.t();
  take_noise(task_.frame, estimate, w.trajectory);
  kept_[piece].restore(t);
  const auto put_end = [](const Node& end, Node& node) {
    node.placed = end.placed;
    if (!end.placed) return;
    node.T_map_vehicle = end.T_map_vehicle;
    node.cycle_offset_s = end.cycle_offset_s;
  };
  if (w.piece->open_left) put_end(ends[piece - 1], t.nodes.front());
  if (w.piece->open_right) put_end(ends[piece], t.nodes.back());
}

Result<LogReadings::Placed> DrivePasses::place(const Estimate& estimate, double /*suspect_sigmas*/,
                                               bool /*mark*/) {
  const SharedState state = estimate.state();
  SpreadArrivals spread(task_, state, kept_.size());
  std::vector<std::vector<double>> ends(kept_.size());
  // Arrivals before and after a piece also determine its ends.
  auto done = for_each_piece(true, [&](std::size_t k, DriveWork& w) {
    apply_gates(task_.frame.site, w.trajectory, 1);
    place_all_drives(task_.frame, state, estimate.beacon_usable, 1, w.trajectory);
    const Trajectory& t = w.t();
    const std::size_t first_node = w.piece->open_left ? kUnitNodes : 0;
    const auto first_arrival = static_cast<std::size_t>(
        std::partition_point(t.arrivals.begin(), t.arrivals.end(),
                             [&](const ArrivalObservation& a) { return a.node < first_node; }) -
        t.arrivals.begin());
    for (std::size_t i = 0; i < w.piece->arrivals; ++i) {
      const ArrivalObservation& a = t.arrivals[first_arrival + i];
      spread.add_range(k, w.piece->arrivals_before + i, t, a);
      spread.add_residual(k, w.piece->arrivals_before + i, t, a);
    }
    kept_[k].keep(t, first_node, first_node + w.piece->nodes, first_arrival, w.piece->arrivals);
    BufferWriter(ends[k]).exchange(t.nodes[first_node], t.nodes[first_node + w.piece->nodes - 1]);
  });
  if (!done) return fail(done.error());
  join_pieces(in_order(task_.options.ranks, std::move(ends)));
  Placed placed = std::move(spread).placed(task_.options.ranks);
  placed.states = index_.nodes();
  return placed;
}

/// Places pieces without arrivals by odometry from a neighbour; then makes neighbours agree about the state
/// that they share.
/// @param numbers  of the first and the last state of each piece
void DrivePasses::join_pieces(const std::vector<double>& numbers) {
  const std::vector<DrivePiece>& pieces = index_.pieces();
  std::vector<std::pair<Node, Node>> ends(pieces.size());
  BufferReader buffer(numbers);
  for (auto& [first, last] : ends) buffer.exchange(first, last);
  const auto none = [&](std::size_t k) { return !ends[k].first.placed; };
  for (std::size_t k = 1; k < pieces.size(); ++k)
    if (pieces[k].open_left && none(k) && !none(k - 1))
      ends[k] = reach_by_odometry(k, true, ends[k - 1].second);
  for (std::size_t k = pieces.size(); k-- > 0;)
    if (pieces[k].open_right && none(k) && !none(k + 1))
      ends[k] = reach_by_odometry(k, false, ends[k + 1].first);
  tried_ = {};
  tried_.state.resize(pieces.size());
  for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
    if (!pieces[k].open_right || none(k)) continue;
    const Node &here = ends[k].second, &there = ends[k + 1].first;
    tried_.state[k] = here;
    tried_.state[k].T_map_vehicle = interpolate(here.T_map_vehicle, there.T_map_vehicle, 0.5);
  }
  from_ = tried_;
}

/// @param from  the neighbour's last or first state
/// @return the piece's first and last
std::pair<Node, Node> DrivePasses::reach_by_odometry(std::size_t piece, bool forward, const Node& from) {
  const DrivePiece& p = index_.pieces()[piece];
  const DriveChain& chain = index_.chains()[p.chain];
  const std::vector<OdometryStep>& rows = task_.source.log(chain.run).odometry;
  std::vector<Pose> path = {Pose()};
  for (std::size_t row = chain.units[p.first_unit].first_row + 1; row < rows.size() && path.size() < p.nodes;
       ++row)
    if (rows[row].vehicle == chain.vehicle) path.push_back(path.back() * rows[row].pose());
  const Pose T_map_path = forward ? from.T_map_vehicle : from.T_map_vehicle * path.back().inverse();
  std::pair<Node, Node> ends;
  KeptStates& kept = kept_[piece].states();
  kept.clear();
  for (std::size_t k = 0; k < path.size(); ++k) {
    Node node = from;
    node.T_map_vehicle = T_map_path * path[k];
    if (k == 0) ends.first = node;
    ends.second = node;
    if (is_mine(piece)) kept.add(like_[p.chain], node);
  }
  for (Rejection& mark : kept_[piece].rejections())
    if (mark == Rejection::kNoPose) mark = Rejection::kUsed;
  return ends;
}

/// The ends when the parameters go to x.
std::vector<Node> DrivePasses::ends_at(const Eigen::VectorXd& x) const {
  std::vector<Node> ends = from_.state;
  if (from_.chains.empty()) return ends;
  std::vector<std::vector<NodeVector>> steps;
  for (const EndChain& chain : from_.chains) steps.push_back(chain.steps(x - from_.x));
  std::vector<std::size_t> next(steps.size(), 0);
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const std::size_t c = index_.pieces()[k].chain;
    if (!index_.pieces()[k].open_right || next[c] >= steps[c].size()) continue;
    step_node(like_[c], steps[c][next[c]++], ends[k]);
  }
  return ends;
}

/// Solves for the states of a piece with plain squares and fixed ends, marks arrivals as requested, and
/// reduces it.
void DrivePasses::solve_states(const DrivePiece& piece, const ParameterLayout& layout,
                               const SharedState& state, RejectionPolicy policy, PassCounts& counts,
                               DriveWork& w, OpenChain& out) const {
  Trajectory& t = w.t();
  const Segment& segment = t.segments.front();
  const StateSolveOptions held{
      .tolerance = kPieceAtRest, .hold_first = piece.open_left, .hold_last = piece.open_right};
  const auto mark = [&] { return reject_outliers(w.trajectory, state, task_.options.rejection_sigmas); };
  if (policy == RejectionPolicy::kFirst) counts.changed = mark();
  counts.cost_before = octant::solve_states(t, segment, state, {}, held).cost;
  if (policy == RejectionPolicy::kConverged) {
    counts.changed = mark();
    if (counts.changed > 0) static_cast<void>(octant::solve_states(t, segment, state, {}, held));
  }
  const std::vector<int> columns = all_columns(layout.size());
  out.has_left = piece.open_left;
  out.has_right = piece.open_right;
  ChainReduction(t, layout, {0}).reduce_open(segment, state, {}, columns, columns.size(), out);
}

Result<PassSum> DrivePasses::pass(const Estimate& estimate, RejectionPolicy policy) {
  const SharedState state = estimate.state();
  tried_.state = ends_at(estimate.x);
  JoinedEnds joined(*this, estimate.layout.size());
  std::vector<PassCounts> counts(kept_.size());
  auto done = for_each_piece(false, [&](std::size_t k, DriveWork& w) {
    restore(k, estimate, tried_.state, w);
    OpenChain system;
    if (w.t().nodes.front().placed)
      solve_states(*w.piece, estimate.layout, state, policy, counts[k], w, system);
    counts[k].of_log = count_observations(w.t(), state, 1, false);
    // The share of the poses in the redundancy is that of the piece alone, which is too small by a few
    // thousandths.
    counts[k].poses = squares_of_poses(w.t(), state);
    if (w.piece->open_left && w.t().nodes.front().placed)  // told before
      counts[k].of_log.states -= static_cast<std::size_t>(block_size());
    joined.add(k, system);
    kept_[k].keep(w.t());
  });
  if (!done) return fail(done.error());
  tried_.x = estimate.x;
  tried_.chains = std::move(joined).chains();
  PassSum sum;
  SystemPart all = empty_part(all_columns(estimate.layout.size()));
  for (const EndChain& chain : tried_.chains) chain.add_to(all.system);
  sum.system.add(all);
  for (const PassCounts& c : counts) sum.counts.add(c);
  sum_over(task_.options.ranks, sum.counts);
  for (const DriveChain& chain : index_.chains()) sum.counts.of_log.rejected += chain.stateless_count;
  return sum;
}

Result<void> DrivePasses::gather(const Estimate& estimate, FindingsGatherer& gatherer) {
  std::vector<std::vector<double>> buffers(kept_.size());
  auto done = for_each_piece(false, [&](std::size_t k, DriveWork& w) {
    restore(k, estimate, from_.state, w);
    const Trajectory& t = w.t();
    std::vector<Segment> some;
    for (std::size_t u = w.piece->first_unit; u < w.piece->last_unit; ++u) {
      if (u % gatherer.stride() != 0) continue;
      const std::size_t first = (u - w.piece->first_unit) * kUnitNodes;
      some.push_back(stretch_of(t, t.segments.front(), first, std::min(first + kUnitNodes, t.nodes.size())));
    }
    TrajectoryFindings part{t, w.log, pick_segments(t, some)};
    for (const Segment& s : part.sampled.segments)
      if (part.sampled.nodes[s.first_node].placed)
        octant::solve_states(part.sampled, s, gatherer.state(), {});
    if (w.piece->open_left && t.nodes.front().placed)
      part.counted_before = static_cast<std::size_t>(block_size());
    gatherer.write(part, buffers[k]);
  });
  if (!done) return done;
  gatherer.read(in_order(task_.options.ranks, std::move(buffers)));
  for (const DriveChain& chain : index_.chains())
    for (std::size_t b = 0; b < chain.stateless.size(); ++b) gatherer.count_stateless(b, chain.stateless[b]);
  return {};
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drive_passes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "calib/adjust/reject.h"
#include "calib/problem/gates.h"
#include "calib/problem/ranges.h"
#include "calib/problem/thin.h"
#include "calib/stream/drive_findings.h"
#include "calib/stream/long_log.h"
#include "calib/stream/side_by_side.h"
#include "models/trajectory/settle.h"

namespace octant::calib {
namespace {

/// A step of a piece's states that gains a smaller share of their cost is the last; the reduction takes the
/// next one with it.
constexpr double kPieceAtRest = 1e-9;

/// Pieces of chains, added up in their order, whoever is first.
class OrderedEnds {
 public:
  OrderedEnds(const DriveIndex& index, Eigen::Index parameters)
      : index_(index), chains_(index.chains().size(), EndChain(parameters)) {}
  void add(std::size_t piece, const OpenChain& system) {
    const std::lock_guard lock(mutex_);
    if (piece != next_) {
      waiting_.emplace(piece, system);
      return;
    }
    take(system);
    for (auto at = waiting_.find(next_); at != waiting_.end(); at = waiting_.find(next_)) {
      take(at->second);
      waiting_.erase(at);
    }
  }
  std::vector<EndChain> chains() && { return std::move(chains_); }

 private:
  void take(const OpenChain& system) {
    if (system.H.size() > 0) chains_[index_.pieces()[next_].chain].append(system);
    ++next_;
  }
  const DriveIndex& index_;
  std::mutex mutex_;
  std::size_t next_ = 0;
  std::vector<EndChain> chains_;
  std::map<std::size_t, OpenChain> waiting_;
};

}  // namespace

/// Of a piece in a pass.
struct DrivePasses::Numbers {
  double cost_before = 0.0;
  std::size_t changed = 0;
  ObservationCounts counts;
};

DrivePasses::DrivePasses(const Problem& frame, const ArrivalSource& source, const DriveIndex& index,
                         const SolveOptions& options, int workers, Course& course)
    : frame_(frame),
      source_(source),
      index_(index),
      options_(options),
      course_(course),
      model_(trajectory_model(frame.site)),
      workers_(static_cast<std::size_t>(std::max(workers, 1))),
      pieces_(index.pieces().size()) {}

/// work(piece, DriveWork&), with the piece loaded, or widened to its neighbours.
template <class Do>
Result<void> DrivePasses::for_each_piece(bool widened, Do&& work) {
  const auto load = [&](std::size_t k, std::size_t worker) -> Result<void> {
    DriveWork& w = workers_[worker];
    const std::size_t run_before = w.piece == nullptr ? SIZE_MAX : index_.chains()[w.piece->chain].run;
    w.piece = &index_.pieces()[k];
    const DrivePiece piece = widened ? index_.widened(*w.piece) : *w.piece;
    const DriveChain& chain = index_.chains()[piece.chain];
    if (run_before != chain.run) {
      begin_run(source_.log(chain.run), w.log);
    }
    if (auto ok = index_.read(source_, piece, w.log); !ok) return ok;
    w.trajectory.clear();
    w.trajectory.push_back(make_trajectory(w.log, chain.run, chain.vehicle, model_));
    if (w.t().arrivals.size() != piece.arrivals || w.t().nodes.size() != piece.nodes)
      return fail(changed_while_read(w.log));
    work(k, w);
    return {};
  };
  return for_each_side_by_side(0, pieces_.size(), workers_.size(), course_, load);
}

void DrivePasses::restore(std::size_t piece, double sigma_s, const std::vector<KeptState>& ends,
                          DriveWork& w) const {
  Trajectory& t = w.t();
  for (std::size_t k = 0; k < t.nodes.size(); ++k) put_state(pieces_[piece].state[k], t.nodes[k]);
  if (w.piece->open_left) put_state(ends[piece - 1], t.nodes.front());
  if (w.piece->open_right) put_state(ends[piece], t.nodes.back());
  for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
    t.arrivals[i].rejection = pieces_[piece].marks[i];
    t.arrivals[i].sigma_s = sigma_s;
  }
}

/// The piece's own, from these on.
void DrivePasses::keep(std::size_t piece, const DriveWork& w, std::size_t first_node,
                       std::size_t first_arrival) {
  PieceStates& kept = pieces_[piece];
  kept.state.clear();
  kept.marks.clear();
  kept.state.reserve(w.piece->nodes);
  kept.marks.reserve(w.piece->arrivals);
  for (std::size_t k = 0; k < w.piece->nodes; ++k)
    kept.state.push_back(kept_state(w.t().nodes[first_node + k]));
  for (std::size_t i = 0; i < w.piece->arrivals; ++i)
    kept.marks.push_back(w.t().arrivals[first_arrival + i].rejection);
}

Result<LogReadings::Placed> DrivePasses::place(const Estimate& estimate, double /*suspect_sigmas*/,
                                               bool /*mark*/) {
  const SharedState state = estimate.state();
  const SpreadArrivals spread(index_.arrivals(), state, prior_state(frame_.site));
  std::vector<std::vector<double>> residuals(pieces_.size()), ranges(pieces_.size());
  // What is heard before and behind a piece tells its ends as well.
  const auto done = for_each_piece(true, [&](std::size_t k, DriveWork& w) {
    apply_gates(frame_.site, w.trajectory, 1);
    place_all_drives(frame_, state, estimate.beacon_usable, 1, w.trajectory);
    const Trajectory& t = w.t();
    const std::size_t first_node = w.piece->open_left ? kUnitNodes : 0;
    const auto first_arrival = static_cast<std::size_t>(
        std::partition_point(t.arrivals.begin(), t.arrivals.end(),
                             [&](const ArrivalObservation& a) { return a.node < first_node; }) -
        t.arrivals.begin());
    for (std::size_t i = 0; i < w.piece->arrivals; ++i)
      spread.look_at(w.piece->arrivals_before + i, t, t.arrivals[first_arrival + i], residuals[k], ranges[k]);
    keep(k, w, first_node, first_arrival);
  });
  if (!done) return fail(done.error());
  join_pieces();
  Placed placed;
  for (const auto& some : residuals)
    placed.residuals.insert(placed.residuals.end(), some.begin(), some.end());
  for (const auto& some : ranges) placed.ranges_m.insert(placed.ranges_m.end(), some.begin(), some.end());
  return placed;
}

/// What no arrivals could place odometry reaches from a neighbour; neighbours then agree about the state that
/// they share.
void DrivePasses::join_pieces() {
  const std::vector<DrivePiece>& pieces = index_.pieces();
  const auto none = [&](std::size_t k) { return !has_place(pieces_[k].state.front()); };
  for (std::size_t k = 1; k < pieces.size(); ++k)
    if (pieces[k].open_left && none(k) && !none(k - 1)) reach_by_odometry(k, true);
  for (std::size_t k = pieces.size(); k-- > 0;)
    if (pieces[k].open_right && none(k) && !none(k + 1)) reach_by_odometry(k, false);
  tried_ = {};
  tried_.state.assign(pieces.size(), {NAN, NAN, NAN});
  for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
    if (!pieces[k].open_right || none(k)) continue;
    const KeptState &here = pieces_[k].state.back(), &there = pieces_[k + 1].state.front();
    tried_.state[k] = {0.5 * (here[0] + there[0]), 0.5 * (here[1] + there[1]),
                       here[2] + 0.5 * wrap_angle(there[2] - here[2])};
  }
  from_ = tried_;
}

void DrivePasses::reach_by_odometry(std::size_t piece, bool forward) {
  const DrivePiece& p = index_.pieces()[piece];
  const DriveChain& chain = index_.chains()[p.chain];
  const std::vector<OdometryStep>& rows = source_.log(chain.run).odometry;
  std::vector<Pose> path = {Pose()};
  for (std::size_t row = chain.units[p.first_unit].first_row + 1; row < rows.size() && path.size() < p.nodes;
       ++row)
    if (rows[row].vehicle == chain.vehicle)
      path.push_back(path.back() * Pose::planar(rows[row].dx_m, rows[row].dy_m, rows[row].dheading_rad));
  const Pose T_map_path = forward ? pose_of(pieces_[piece - 1].state.back())
                                  : pose_of(pieces_[piece + 1].state.front()) * path.back().inverse();
  PieceStates& kept = pieces_[piece];
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Pose T = T_map_path * path[k];
    kept.state[k] = {T.translation_m.x(), T.translation_m.y(), T.heading_rad()};
  }
  for (Rejection& mark : kept.marks)
    if (mark == Rejection::kNoPose) mark = Rejection::kUsed;
}

/// The ends when the parameters go to x.
std::vector<KeptState> DrivePasses::ends_at(const Eigen::VectorXd& x) const {
  std::vector<KeptState> ends = from_.state;
  if (from_.chains.empty()) return ends;
  std::vector<std::vector<Eigen::Vector3d>> steps;
  for (const EndChain& chain : from_.chains) steps.push_back(chain.steps(x - from_.x));
  std::vector<std::size_t> next(steps.size(), 0);
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const std::size_t c = index_.pieces()[k].chain;
    if (!index_.pieces()[k].open_right || next[c] >= steps[c].size()) continue;
    const Eigen::Vector3d& step = steps[c][next[c]++];
    for (std::size_t i = 0; i < 3; ++i) ends[k][i] += step[static_cast<Eigen::Index>(i)];
  }
  return ends;
}

/// Settles the states of a piece with plain squares, its ends held, marks arrivals as asked, and reduces it.
void DrivePasses::settle(const DrivePiece& piece, const ParameterLayout& layout, const SharedState& state,
                         MarkPolicy marks, Numbers& numbers, DriveWork& w, OpenChain& out) const {
  Trajectory& t = w.t();
  const Segment& segment = t.segments.front();
  const SettleOptions held{
      .tolerance = kPieceAtRest, .hold_first = piece.open_left, .hold_last = piece.open_right};
  const auto mark = [&] { return mark_rejected(w.trajectory, state, options_.rejection_sigmas); };
  if (marks == MarkPolicy::kFirst) numbers.changed = mark();
  numbers.cost_before = octant::settle(t, segment, state, {}, held).cost;
  if (marks == MarkPolicy::kSettled) {
    numbers.changed = mark();
    if (numbers.changed > 0) static_cast<void>(octant::settle(t, segment, state, {}, held));
  }
  std::vector<int> columns(static_cast<std::size_t>(layout.size()));
  std::iota(columns.begin(), columns.end(), 0);
  out.has_left = piece.open_left;
  out.has_right = piece.open_right;
  ChainReduction(t, layout, {0}).reduce_open(segment, state, {}, columns, columns.size(), out);
}

Result<PassSum> DrivePasses::pass(const Estimate& estimate, MarkPolicy marks) {
  const SharedState state = estimate.state();
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  tried_.state = ends_at(estimate.x);
  OrderedEnds joined(index_, estimate.layout.size());
  std::vector<Numbers> numbers(pieces_.size());
  const auto done = for_each_piece(false, [&](std::size_t k, DriveWork& w) {
    restore(k, sigma_s, tried_.state, w);
    OpenChain system;
    if (w.t().nodes.front().placed) settle(*w.piece, estimate.layout, state, marks, numbers[k], w, system);
    numbers[k].counts = count_observations(w.t(), state, 1, false);
    if (w.piece->open_left && w.t().nodes.front().placed) numbers[k].counts.states -= 3;  // told before
    joined.add(k, system);
    keep(k, w, 0, 0);
  });
  if (!done) return fail(done.error());
  tried_.x = estimate.x;
  tried_.chains = std::move(joined).chains();
  PassSum sum;
  sum.system.H.setZero(estimate.layout.size(), estimate.layout.size());
  sum.system.gradient.setZero(estimate.layout.size());
  for (const EndChain& chain : tried_.chains) chain.add_to(sum.system);
  for (const Numbers& n : numbers) {
    sum.cost_before += n.cost_before;
    sum.changed += n.changed;
    sum.counts.add(n.counts);
  }
  for (const DriveChain& chain : index_.chains()) sum.counts.rejected += chain.stateless_count;
  return sum;
}

Result<LogFindings> DrivePasses::findings(const Estimate& estimate) {
  DriveFindings gatherer(frame_, index_, estimate);
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  const auto done = for_each_piece(false, [&](std::size_t k, DriveWork& w) {
    restore(k, sigma_s, from_.state, w);
    gatherer.take(k, w);
  });
  if (!done) return fail(done.error());
  return std::move(gatherer).findings();
}

}  // namespace octant::calib

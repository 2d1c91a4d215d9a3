// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/revisit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/errors/statistics.h"
#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
#include "calib/revisit/as_left.h"
#include "calib/revisit/revisited_site.h"
#include "calib/revisit/stretches.h"
#include "calib/revisit/visit_information.h"
#include "calib/start/approach.h"
#include "calib/start/start.h"
#include "calib/stream/long_log.h"
#include "calib/verdict/conclude.h"
#include "calib/verdict/observability.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr int kRounds = 4;
/// Arrivals of a drive that tell what changed as well as all do; the rest only makes it sharper.
constexpr std::size_t kEnoughArrivals = 3'000;
constexpr int kPassesOfAll = 2;
constexpr double kRangeUncertaintyM =
    0.05;  ///< by which ranges may be off while a drive is tracked by what was known
constexpr std::size_t kFewestRanges = 10;  ///< that locate a beacon
/// Of the air where no thermometer was read: some ten degrees.
constexpr double kUnknownTemperature_mps = 6.0;
constexpr std::size_t kMostReconsidered = 3;  ///< beacons one by one: each is an adjustment
/// Changes that chance makes less often leave something unexplained.
constexpr double kUnexplained = 1.0e-4;

class SecondVisit {
 public:
  SecondVisit(const Deployment& before, const RevisitOptions& options)
      : before_(before),
        options_(options),
        known_(known_parameters(before)),
        began_(Clock::now()),
        monitor_(options.solve) {}

  Result<Revisit> run(std::vector<MeasurementLog> runs) {
    out_.medium = thermometer_of(before_, runs);
    out_.drift = options_.drift;
    if (!out_.medium.temperature_known)
      out_.drift.speed_mps = std::hypot(out_.drift.speed_mps, kUnknownTemperature_mps);
    drift_ = drift_variances(known_, out_.drift);
    const Eigen::VectorXd room = room_for_change(known_);
    auto problem = make_problem(revisited_site(before_, known_, known_.covariance.diagonal() + drift_ + room),
                                std::move(runs), options_.solve.threads);
    if (!problem) return fail(problem.error());
    problem_ = std::move(*problem);
    if (is_long(problem_) && has_stops_alone(problem_))
      if (Result<Problem> part = subsample_of(problem_, options_.solve.threads)) problem_ = std::move(*part);
    out_.warnings = problem_.warnings;
    std::optional<Problem> part;
    if (std::vector<MeasurementLog> some = evenly_spread_stretches(problem_.runs, kEnoughArrivals);
        !some.empty())
      if (auto made = make_problem(problem_.site, std::move(some), options_.solve.threads))
        part = std::move(*made);
    if ((start_from_known(part ? *part : problem_, room) || start(part ? *part : problem_)) &&
        find_changes(room) && (!part || refine_on_all_arrivals()))
      conclude_visit();
    out_.seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    return std::move(out_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// Where the adjustment stands.
  struct Standing {
    Fit fit;
    CalibrationStatistics statistics;
    double sigma_s = 0.0;  ///< noise of the arrivals as found
    [[nodiscard]] double squares() const { return fit.cost * sigma_s * sigma_s; }
  };

  bool stopped() {
    out_.status = SolveStatus::kInterrupted;
    out_.message = "stopped";
    return false;
  }

  void set_start(const Problem& problem, const SharedState& state, std::vector<bool> usable,
                 std::vector<Trajectory> trajectories) {
    layout_ = make_layout(problem, state, usable);
    now_.fit = Fit();
    now_.fit.problem = without_recordings(problem);
    now_.fit.x = layout_.vector_of(state);
    now_.fit.layout = layout_;
    now_.fit.beacon_usable = std::move(usable);
    now_.fit.trajectories = std::move(trajectories);
    now_.sigma_s = problem.site.noise.tof_sigma_s;
  }

  /// States are placed by what was known: most of it still holds, and a beacon that hangs elsewhere
  /// altogether is then located by its ranges. False where that leads nowhere.
  bool start_from_known(const Problem& problem, const Eigen::VectorXd& room) {
    if (!monitor_.report("initial values", 0.02)) return false;
    const SharedState state = shared_state(before_);
    std::vector<bool> usable;
    for (const DeploymentBeacon& b : before_.beacons)
      usable.push_back(b.status != BeaconStatus::kUndetermined);
    set_start(problem, state, std::move(usable), problem.trajectories);
    static_cast<void>(place_missing());
    const auto is_placed = [](const Node& n) { return n.placed; };
    if (std::ranges::none_of(now_.fit.trajectories,
                             [&](const Trajectory& t) { return std::ranges::any_of(t.nodes, is_placed); }))
      return false;
    const Eigen::MatrixXd P = drifted() + Eigen::MatrixXd(room.asDiagonal());
    if (!adjust_under(P)) return false;
    if (place_missing() && !adjust_under(P)) return false;
    locate_lost();
    return true;
  }

  /// States that have no value, by the parameters as they stand. In other air many are missed at first.
  bool place_missing() {
    const EpochFixModel model = search_model(now_.fit.problem, now_.fit.state(), now_.fit.beacon_usable);
    std::size_t placed = 0;
    for (Trajectory& t : now_.fit.trajectories)
      placed += place_states(t, model, kRangeUncertaintyM, false, 0.0, options_.solve.threads);
    return placed > 0;
  }

  /// A beacon at another place, with the delay that it had.
  void put(std::size_t b, const Eigen::Vector3d& p_map_m) {
    layout_.set_place(b, p_map_m, now_.fit.x);
    if (const int c = layout_.column_of(parameters::beacon_delay(b)); c >= 0)
      now_.fit.x[c] = before_.beacons[b].delay_s / layout_.parameter(c).si_per_unit;
  }

  /// Beacons most of whose arrivals do not fit, from the vehicle's states by their own ranges.
  /// @return whether one was placed anew
  bool locate_lost() {
    bool any = false;
    const std::vector<RejectionCounts> counts =
        rejections_by_beacon(now_.fit.trajectories, before_.beacons.size());
    const SharedState state = now_.fit.state();
    for (std::size_t b = 0; b < counts.size(); ++b) {
      const std::size_t used = counts[b].of(Rejection::kUsed);
      if (counts[b].outliers() <= std::max(used, kFewestRanges) || layout_.beacon[b][0] < 0) continue;
      TrilaterationOptions options;
      options.guess = before_.beacons[b].position_m;
      options.scale_m = 0.01 * now_.fit.problem.typical_range_m;
      options.above = before_.motion == Motion::kPlanar;
      const Trilateration found = trilaterate(ranges_to(now_.fit.trajectories, state, BeaconId(b)), options);
      if (!found.ok) continue;
      any = true;
      put(b, found.p_map_m);
    }
    return any;
  }

  /// Holds beacons where they hung before; takes that back unless it explains more.
  [[nodiscard]] bool hold(const std::vector<std::size_t>& beacons, Standing& best, Eigen::MatrixXd& room) {
    Eigen::MatrixXd held = room;
    for (const std::size_t b : beacons) put(b, before_.beacons[b].position_m);
    for (Eigen::Index i = 0; i < known_.size(); ++i)
      for (const std::size_t b : beacons)
        if (beacon_of(known_.parameters[static_cast<std::size_t>(i)]) == b) held(i, i) = 0.0;
    const bool better = adjust_under(drifted() + held) && now_.squares() < best.squares();
    if (better) {
      best = now_;
      room = std::move(held);
    } else {
      now_ = best;
    }
    return better;
  }

  /// A beacon that is heard by a few stops of one side alone, and some of whose arrivals are echoes, may
  /// trade its place for its delay. Those that lost many arrivals are held where they hung before, all at
  /// once or else the most doubtful one by one, and stay held if that leaves less unexplained: a beacon that
  /// did move would lose most of them.
  /// @param room  of changes beside the drift  @return the room that is left
  [[nodiscard]] Eigen::MatrixXd reconsidered(Eigen::MatrixXd room) {
    std::vector<std::size_t> doubtful = doubtful_beacons(before_, now_.fit.trajectories);
    if (doubtful.empty()) return room;
    Standing best = now_;
    if (hold(doubtful, best, room) || doubtful.size() == 1) return room;
    doubtful.resize(std::min(doubtful.size(), kMostReconsidered));
    for (const std::size_t b : doubtful) static_cast<void>(hold({b}, best, room));
    return room;
  }

  /// Approximate states and parameters, by what the largest consensus of arrivals agrees on.
  bool start(const Problem& problem) {
    Approach found = approach(problem, options_.solve, monitor_, false);
    if (!found.ok) {
      out_.status = found.why_not.status;
      out_.message = found.why_not.message;
      if (!found.why_not.weak.empty()) out_.remedy = found.why_not.weak.front().remedy;
      return false;
    }
    const SharedState state = found.estimate.state();
    set_start(problem, state, std::move(found.estimate.beacon_usable), std::move(found.trajectories));
    const double factor = agreeing_sigma(now_.fit.trajectories, state);
    if (is_far_off(factor)) scale_noise(factor);
    return true;
  }

  void scale_noise(double factor) {
    rescale_noise(now_.fit.trajectories, now_.sigma_s, factor * now_.sigma_s);
    now_.sigma_s *= factor;
  }

  /// What the approach found farther away than there is room for gets that much room.
  [[nodiscard]] Eigen::VectorXd room_around(Eigen::VectorXd room) const {
    const std::vector<int> columns = columns_of(layout_, known_);
    for (Eigen::Index i = 0; i < known_.size(); ++i) {
      const int c = columns[static_cast<std::size_t>(i)];
      if (c < 0 || !(room[i] > 0)) continue;
      const double off = now_.fit.x[c] * layout_.parameter(c).si_per_unit - known_.value[i];
      room[i] = std::max(room[i], off * off);
    }
    return room;
  }

  /// Adjusts with all arrivals admitted, the noise as found.
  bool adjust_under(const Eigen::MatrixXd& P) {
    now_.fit.layout = layout_;
    set_joint_prior(now_.fit.layout, known_, P);
    const auto adjusted = adjust_and_scale_noise(
        [this]() -> std::optional<DataSquares> {
          adjust_anew(options_.solve, now_.fit);
          if (!now_.fit.ok || !now_.fit.x.allFinite()) return {};
          now_.statistics = statistics_of(now_.fit.problem, now_.fit.layout, now_.fit.trajectories,
                                          now_.fit.state(), now_.fit.last.cost, options_.solve.threads);
          const double prior = prior_cost(now_.fit.problem, now_.fit.layout, now_.fit.x);
          return DataSquares{now_.fit.last.cost - prior, now_.statistics.redundancy};
        },
        [this](const NoiseFactors& factors) { scale_noise(factors.arrivals); });
    if (!adjusted)
      out_.message = "the adjustment of the second visit did not converge: " + now_.fit.last.message;
    return adjusted.has_value();
  }

  bool find_changes(const Eigen::VectorXd& usual_room) {
    Eigen::MatrixXd room = room_around(usual_room).asDiagonal();
    Released released;
    const Eigen::MatrixXd prior = drifted();
    for (int round = 0; round < kRounds; ++round) {
      if (!monitor_.report("what changed", 0.7 + 0.05 * round)) return stopped();
      if (!adjust_under(prior + room)) return false;
      if (round == 0 && locate_lost()) {  // one that hangs metres away may have ended at its mirror image
        room = room_around(usual_room).asDiagonal();
        if (!adjust_under(prior + room)) return false;
      }
      if (turn_to_known_side(before_, layout_, now_.fit.x) && !adjust_under(prior + room)) return false;
      if (round == 0) room = reconsidered(std::move(room));
      visit_ = visit_information(now_.fit, known_, prior + room, before_, options_.solve.threads);
      out_.comparison = compare(before_, known_, innovation_of_information(prior, visit_.N, visit_.gradient));
      Released found = changed_parameters(out_.comparison, known_);
      if (round > 0 && found == released) break;
      released = std::move(found);
      room = released_covariance(known_, released, before_.motion);
    }
    return true;
  }

  /// What was known, and how it may have drifted.
  [[nodiscard]] Eigen::MatrixXd drifted() const {
    Eigen::MatrixXd P = known_.covariance;
    P.diagonal() += drift_;
    return P;
  }

  /// The whole drive from where a part of it has put the parameters: they are good to a fraction of the
  /// noise, so that states are placed and solved once and one linearisation does, repeated where that has
  /// moved them.
  bool refine_on_all_arrivals() {
    if (!monitor_.report("the whole recording", 0.9)) return stopped();
    now_.fit.problem.runs.resize(problem_.runs.size());
    now_.fit.trajectories = problem_.trajectories;
    rescale_noise(now_.fit.trajectories, problem_.site.noise.tof_sigma_s, now_.sigma_s);
    const EpochFixModel model = search_model(problem_, now_.fit.state(), now_.fit.beacon_usable);
    for (Trajectory& t : now_.fit.trajectories)
      static_cast<void>(place_states(t, model, 0.0, false, 0.0, options_.solve.threads));
    readmit_all(now_.fit.trajectories, now_.fit.beacon_usable);
    const bool known_white = !visit_.correlated;
    const Eigen::MatrixXd prior = drifted();
    for (int pass = 0; pass < kPassesOfAll; ++pass) {
      // The error model is of the residuals that white weights leave: it is told once, where these have led,
      // and until then what changed stays what the part has shown.
      const bool last = pass + 1 == kPassesOfAll;
      const SharedState state = now_.fit.state();
      solve_all_states(state, pass == 0 ? kCauchyScale : 0.0);
      reject_outliers(now_.fit.trajectories, state, options_.solve.rejection_sigmas, options_.solve.threads);
      const Eigen::MatrixXd P =
          prior + released_covariance(known_, changed_parameters(out_.comparison, known_), before_.motion);
      set_joint_prior(now_.fit.layout = layout_, known_, P);
      visit_ = visit_information(now_.fit, known_, P, before_, options_.solve.threads, known_white || !last);
      if (known_white || last)
        out_.comparison =
            compare(before_, known_, innovation_of_information(prior, visit_.N, visit_.gradient));
      move_to(known_.value + updated_by(P, visit_.N, visit_.gradient).step);
    }
    now_.statistics = statistics_of(now_.fit.problem, now_.fit.layout, now_.fit.trajectories,
                                    now_.fit.state(), data_cost(), options_.solve.threads);
    return true;
  }

  void solve_all_states(const SharedState& state, double scale) {
    for (Trajectory& t : now_.fit.trajectories)
      for_each_parallel(t.segments.size(), options_.solve.threads, [&](std::size_t s) {
        if (t.nodes[t.segments[s].first_node].placed) solve_states(t, t.segments[s], state, {scale, scale});
      });
  }

  /// Of all arrivals and priors where the fit stands.
  [[nodiscard]] double data_cost() const {
    double cost = prior_cost(now_.fit.problem, now_.fit.layout, now_.fit.x);
    const SharedState state = now_.fit.state();
    for (const Trajectory& t : now_.fit.trajectories)
      for (const Segment& segment : t.segments)
        if (t.nodes[segment.first_node].placed) cost += chain_cost(t, segment, state, {});
    return cost;
  }

  void move_to(const Eigen::VectorXd& value) {
    const std::vector<int> columns = columns_of(layout_, known_);
    for (Eigen::Index i = 0; i < known_.size(); ++i)
      if (const int c = columns[static_cast<std::size_t>(i)]; c >= 0)
        now_.fit.x[c] = value[i] / layout_.parameter(c).si_per_unit;
  }

  void conclude_visit() {
    AsLeft left = as_left(before_, known_, drift_, out_.comparison, visit_, tolerance_m(problem_));
    out_.as_left = std::move(left.deployment);
    out_.warnings.insert(out_.warnings.end(), left.warnings.begin(), left.warnings.end());
    out_.medium.speed_change_mps = out_.as_left.speed_offset_mps - before_.speed_offset_mps;
    out_.medium.speed_change_sigma_mps = left.speed_change_sigma_mps;
    out_.as_left.statistics = now_.statistics;
    out_.as_left.statistics.converged = true;
    extend_validity(out_.as_left, now_.fit.trajectories, problem_, out_.medium.temperature_known);
    const SharedState state = now_.fit.state();
    out_.beacons = heard_of_beacons(before_, now_.fit.trajectories, state);
    out_.receivers = heard_by_receivers(before_, now_.fit.trajectories, state);
    out_.silent = silent_beacons(before_, now_.fit.trajectories);
    for (std::string& name : silent_receivers(before_, now_.fit.trajectories))
      out_.silent.push_back(std::move(name));
    if (out_.comparison.p_left < kUnexplained)
      out_.warnings.push_back(
          fmt::format("something of this visit fits neither the earlier calibration nor the changes found (p "
                      "= {:.2g}): record again, "
                      "longer and over more of the site",
                      out_.comparison.p_left));
    out_.status = SolveStatus::kConverged;
    out_.message = "converged";
  }

  const Deployment& before_;
  const RevisitOptions& options_;
  KnownParameters known_;
  Clock::time_point began_;
  ProgressMonitor monitor_;
  Eigen::VectorXd drift_;
  Problem problem_;
  ParameterLayout layout_;  ///< without the joint prior
  Standing now_;
  VisitInformation visit_;
  Revisit out_;
};

}  // namespace

Result<Revisit> revisit(const Deployment& before, std::vector<MeasurementLog> runs,
                        const RevisitOptions& options) {
  return SecondVisit(before, options).run(std::move(runs));
}

}  // namespace octant::calib

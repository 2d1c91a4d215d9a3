// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/revisit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calib/adjust/reject.h"
#include "calib/errors/statistics.h"
#include "calib/problem/log_totals.h"
#include "calib/revisit/as_left.h"
#include "calib/revisit/evidence.h"
#include "calib/revisit/revisited_site.h"
#include "calib/revisit/stretches.h"
#include "calib/revisit/visit_fit.h"
#include "calib/revisit/visit_information.h"
#include "calib/start/start.h"
#include "calib/stream/long_log.h"
#include "calib/verdict/conclude.h"
#include "calib/verdict/observability.h"
#include "models/changes/chi_square.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr int kRounds = 6;
/// Number of arrivals of a drive in which changes are searched; the others only improve the precision.
constexpr std::size_t kEnoughArrivals = 3'000;
constexpr int kPassesOfAll = 2;
/// Sigma of the speed if no temperature was recorded: about ten degrees.
constexpr double kUnknownTemperature_mps = 6.0;
constexpr std::size_t kMostReconsidered = 3;  ///< beacons reconsidered one by one; each needs an adjustment
/// Probability of the remaining differences below which something is unexplained.
constexpr double kUnexplained = 1.0e-4;
/// Number of arrivals that hardly determine all changes at once, so that these are tried one by one.
constexpr std::size_t kFewArrivals = 1'000;
/// Twice the log-likelihood ratio from which more changes are a better explanation than fewer.
constexpr double kClearlyBetter = 10.0;
constexpr int kMostTried = 3;  ///< maximum number of changes of a visit with few arrivals

using Standing = VisitFit::Standing;
/// Changes that may explain a visit, and the results under these changes.
struct Explanation {
  Standing standing;
  VisitInformation visit;
  Comparison comparison;
};

class SecondVisit {
 public:
  SecondVisit(const Deployment& before, const RevisitOptions& options)
      : before_(before),
        options_(options),
        known_(known_parameters(before)),
        began_(Clock::now()),
        monitor_(options.solve),
        fit_(before_, known_, options_.solve) {}

  Result<Revisit> run(std::vector<MeasurementLog> runs) {
    out_.medium = thermometer_of(before_, runs);
    out_.drift = options_.drift;
    if (!out_.medium.temperature_known)
      out_.drift.speed_mps = std::hypot(out_.drift.speed_mps, kUnknownTemperature_mps);
    drift_ = drift_variances(known_, out_.drift);
    room_ = room_for_change(known_);
    auto problem =
        make_problem(revisited_site(before_, known_, known_.covariance.diagonal() + drift_ + room_),
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
    if (find_best_explanation(part ? *part : problem_) && (!part || refine_on_all_arrivals()))
      conclude_visit();
    out_.seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    return std::move(out_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool stopped() {
    out_.status = SolveStatus::kInterrupted;
    out_.message = "stopped";
    return false;
  }

  /// Compares explanations: changes found with wide priors for all of them at once; no changes, or those that
  /// follow from it; and for few arrivals those that explain most one by one. Few arrivals do not determine
  /// all changes at once, so each change must explain more than its price.
  bool find_best_explanation(const Problem& problem) {
    if (!monitor_.report("initial values", 0.02)) return stopped();
    std::optional<Standing> at_known;
    if (fit_.start_from_known(problem)) at_known = fit_.now;
    const bool is_started =
        at_known && fit_.adjust_under(drifted() + Eigen::MatrixXd(room_.asDiagonal())) && relocate();
    if (!is_started && !start_from_consensus(problem)) return false;
    std::optional<Explanation> best;
    if (find_changes_at_once()) best = explanation();
    if (at_known && !is_interrupted()) compare_with_known(std::move(*at_known), best);
    if (is_interrupted()) return false;
    if (!best) {
      out_.message = fit_.message;
      if (fit_.arrival_count() <= kFewArrivals) {
        out_.status = SolveStatus::kUndetermined;
        out_.message = "no change can be judged: " + out_.message;
        out_.remedy = "more stops, each with several arrivals of at least five beacons";
      }
      return false;
    }
    fit_.now = std::move(best->standing);
    visit_ = std::move(best->visit);
    out_.comparison = std::move(best->comparison);
    return true;
  }

  [[nodiscard]] bool is_interrupted() const { return out_.status == SolveStatus::kInterrupted; }
  bool relocate() {
    if (fit_.place_missing() && !fit_.adjust_under(drifted() + Eigen::MatrixXd(room_.asDiagonal())))
      return false;
    fit_.locate_lost();
    return true;
  }

  bool start_from_consensus(const Problem& problem) {
    const Solution found = fit_.start_from_consensus(problem, monitor_);
    if (found.status == SolveStatus::kConverged) return true;
    out_.status = found.status;
    out_.message = found.message;
    if (!found.weak.empty()) out_.remedy = found.weak.front().remedy;
    return false;
  }

  [[nodiscard]] Explanation explanation() const { return {fit_.now, visit_, out_.comparison}; }

  /// Remaining squares and price of the changes, at some noise.
  [[nodiscard]] double score(const Explanation& e, double sigma_s) const {
    return truncated_squares(e.standing.fit, options_.solve.rejection_sigmas, e.standing.sigma_s / sigma_s) +
           price_of(e.comparison.search);
  }

  /// Examines explanations that start from the earlier calibration, and selects the best of all.
  void compare_with_known(Standing at_known, std::optional<Explanation>& best) {
    fit_.now = std::move(at_known);
    if (best) fit_.scale_noise(best->standing.sigma_s / fit_.now.sigma_s);
    if (!adjust_to_known()) return;
    const Standing start = fit_.now;
    std::vector<Released> starts = {{}};
    if (fit_.arrival_count() <= kFewArrivals)
      if (Released some = changes_one_by_one(start); some != Released{}) starts.push_back(std::move(some));
    for (const Released& released : starts) {
      fit_.now = start;
      if (!explain(released, VisitFit::Noise::kFixed)) continue;
      Explanation found = explanation();
      const double margin =
          best && found.comparison.changes.size() < best->comparison.changes.size() ? kClearlyBetter : 0.0;
      if (!best || score(found, start.sigma_s) <= score(*best, start.sigma_s) + margin)
        best = std::move(found);
    }
  }

  /// Adjusts without any change. Few arrivals determine their noise only without changes.
  bool adjust_to_known() {
    const Eigen::MatrixXd prior = drifted();
    if (!fit_.adjust_under(prior, VisitFit::Noise::kFixed)) return false;
    if (fit_.place_missing() && !fit_.adjust_under(prior, VisitFit::Noise::kFixed)) return false;
    const double factor = agreeing_sigma(fit_.now.fit.trajectories, fit_.now.fit.state());
    if (!is_far_off(factor)) return true;
    fit_.scale_noise(factor);
    return fit_.adjust_under(prior, VisitFit::Noise::kFixed);
  }

  /// Changes that explain most when each is released alone, added one by one.
  [[nodiscard]] Released changes_one_by_one(const Standing& start) {
    const double limit = options_.solve.rejection_sigmas;
    const std::vector<ChangeHypothesis> hypotheses = change_hypotheses(known_);
    Released released;
    Standing from = start;
    for (int k = 0; k < kMostTried; ++k) {
      double best = truncated_squares(from.fit, limit, 1.0);
      std::optional<Standing> better;
      Released with_better;
      for (const ChangeHypothesis& h : hypotheses) {
        const auto freedoms = static_cast<int>(h.columns.size());
        const double price =
            chi_square_beyond(kFalseAlarm / static_cast<double>(hypotheses.size()), freedoms);
        if (possible_gain(from.fit, h, limit) < price) continue;
        Released with = released;
        for (const int i : h.columns)
          with.parameters.push_back(known_.parameters[static_cast<std::size_t>(i)]);
        fit_.now = from;
        if (!fit_.adjust_under(drifted() + released_covariance(known_, with, before_.motion),
                               VisitFit::Noise::kFixed))
          continue;
        const double left = truncated_squares(fit_.now.fit, limit, 1.0) + price;
        if (left >= best || !is_supported(fit_.now.fit, before_, h, limit)) continue;
        best = left;
        better = fit_.now;
        with_better = std::move(with);
      }
      if (!better) break;
      from = std::move(*better);
      released = std::move(with_better);
    }
    return released;
  }

  /// Fixes beacons at their earlier positions; undoes this unless it explains more.
  [[nodiscard]] bool hold(const std::vector<std::size_t>& beacons, Standing& best, Eigen::MatrixXd& room) {
    Eigen::MatrixXd held = room;
    for (const std::size_t b : beacons) fit_.put(b, before_.beacons[b].position_m);
    for (Eigen::Index i = 0; i < known_.size(); ++i)
      for (const std::size_t b : beacons)
        if (beacon_of(known_.parameters[static_cast<std::size_t>(i)]) == b) held(i, i) = 0.0;
    const bool better = fit_.adjust_under(drifted() + held) && fit_.now.squares() < best.squares();
    if (better) {
      best = fit_.now;
      room = std::move(held);
    } else {
      fit_.now = best;
    }
    return better;
  }

  /// A beacon received at a few stops on one side only, with some echoes, may exchange position for delay.
  /// Beacons that lost many arrivals are fixed at their earlier positions, all at once or else the most
  /// doubtful one by one. They remain fixed if less is unexplained: a beacon that did move would lose most of
  /// them.
  /// @param room  variances of changes in addition to the drift
  /// @return the remaining variances
  [[nodiscard]] Eigen::MatrixXd reconsidered(Eigen::MatrixXd room) {
    std::vector<std::size_t> doubtful = doubtful_beacons(before_, fit_.now.fit.trajectories);
    if (doubtful.empty()) return room;
    Standing best = fit_.now;
    if (hold(doubtful, best, room) || doubtful.size() == 1) return room;
    doubtful.resize(std::min(doubtful.size(), kMostReconsidered));
    for (const std::size_t b : doubtful) static_cast<void>(hold({b}, best, room));
    return room;
  }

  /// Finds changes with wide priors for all of them, and then only for these.
  bool find_changes_at_once() {
    if (!monitor_.report("what changed", 0.7)) return stopped();
    const Eigen::MatrixXd prior = drifted();
    Eigen::MatrixXd room = fit_.room_around(room_).asDiagonal();
    if (!fit_.adjust_under(prior + room)) return false;
    if (fit_.locate_lost()) {  // a beacon metres away may have converged to its mirror image
      room = fit_.room_around(room_).asDiagonal();
      if (!fit_.adjust_under(prior + room)) return false;
    }
    if (turn_to_known_side(before_, fit_.now.layout, fit_.now.fit.x) && !fit_.adjust_under(prior + room))
      return false;
    room = reconsidered(std::move(room));
    look_for_changes(prior + room);
    return explain(changed_parameters(out_.comparison, known_), VisitFit::Noise::kAsFound);
  }

  /// Computes the information of the visit at the current fit under a prior P, and searches for changes.
  void look_for_changes(const Eigen::MatrixXd& P, bool known_white = false, bool again = true) {
    visit_ = visit_information(fit_.now.fit, known_, P, before_, options_.solve.threads, known_white);
    if (again) compare_visits();
  }

  void compare_visits() {
    const auto is_possible = [this](const ChangeHypothesis& h) {
      return std::ranges::none_of(
          unsupported_, [&h](const ChangeHypothesis& u) { return u.kind == h.kind && u.owner == h.owner; });
    };
    out_.comparison = compare(before_, known_,
                              innovation_of_information(drifted(), visit_.N, visit_.gradient), is_possible);
  }

  /// Adjusts with some changes released and searches again, until the same ones are found. A change that only
  /// a single stop supports is not searched again.
  bool explain(Released released, VisitFit::Noise noise) {
    for (int round = 1; round < kRounds; ++round) {
      if (!monitor_.report("what changed", 0.7 + 0.05 * round)) return stopped();
      const Eigen::MatrixXd P = drifted() + released_covariance(known_, released, before_.motion);
      if (!fit_.adjust_under(P, noise)) return false;
      if (turn_to_known_side(before_, fit_.now.layout, fit_.now.fit.x) && !fit_.adjust_under(P, noise))
        return false;
      look_for_changes(P);
      Released found = changed_parameters(out_.comparison, known_);
      if (found == released && !forget_unsupported()) break;
      released = changed_parameters(out_.comparison, known_);
    }
    return true;
  }

  /// Removes changes that only a single stop supports from the search.
  /// @return true if there were any
  bool forget_unsupported() {
    const std::size_t count = unsupported_.size();
    for (const std::size_t k : out_.comparison.search.held())
      if (const ChangeHypothesis& h = out_.comparison.hypotheses[k];
          !is_supported(fit_.now.fit, before_, h, options_.solve.rejection_sigmas))
        unsupported_.push_back(h);
    if (unsupported_.size() == count) return false;
    compare_visits();
    return true;
  }

  /// Prior covariance including the drift.
  [[nodiscard]] Eigen::MatrixXd drifted() const {
    Eigen::MatrixXd P = known_.covariance;
    P.diagonal() += drift_;
    return P;
  }

  /// Adjusts the whole drive, starting from the parameters of its part. These are accurate to a fraction of
  /// the noise, so states are solved once and one linearisation suffices, repeated if it moved them.
  bool refine_on_all_arrivals() {
    if (!monitor_.report("the whole recording", 0.9)) return stopped();
    fit_.now.fit.problem.runs.resize(problem_.runs.size());
    fit_.now.fit.trajectories = problem_.trajectories;
    rescale_noise(fit_.now.fit.trajectories, problem_.site.noise.tof_sigma_s, fit_.now.sigma_s);
    const EpochFixModel model = search_model(problem_, fit_.now.fit.state(), fit_.now.fit.beacon_usable);
    for (Trajectory& t : fit_.now.fit.trajectories)
      static_cast<void>(place_states(t, model, 0.0, false, 0.0, options_.solve.threads));
    readmit_all(fit_.now.fit.trajectories, fit_.now.fit.beacon_usable);
    const bool known_white = !visit_.correlated;
    const Eigen::MatrixXd prior = drifted();
    for (int pass = 0; pass < kPassesOfAll; ++pass) {
      // The error model is estimated once, from the residuals of the last pass. Until then the changes remain
      // those of the part.
      const bool last = pass + 1 == kPassesOfAll;
      const SharedState state = fit_.now.fit.state();
      fit_.solve_all_states(pass == 0 ? kCauchyScale : 0.0);
      reject_outliers(fit_.now.fit.trajectories, state, options_.solve.rejection_sigmas,
                      options_.solve.threads);
      const Eigen::MatrixXd P =
          prior + released_covariance(known_, changed_parameters(out_.comparison, known_), before_.motion);
      set_joint_prior(fit_.now.fit.layout = fit_.now.layout, known_, P);
      look_for_changes(P, known_white || !last, known_white || last);
      fit_.move_to(known_.value + updated_by(P, visit_.N, visit_.gradient).step);
    }
    fit_.now.statistics = statistics_of(fit_.now.fit.problem, fit_.now.fit.layout, fit_.now.fit.trajectories,
                                        fit_.now.fit.state(), fit_.data_cost(), options_.solve.threads);
    return true;
  }

  void conclude_visit() {
    AsLeft left = as_left(before_, known_, drift_, out_.comparison, visit_, tolerance_m(problem_));
    out_.as_left = std::move(left.deployment);
    out_.warnings.insert(out_.warnings.end(), left.warnings.begin(), left.warnings.end());
    out_.medium.speed_change_mps = out_.as_left.speed_offset_mps - before_.speed_offset_mps;
    out_.medium.speed_change_sigma_mps = left.speed_change_sigma_mps;
    out_.as_left.statistics = fit_.now.statistics;
    out_.as_left.statistics.converged = true;
    extend_validity(out_.as_left, fit_.now.fit.trajectories, problem_, out_.medium.temperature_known);
    const SharedState state = fit_.now.fit.state();
    out_.beacons = heard_of_beacons(before_, fit_.now.fit.trajectories, state);
    out_.receivers = heard_by_receivers(before_, fit_.now.fit.trajectories, state);
    out_.silent = silent_of(out_.beacons, out_.receivers);
    out_.not_observed = not_observed_of(before_, out_.beacons);
    out_.not_judged = received_once(fit_.now.fit, before_);
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
  VisitFit fit_;
  Eigen::VectorXd drift_, room_;  ///< variances
  Problem problem_;
  VisitInformation visit_;
  std::vector<ChangeHypothesis> unsupported_;  ///< changes that only a single stop supports
  Revisit out_;
};

}  // namespace

Result<Revisit> revisit(const Deployment& before, std::vector<MeasurementLog> runs,
                        const RevisitOptions& options) {
  return SecondVisit(before, options).run(std::move(runs));
}

}  // namespace octant::calib

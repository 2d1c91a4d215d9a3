// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/readings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "calib/readings/clock_jumps.h"
#include "calib/readings/error_readings.h"
#include "calib/readings/odometry_readings.h"
#include "calib/readings/pauses.h"
#include "calib/readings/pose_readings.h"
#include "calib/readings/reading_score.h"
#include "calib/readings/site_readings.h"

namespace octant::calib {
namespace {

/// Requirements on a hypothesis: gain in log-likelihood per arrival, ratio of the losses, share of agreeing
/// arrivals, noise, and redundancy per arrival.
constexpr double kGain = 0.5, kFactor = 0.6, kAgreeingShare = 0.6, kNoise = 5.0, kRedundant = 0.2;
/// A hypothesis explains everything if this share of the arrivals agrees with about the expected noise.
constexpr double kAllAgree = 0.95, kNoiseOfAll = 1.5;
/// Share by which fewer arrivals may agree than before, because some are near the limit.
constexpr double kFewer = 0.02;
/// Difference of log-likelihood per arrival below which hypotheses are equally good.
constexpr double kTie = 0.05;
/// Adjusted parts of the recordings: a small one for each hypothesis, and a larger one for the few that
/// explain it far better.
constexpr LogShare kFirstShare = {16, 12, 600, 8}, kSecondShare = {40, 30, 1500, 16};
constexpr double kWorthASecondTrial = 0.8;  ///< share of the loss without a hypothesis
constexpr int kTrialIterations = 25;        ///< of each stage of a trial
constexpr std::size_t kSecondTrials = 2;    ///< maximum number for each kind
constexpr double kScaleAgrees = 0.5;        ///< share of arrivals that excludes a wrong scale of everything
constexpr double kPlainSigmas = 8.0;        ///< significance of a gain without further requirements
/// Sigmas of receivers and control points whose positions only the poses are to determine.
constexpr double kLooseReceiver_m = 0.5, kLoosePoint_m = 1.0;

class Search {
 public:
  Search(const Problem& problem, const Solution& solution, const SolveOptions& options)
      : problem_(problem), solution_(solution), options_(options), site_(problem.site) {
    // A true hypothesis converges within a few iterations; only false ones need many.
    options_.max_iterations = std::min(options.max_iterations, kTrialIterations);
    for (SiteVehicle& v : site_.vehicles)
      v.array.reset();  // an array that is adjusted as a whole has one order of receivers
  }

  /// Searches for other causes of contradictions, first of those of control points.
  std::vector<Contradiction> other_culprits() {
    score_as_stated();
    if (is_blamed(ContradictionKind::kControlPoint)) try_exchanged_points();
    if (is_blamed(ContradictionKind::kSpeed)) try_out(scales(), true);
    try_out(heights_downwards(site_), true);
    if (do_poses_tumble(problem_.runs)) try_out(other_pose_frames(problem_.runs), true);
    if (found_.empty()) try_clock_and_point_of_poses();
    if (found_.empty()) try_errors_of_odometry();
    if (found_.empty()) try_out(jumped_clocks(site_, problem_.runs, options_));
    return best();
  }

  std::vector<Contradiction> run() {
    score_as_stated();
    const bool jumps = ranges_show_a_jump(site_, problem_.runs);
    // Hypotheses without a parameter come first.
    try_out(unit_by_ranges(site_, second_));
    if (!is_explained()) try_out(heights_downwards(site_));
    if (is_explained()) return best();
    found_.clear();
    const std::vector<Reading> odometry = other_odometry(problem_.runs);
    try_out(odometry);
    if (is_explained()) {
      try_frames();  // mirrored receivers resemble turns of the wrong sign
      return best();
    }
    const std::vector<ScoredReading> by_odometry = std::exchange(found_, {});
    // If the ranges alone show a jump, it is examined early, because other searches would be long and
    // useless. Before it come causes common to all arrivals, which explain all of them or none.
    try_out(common_delay(site_, problem_.typical_range_m));
    try_out(drifting_clocks(site_, problem_.runs, options_));
    if (stated_.agreeing < kScaleAgrees) try_out(points_elsewhere(site_));
    std::erase_if(found_, [](const auto& t) { return !explains_all(t.score); });
    if (found_.empty() && jumps) try_out(jumped_clocks(site_, problem_.runs, options_));
    if (found_.empty()) try_clock_and_point_of_poses();
    if (found_.empty()) try_errors_of_odometry();
    if (!found_.empty()) return best();
    for (const Reading& reading : numbered_stops(problem_.runs)) accept(reading);
    if (found_.empty()) try_exchanged_points();
    const bool scale_is_right = stated_.agreeing >= kScaleAgrees && stated_.noise <= kNoise &&
                                !is_blamed(ContradictionKind::kSpeed) && are_all_placed(site_);
    if (!jumps && nothing_but_exchanges()) try_out(jumped_clocks(site_, problem_.runs, options_));
    if (nothing_but_exchanges())
      try_out(scale_is_right ? other_units(site_, second_, true) : scales(),
              is_blamed(ContradictionKind::kSpeed));
    // A wrong frame or reversed odometry resembles receivers in another unit.
    found_.insert(found_.end(), by_odometry.begin(), by_odometry.end());
    if (nothing_but_exchanges() || !odometry.empty() || !other_pose_frames(problem_.runs).empty())
      try_frames();
    try_without_poses();
    return best();
  }

 private:
  struct ScoredReading {
    Contradiction what;
    ReadingScore score;
  };
  /// Frames and units of poses and frames and wirings of whole arrays, which resemble each other; then the
  /// many exchanges of two receivers.
  void try_frames() {
    try_out(
        joined({other_pose_frames(problem_.runs), other_pose_units(problem_.runs), other_receiver_axes(site_),
                other_wirings(site_, solution_, false), mirrored_map(site_)}));
    if (!is_explained()) try_out(other_wirings(site_, solution_, true));
  }

  /// Hypotheses that scale everything.
  [[nodiscard]] std::vector<Reading> scales() const {
    return joined({other_units(site_, second_, false), other_ranging(site_)});
  }

  /// Loss of what is blamed already, which competes with all hypotheses by its likelihood, less what its free
  /// parameters gain by chance (Schwarz 1978). Infinite if nothing is blamed.
  [[nodiscard]] double rival_loss() const {
    if (rival_loss_) return *rival_loss_;
    rival_loss_ = INFINITY;
    if (solution_.contradictions.empty()) return *rival_loss_;
    const ReleasedSite released = without_what_is_blamed(site_, solution_.contradictions);
    const ReadingScore s = score_of(released.site, second_, options_, true);
    const double n = std::max(1.0, s.arrivals);
    rival_loss_ = s.loss + 0.5 * static_cast<double>(released.parameters) * std::log(n) / n;
    return *rival_loss_;
  }

  void score_as_stated() {
    first_ = few_of(problem_.runs, site_, kFirstShare);
    second_ = few_of(problem_.runs, site_, kSecondShare);
    stated_first_ = score_of(site_, first_, options_, false);
    stated_ = score_of(site_, second_, options_, true);
  }

  /// Returns true if only exchanges are found. Exchanged points explain a part of the effect of exchanged
  /// receivers, so an exchange that does not explain everything does not end the search.
  [[nodiscard]] bool nothing_but_exchanges() const {
    return std::ranges::all_of(found_, [](const ScoredReading& t) {
      return t.what.kind == ContradictionKind::kExchanged && !explains_all(t.score);
    });
  }

  /// Returns true if no other hypothesis could explain more.
  [[nodiscard]] static bool explains_all(const ReadingScore& s) {
    return s.agreeing >= kAllAgree && s.noise <= kNoiseOfAll;
  }

  [[nodiscard]] bool is_explained() const {
    return std::ranges::any_of(found_, explains_all, &ScoredReading::score);
  }

  [[nodiscard]] bool is_blamed(ContradictionKind kind) const {
    return std::ranges::any_of(solution_.contradictions,
                               [kind](const Contradiction& c) { return c.kind == kind; });
  }

  [[nodiscard]] bool stopped() const { return options_.is_stopped(); }

  /// Share of the arrivals that agree without a hypothesis, at the noise that another hypothesis finds. With
  /// a much larger noise everything agrees with everything.
  [[nodiscard]] double agreeing_as_stated(double noise) const {
    const double limit = options_.rejection_sigmas * noise;
    const auto agreeing =
        std::ranges::count_if(stated_.sizes, [limit](double size) { return size <= limit; });
    return static_cast<double>(agreeing) / std::max(1.0, stated_.arrivals);
  }

  /// Returns true if a hypothesis is acceptable by itself and better than the contradictions found already.
  [[nodiscard]] bool is_good(const ReadingScore& s) const {
    return s.agreeing >= std::max(kAgreeingShare, agreeing_as_stated(s.noise) - kFewer) &&
           s.noise <= kNoise && s.redundancy >= kRedundant && s.loss < rival_loss();
  }

  [[nodiscard]] bool explains(const ReadingScore& s) const {
    return is_good(s) && stated_.loss - s.loss >= kGain && s.loss <= kFactor * stated_.loss;
  }

  /// @param share  kFirstShare or kSecondShare
  [[nodiscard]] ReadingScore score(const Reading& reading, const LogShare& share, bool search_again) const {
    const std::vector<MeasurementLog>& part = &share == &kFirstShare ? first_ : second_;
    if (!reading.log) return score_of(reading.site(site_), part, options_, search_again);
    std::vector<MeasurementLog> others = reading.is_of_whole ? problem_.runs : part;
    for (std::size_t run = 0; run < others.size(); ++run) reading.log(run, others[run]);
    if (reading.is_of_whole) others = few_of(others, site_, share);
    return score_of(reading.site ? reading.site(site_) : site_, others, options_, search_again);
  }

  /// Returns true if a hypothesis is acceptable and significantly likelier than the original inputs.
  [[nodiscard]] bool is_likelier(const ReadingScore& s) const {
    return is_good(s) && s.arrivals * (stated_.loss - s.loss) >= 0.5 * kPlainSigmas * kPlainSigmas;
  }

  /// Scores each hypothesis with the small part, then with the larger part those that explain the log far
  /// better than the original inputs.
  /// @param plainly  everything else agrees, so a likelier hypothesis suffices
  void try_out(const std::vector<Reading>& readings, bool plainly = false) {
    std::vector<std::pair<double, std::size_t>> ranking;
    for (std::size_t i = 0; i < readings.size() && !stopped(); ++i) {
      const double loss = score(readings[i], kFirstShare, false).loss;
      if (plainly ? loss < stated_first_.loss : loss < kWorthASecondTrial * stated_first_.loss)
        ranking.emplace_back(loss, i);
    }
    std::ranges::stable_sort(ranking, [](const auto& a, const auto& b) { return a.first < b.first; });
    // For each kind, so that mirrored poses and exchanged receivers are both examined.
    std::map<ContradictionKind, std::size_t> tried;
    std::erase_if(ranking,
                  [&](const auto& r) { return ++tried[readings[r.second].what.kind] > kSecondTrials; });
    std::ranges::sort(ranking, [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const auto& [loss, i] : ranking) {
      if (stopped()) return;
      const ReadingScore s = score(readings[i], kSecondShare, true);
      if (explains(s) || (plainly && is_likelier(s) && explains_all(s)))
        found_.push_back({readings[i].what, s});
    }
  }

  /// Accepts the likeliest hypothesis of each family if it leaves the expected noise.
  void try_families(const std::vector<ReadingFamily>& families) {
    for (const ReadingFamily& family : families) {
      if (stopped()) return;
      const auto size = likeliest_size(family.least, family.most, stated_first_.loss, [&](double tried) {
        const bool is_examined = !stopped() && (!family.may_be || family.may_be(tried));
        return is_examined ? score(family.reading(tried), kFirstShare, false).loss : INFINITY;
      });
      if (size) accept(family.reading(*size));
    }
  }

  void accept(const Reading& reading) {
    const ReadingScore s = score(reading, kSecondShare, true);
    if (explains(s) || (is_likelier(s) && explains_all(s))) found_.push_back({reading.what, s});
  }

  /// Examines another clock, another point and another frame of the poses, which can resemble each other.
  void try_clock_and_point_of_poses() {
    const std::vector<MeasurementLog>& runs = problem_.runs;
    if (std::ranges::all_of(runs, [](const auto& run) { return run.poses.empty(); })) return;
    try_families(poses_stamped_late(runs));
    accept(poses_of_other_point(runs, -with_loose_receivers().shift_m));
    if (const auto T_map_frame = frame_of_poses()) accept(poses_of_other_frame(runs, *T_map_frame));
  }

  /// Frame of the poses, by the positions that they give to the control points. No value if a single control
  /// point is wrong.
  [[nodiscard]] std::optional<Pose> frame_of_poses() const {
    const auto blamed =
        std::ranges::count(solution_.contradictions, ContradictionKind::kControlPoint, &Contradiction::kind);
    if (blamed < 2) return std::nullopt;
    Site loose = site_;
    for (SiteBeacon& b : loose.beacons)
      if (b.is_control_point()) b.sigma_m.fill(kLoosePoint_m);
    const ReadingScore s = score_of(loose, second_, options_, true);
    std::vector<Eigen::Vector3d> by_poses, stated;
    for (std::size_t i = 0; i < s.beacon_p_map_m.size(); ++i)
      if (const SiteBeacon& b = site_.beacons[i]; b.is_control_point()) {
        by_poses.push_back(s.beacon_p_map_m[i]);
        stated.emplace_back(*b.position_m[0], *b.position_m[1], *b.position_m[2]);
      }
    return frame_between(by_poses, stated);
  }

  /// Examines scale and clock of the odometry. If other receiver positions explain as much as a clock, they
  /// are preferred.
  void try_errors_of_odometry() {
    try_families(odometry_of_other_scale(site_, problem_.runs));
    if (!found_.empty()) return;
    try_families(odometry_stamped_late(problem_.runs));
    if (!found_.empty() && with_loose_receivers().loss < found_.back().score.loss + kTie) found_.pop_back();
  }

  struct LooseReceivers {
    double loss = 0.0;
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< common shift of all receivers
  };
  /// Adjusts with loose priors of the receiver positions.
  [[nodiscard]] LooseReceivers with_loose_receivers() const {
    Site loose = site_;
    for (SiteReceiver& receiver : loose.receivers) receiver.sigma_m.setConstant(kLooseReceiver_m);
    const ReadingScore s = score_of(loose, second_, options_, true);
    LooseReceivers out{s.loss};
    // The height is not determined for a planar vehicle
    const int told = site_.motion == Motion::kPlanar ? 2 : 3;
    for (int i = 0; i < told; ++i) {
      std::vector<double> shifts;
      for (std::size_t r = 0; r < s.receiver_p_vehicle_m.size(); ++r)
        shifts.push_back(s.receiver_p_vehicle_m[r][i] - site_.receivers[r].position_m[i]);
      out.shift_m[i] = median(std::move(shifts));
    }
    return out;
  }

  /// Examines poses with an unknown error. A hypothesis on their frame, or on the receivers, is preferred if
  /// about as many arrivals agree.
  void try_without_poses() {
    constexpr double kAboutAsMany = 0.1;
    const std::size_t before = found_.size();
    try_out(without_poses(problem_.runs));
    if (found_.size() == before) return;
    const double agreeing = found_.back().score.agreeing - kAboutAsMany;
    if (std::any_of(found_.begin(), found_.end() - 1,
                    [agreeing](const ScoredReading& t) { return t.score.agreeing >= agreeing; }))
      found_.pop_back();
  }

  /// Accepts the best exchange of two control points. An exchange preserves most of the shape of the site, so
  /// many arrivals agree anyway. An exchange has no free parameters, so a significant gain in likelihood
  /// suffices, unless a single control point at another position explains more.
  void try_exchanged_points() {
    std::optional<ScoredReading> least;
    for (const Reading& reading : exchanged_points(site_)) {
      if (stopped()) return;
      const ReadingScore s = score(reading, kSecondShare, true);
      if (is_likelier(s) && (!least || s.loss < least->score.loss)) least = {reading.what, s};
      if (least && explains_all(least->score)) break;
    }
    for (std::size_t b = 0; b < site_.beacons.size() && least && !explains_all(least->score); ++b) {
      if (!site_.beacons[b].is_control_point()) continue;
      Site released = site_;
      released.beacons[b].position_m = {};
      released.beacons[b].sigma_m = {};
      if (score_of(released, second_, options_, true).loss < least->score.loss - kTie) least.reset();
    }
    if (least && !stopped()) found_.push_back(*least);
  }

  [[nodiscard]] bool is_radio() const { return speed_mps(site_.medium) > 1e6; }
  [[nodiscard]] static double stated_delay_s(const Site& site) {
    return site.timing.delay_per.none() ? 0.0 : site.timing.delay_s;
  }

  /// Returns the likeliest hypothesis, and equally likely ones of other kinds. Within a kind, the first of
  /// the equally good ones is the likelier mistake; hypotheses that ignore fewer positions come first.
  std::vector<Contradiction> best() {
    std::vector<Contradiction> reported;
    std::ranges::stable_sort(found_, [](const ScoredReading& a, const ScoredReading& b) {
      return a.score.disregarded < b.score.disregarded;
    });
    double least = INFINITY;
    for (const ScoredReading& t : found_) least = std::min(least, t.score.loss);
    for (ScoredReading& t : found_) {
      const bool said =
          std::ranges::any_of(reported, [&](const Contradiction& m) { return m.kind == t.what.kind; });
      if (said || t.score.loss > least + kTie) continue;
      if (t.what.kind == ContradictionKind::kDelay) {
        const double off_s = t.score.delay_s - stated_delay_s(site_);
        t.what.found += fmt::format(", {:.4g} {} {} than stated", std::abs(off_s) * (is_radio() ? 1e9 : 1e3),
                                    is_radio() ? "ns" : "ms", off_s > 0 ? "longer" : "shorter");
      }
      t.what.found += fmt::format(" (so read {:.0f} % of the arrivals agree, as stated {:.0f} %)",
                                  100 * t.score.agreeing, 100 * agreeing_as_stated(t.score.noise));
      t.what.sigmas = std::sqrt(2 * t.score.arrivals * (stated_.loss - t.score.loss));
      reported.push_back(std::move(t.what));
    }
    join_odometry_to_wiring(reported);
    // Hypotheses that the ranges do not distinguish are alternatives.
    for (std::size_t i = 1; i < reported.size(); ++i) {
      reported[i].found += "; either this or the preceding one is true, not both";
      reported[i].remedy = "or else " + reported[i].remedy;
    }
    return reported;
  }

  const Problem& problem_;
  const Solution& solution_;
  SolveOptions options_;
  Site site_;
  std::vector<MeasurementLog> first_, second_;  ///< evenly spread parts for the first and the second trial
  ReadingScore stated_first_, stated_;
  mutable std::optional<double> rival_loss_;  ///< see rival_loss()
  std::vector<ScoredReading> found_;
};

}  // namespace

std::vector<Contradiction> find_misreadings(const Problem& problem, const Solution& solution,
                                            const SolveOptions& options) {
  return Search(problem, solution, options).run();
}

std::vector<Contradiction> find_other_culprits(const Problem& problem, const Solution& solution,
                                               const SolveOptions& options) {
  return Search(problem, solution, options).other_culprits();
}

}  // namespace octant::calib

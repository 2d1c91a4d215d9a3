// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/agreement.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/statements/motions.h"

namespace octant::calib {
namespace {

/// Share of a beacon's arrivals that must be rejected, and its least ratio to the share of the other beacons.
constexpr double kManyLeftOut = 0.15, kBeyondOthers = 3.0;
constexpr std::size_t kFewestLeftOut = 8;
/// Lower limits for a beacon that may have moved: it may have been placed between its two positions, where
/// few arrivals are rejected.
constexpr double kSomeLeftOut = 0.08, kBeyondOthersIfMoved = 2.0;
/// Share of early arrivals that spurious detections do not exceed.
constexpr double kManyEarly = 0.10;
/// If more than this share of a beacon's arrivals is rejected, many of them early, the estimated position may
/// be the one at which reflected arrivals appear direct.
constexpr double kMostLeftOut = 0.5;
/// Significance from which a beacon is reported as moved (lower if most of the rejected arrivals agree
/// again), and the least move as a share of the tolerance.
constexpr double kMovedSigmas = 6.0, kMovedSigmasIfRegained = 4.0, kMovedMatters = 0.3;
constexpr double kRegained = 0.5, kMostRegained = 0.8;
constexpr std::size_t kMostSplit = 3;
/// Squares that two positions must save, in units of the noise's variance: chi-square of three coordinates at
/// the best of many times exceeds it once in a million.
constexpr double kLeastGain = 40.0;
/// Share of a receiver's arrivals that must be rejected; it must also exceed the usual share kBeyondOthers
/// times.
constexpr double kMostOfAReceiver = 0.5;
constexpr std::size_t kFewestOfAReceiver = 20;
/// Rejections at one place count as one event. Fewer events than this are no contradiction.
constexpr std::size_t kFewestPlaces = 5;

/// Arrivals with a known pose, of one beacon or at one receiver, and the bearings of a beacon.
struct HeardCounts : RejectionCounts {
  std::size_t placed = 0, bearings = 0, bearings_out = 0;
  explicit HeardCounts(const RejectionCounts& arrivals)
      : RejectionCounts(arrivals), placed(all() - of(Rejection::kNoPose) - of(Rejection::kBeaconUnusable)) {}
  [[nodiscard]] double share() const {
    return placed > 0 ? static_cast<double>(outliers()) / static_cast<double>(placed) : 0.0;
  }
};

/// Returns true if more of the rejected arrivals are early than chance allows for errors to both sides, as a
/// noisy beacon has.
bool are_mostly_early(const HeardCounts& c) {
  constexpr double kSignificance = 3.0;  // in standard deviations of the difference of the counts
  const auto early = static_cast<double>(c.of(Rejection::kEarly)),
             late = static_cast<double>(c.of(Rejection::kLate));
  return early - late > kSignificance * std::sqrt(early + late);
}

std::vector<HeardCounts> count_by_beacon(const Fit& fit) {
  const std::size_t beacons = fit.problem.site.beacons.size();
  std::vector<HeardCounts> counts;
  for (const RejectionCounts& arrivals : rejections_by_beacon(fit.trajectories, beacons))
    counts.emplace_back(arrivals);
  for (const Trajectory& t : fit.trajectories)
    for (const BearingObservation& b : t.bearings) {
      if (!b.reflector.valid() || !t.nodes[b.node].placed) continue;
      ++counts[b.reflector.index()].bearings;
      counts[b.reflector.index()].bearings_out += is_outlier(b.rejection);
    }
  return counts;
}

std::vector<HeardCounts> count_by_receiver(const Fit& fit) {
  std::vector<HeardCounts> counts;
  for (const RejectionCounts& arrivals :
       count_rejections(fit.trajectories, fit.problem.site.receivers.size(),
                        [](const ArrivalObservation& a) { return a.receiver.index(); }))
    counts.emplace_back(arrivals);
  return counts;
}

/// Median share of rejected arrivals, over all beacons (or receivers) with arrivals.
double usual_share(const std::vector<HeardCounts>& counts) {
  std::vector<double> shares;
  for (const HeardCounts& c : counts)
    if (c.placed > 0) shares.push_back(c.share());
  return median(std::move(shares));
}

bool is_counted(const Trajectory& t, const ArrivalObservation& a) {
  return t.nodes[a.node].placed && a.rejection != Rejection::kBeaconUnusable &&
         a.rejection != Rejection::kNoPose;
}

/// Numbers of places of the vehicle at which a beacon was received, was rejected, and was early.
struct Places {
  std::size_t heard = 0, left_out = 0, early = 0;
};

Places places_of(const Fit& fit, std::size_t beacon, double from_s = -INFINITY, double to_s = INFINITY) {
  std::set<Place> heard, left_out, early;
  for (const Trajectory& t : fit.trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.beacon.index() != beacon || !is_counted(t, a) || a.time_s < from_s || a.time_s > to_s) continue;
      const Place place = place_at(t.nodes[a.node].T_map_vehicle.translation_m, fit.problem.typical_range_m);
      heard.insert(place);
      if (is_outlier(a.rejection)) left_out.insert(place);
      if (a.rejection == Rejection::kEarly) early.insert(place);
    }
  return {heard.size(), left_out.size(), early.size()};
}

std::string length(double m) {
  return m < 1.0 ? fmt::format("{:.0f} mm", 1e3 * m) : fmt::format("{:.2f} m", m);
}

class Checker {
 public:
  Checker(const Problem& problem, const SolveOptions& options, const Fit& fit,
          const std::vector<Contradiction>& besides)
      : problem_(problem),
        options_(options),
        fit_(fit),
        besides_(besides),
        counts_(count_by_beacon(fit)),
        least_gain_(kLeastGain * noise_variance(fit, options.threads)) {
    for (std::size_t b = 0; b < counts_.size(); ++b) changes_.push_back(likeliest_change(fit, b));
  }

  /// Moves that explain more than a cost.
  std::vector<Contradiction> moves(double cost) {
    most_cost_ = cost;
    usual_ = usual_share(counts_);
    std::vector<std::size_t> suspects = this->suspects();
    suspects.resize(std::min(suspects.size(), kMostSplit));
    for (const std::size_t b : suspects)
      if (may_have_moved(b, places_of(fit_, b)) && moved(b)) break;
    return std::move(out_.contradictions);
  }

  Agreement run() {
    usual_ = usual_share(counts_);
    beacons();
    receivers();
    stops();
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool said(const std::string& beacon) const {
    for (const Contradiction& c : besides_)
      if ((", " + c.subject + ",").find(", " + beacon + ",") != std::string::npos) return true;
    return false;
  }

  [[nodiscard]] bool is_suspect(const HeardCounts& c, double share, double beyond_others) const {
    return c.outliers() >= kFewestLeftOut && c.share() >= std::max(share, beyond_others * usual_);
  }

  /// Beacons that may have moved or are often rejected, those first of which a move may explain most squares.
  [[nodiscard]] std::vector<std::size_t> suspects() const {
    std::vector<std::size_t> suspects;
    for (std::size_t b = 0; b < counts_.size(); ++b)
      if (fit_.beacon_usable[b] && !said(problem_.site.beacons[b].name) &&
          (has_changed(b) || is_suspect(counts_[b], kSomeLeftOut, kBeyondOthersIfMoved)))
        suspects.push_back(b);
    const auto squares = [this](std::size_t b) {
      return changes_[b].gain + options_.rejection_sigmas * options_.rejection_sigmas *
                                    static_cast<double>(counts_[b].outliers());
    };
    std::ranges::sort(suspects, std::greater(), squares);
    return suspects;
  }

  /// Returns true if two positions explain the used arrivals better than chance allows.
  [[nodiscard]] bool has_changed(std::size_t b) const { return changes_[b].gain > least_gain_; }
  [[nodiscard]] bool may_have_moved(std::size_t b, const Places& places) const {
    return has_changed(b) || places.left_out >= kFewestPlaces;
  }

  void beacons() {
    for (std::size_t b = 0; b < counts_.size(); ++b)
      if (const HeardCounts& c = counts_[b]; fit_.beacon_usable[b] && c.bearings >= 10 &&
                                             2 * c.bearings_out > c.bearings &&
                                             !said(problem_.site.beacons[b].name))
        bearings_left_out(b);
    const std::vector<std::size_t> suspects = this->suspects();
    for (std::size_t k = 0; k < suspects.size(); ++k) {
      const Places places = places_of(fit_, suspects[k]);
      if (k < kMostSplit && may_have_moved(suspects[k], places) && moved(suspects[k])) continue;
      if (is_suspect(counts_[suspects[k]], kManyLeftOut, kBeyondOthers)) much_left_out(suspects[k], places);
    }
  }

  /// The move that explains most. The rejected arrivals determine its time only roughly, because the fit is a
  /// compromise between both positions. Once the two positions are known, they determine the time well.
  [[nodiscard]] std::optional<Move> likeliest_move(std::size_t b) const {
    constexpr int kMostRounds = 4;
    std::optional<Move> best;
    std::vector<double> times = times_of_change(fit_, b);
    if (changes_[b].gain > 0.0) times.push_back(changes_[b].time_s);
    for (const double rough_s : times) {
      std::optional<double> time_s = rough_s;
      for (int round = 0; round < kMostRounds && time_s; ++round) {
        const Fit split = split_fit(options_, fit_, b, *time_s);
        if (!split.ok || (best && split.cost >= best->cost)) break;
        best = move_of(options_, split, b, *time_s);
        time_s = best_time_of_change(split, b, options_.rejection_sigmas);
        if (time_s == best->time_s) break;
      }
    }
    return best;
  }

  /// Cost without a move, adjusted in the same way as with one, because that may readmit arrivals by itself.
  [[nodiscard]] double cost_without_move() {
    if (!cost_without_move_) {
      Fit again = fit_;
      adjust_anew(options_, again);
      cost_without_move_ = again.ok ? std::min(again.cost, fit_.cost) : fit_.cost;
    }
    return *cost_without_move_;
  }

  bool moved(std::size_t b) {
    const std::optional<Move> best = likeliest_move(b);
    if (!best || !(best->cost < most_cost_) || best->by_m.norm() < kMovedMatters * tolerance_m(problem_) ||
        2 * (cost_without_move() - best->cost) < least_gain_)
      return false;
    // The position before or after the move, if it is determined by few places, absorbs any error of these.
    if (places_of(fit_, b, -INFINITY, best->time_s).heard < kFewestPlaces ||
        places_of(fit_, b, best->time_s, INFINITY).heard < kFewestPlaces)
      return false;
    // The rejected arrivals must agree after the move; otherwise it is not the cause.
    const double left_out = 0.5 * options_.rejection_sigmas * options_.rejection_sigmas *
                            static_cast<double>(counts_[b].outliers());
    const double regained = (cost_without_move() - best->cost) / left_out;
    if (regained < kRegained ||
        best->sigmas < (regained < kMostRegained ? kMovedSigmas : kMovedSigmasIfRegained))
      return false;
    const std::string& name = problem_.site.beacons[b].name;
    double first_s = INFINITY;
    for (const Trajectory& t : fit_.trajectories)
      if (!t.nodes.empty()) first_s = std::min(first_s, t.nodes.front().time_s);
    out_.contradictions.push_back(
        {ContradictionKind::kBeacon, name, "to stay where it is",
         fmt::format("to move by {} ({:+.3f}, {:+.3f}, {:+.3f} m) some {:.0f} s into the recording",
                     length(best->by_m.norm()), best->by_m.x(), best->by_m.y(), best->by_m.z(),
                     best->time_s - first_s),
         best->sigmas,
         fmt::format(
             "fasten beacon {}; then calibrate with the recordings before or after its move, not with both",
             name)});
    return true;
  }

  void much_left_out(std::size_t b, const Places& places) {
    const HeardCounts& c = counts_[b];
    const std::string& name = problem_.site.beacons[b].name;
    if (c.of(Rejection::kEarly) >= kFewestLeftOut && places.early >= kFewestPlaces &&
        static_cast<double>(places.early) > kManyEarly * static_cast<double>(places.heard) &&
        static_cast<double>(c.of(Rejection::kEarly)) > kManyEarly * static_cast<double>(c.placed) &&
        (are_mostly_early(c) || c.share() > kMostLeftOut)) {
      const double expected = std::max(1.0, 0.01 * static_cast<double>(places.heard));
      out_.contradictions.push_back(
          {ContradictionKind::kBeacon, name, "to be heard along the straight path",
           fmt::format("early at {} of {} arrivals, as no echo can be", c.of(Rejection::kEarly), c.placed),
           (static_cast<double>(places.early) - expected) / std::sqrt(expected),
           fmt::format(
               "check that beacon {} did not move, that no other beacon sends with its name, and its channel",
               name)});
      return;
    }
    out_.warnings.push_back(fmt::format(
        "beacon {}: {} of {} arrivals do not fit the position that the others determine ({} late, {} early), "
        "far more than for other beacons; look for obstacles and reflectors near it",
        name, c.outliers(), c.placed, c.of(Rejection::kLate), c.of(Rejection::kEarly)));
  }

  void bearings_left_out(std::size_t b) {
    const std::string& name = problem_.site.beacons[b].name;
    const HeardCounts& c = counts_[b];
    out_.contradictions.push_back({ContradictionKind::kBeacon, name, "in the directions that were measured",
                                   fmt::format("{} of {} bearings elsewhere", c.bearings_out, c.bearings),
                                   0.0,
                                   fmt::format("check that {} is not at the mirror image of its position, "
                                               "and check the signs and names of the bearings",
                                               name)});
  }

  /// Echoes and obstacles depend on the place and the beacon. If the arrivals of a single receiver do not
  /// agree, its type or its position is wrong.
  void receivers() {
    const std::vector<HeardCounts> counts = count_by_receiver(fit_);
    if (std::ranges::count_if(counts, [](const HeardCounts& c) { return c.placed > 0; }) < 2) return;
    const double usual = usual_share(counts);
    for (std::size_t r = 0; r < counts.size(); ++r) {
      const HeardCounts& c = counts[r];
      const std::string name = receiver_path(r, names_of(problem_.site));
      if (c.placed < kFewestOfAReceiver || said(name) ||
          c.share() < std::max(kMostOfAReceiver, kBeyondOthers * usual))
        continue;
      out_.contradictions.push_back(
          {ContradictionKind::kReceiver, name, "at its place on the vehicle",
           fmt::format(
               "{} of {} of its arrivals to fit neither that position nor one near it ({} late, {} early)",
               c.outliers(), c.placed, c.of(Rejection::kLate), c.of(Rejection::kEarly)),
           0.0,
           fmt::format(
               "measure the position of receiver {} on the vehicle again, and check its cable and channel",
               problem_.site.receivers[r].name)});
    }
  }

  void stops() {
    const SharedState state = fit_.state();
    std::vector<std::pair<StopMotion, std::int64_t>> moved;
    std::size_t all = 0;
    for (const Trajectory& t : fit_.trajectories) {
      if (t.moving || t.motion != Motion::kPlanar || !t.odometry.empty() || !t.poses.empty() ||
          t.segments.size() != t.nodes.size())
        continue;
      for (const Segment& s : t.segments) {
        const Node& node = t.nodes[s.first_node];
        if (!node.placed || node.epoch == kNoEpoch) continue;
        ++all;
        if (const auto motion = motion_during(t, s, state, options_.rejection_sigmas))
          moved.emplace_back(*motion, node.epoch);
      }
    }
    if (moved.empty()) return;
    std::ranges::sort(moved, [](const auto& a, const auto& b) { return a.first.gain > b.first.gain; });
    constexpr std::size_t kMostNamed = 12;
    std::vector<std::string> named;
    for (std::size_t i = 0; i < moved.size() && i < kMostNamed; ++i)
      named.push_back(fmt::format("{} (by {})", moved[i].second, length(moved[i].first.by_m)));
    if (moved.size() == 1) named[0] += fmt::format(", at {:.6g} s", moved[0].first.time_s);
    const bool several = moved.size() > 1;
    out_.warnings.push_back(fmt::format(
        "the vehicle moved during {} of {} stops: stop{} {}{} (epoch{} of the recording); arrivals of {} "
        "that do not fit are left out; better leave {} out as a whole, or record {} again",
        moved.size(), all, several ? "s" : "", fmt::join(named, ", "),
        moved.size() > named.size() ? " and more" : "", several ? "s" : "", several ? "them" : "it",
        several ? "them" : "it", several ? "them" : "it"));
  }

  const Problem& problem_;
  const SolveOptions& options_;
  const Fit& fit_;
  const std::vector<Contradiction>& besides_;
  std::vector<HeardCounts> counts_;
  double least_gain_;
  std::vector<PositionChange> changes_;  ///< of each beacon, by the arrivals in use
  double usual_ = 0.0, most_cost_ = INFINITY;
  std::optional<double> cost_without_move_;
  Agreement out_;
};

}  // namespace

std::vector<Contradiction> moves_of(const Problem& problem, const SolveOptions& options, const Fit& fit,
                                    double cost) {
  if (!is_dense(fit.layout) || fit.x.size() == 0) return {};
  const std::vector<Contradiction> besides;
  return Checker(problem, options, fit, besides).moves(cost);
}

Agreement agreement_of(const Problem& problem, const SolveOptions& options, const Fit& fit,
                       const std::vector<Contradiction>& besides) {
  if (!is_dense(fit.layout) || fit.x.size() == 0) return {};
  return Checker(problem, options, fit, besides).run();
}

}  // namespace octant::calib

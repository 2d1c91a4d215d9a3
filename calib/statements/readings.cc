// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/readings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/site_units.h"
#include "calib/statements/pauses.h"
#include "calib/statements/pose_frames.h"
#include "calib/statements/reading_score.h"
#include "calib/statements/wiring.h"

namespace octant::calib {
namespace {

/// How an outcome looks that is worth a search.
constexpr double kEarlyShare = 0.05, kLeftOutShare = 0.35, kNoiseRatio = 3.0, kDraggedSigmas = 6.0;
constexpr std::size_t kEarlyAtLeast = 10;
/// How much better a reading must be: by so much log likelihood an arrival, and by such a factor; and good by
/// itself.
constexpr double kGain = 0.5, kFactor = 0.6, kAgreeingShare = 0.6, kNoise = 5.0, kRedundant = 0.2;
/// Readings within this much log likelihood an arrival are equally good.
constexpr double kTie = 0.05;
/// Parts of the recordings that are adjusted: a small one for each reading, a larger one for those few that
/// explain it far better.
constexpr LogShare kFirstLook = {16, 12, 600}, kSecondLook = {40, 30, 1500};
constexpr double kWorthASecondLook = 0.8;  ///< of the loss as stated
constexpr std::size_t kSecondLooks = 2;    ///< of each kind
/// Control points among which every exchange of two is looked at.
constexpr std::size_t kFewPoints = 4;
constexpr double kPlainSigmas = 8.0;  ///< by which an exchange must explain more than what was stated

/// The statements as they might be meant: another site, or other recordings.
struct Reading {
  Contradiction what;
  std::function<Site(const Site&)> site;
  std::function<void(MeasurementLog&)> run;
};

class Search {
 public:
  Search(const Problem& problem, const Solution& solution, const SolveOptions& options)
      : problem_(problem), solution_(solution), options_(options), site_(problem.site) {
    for (SiteVehicle& v : site_.vehicles)
      v.array.reset();  // an array that is adjusted as a whole has one order of receivers
    options_.ranks = nullptr;
    const auto go_on = options.on_progress;
    if (go_on)
      options_.on_progress = [go_on](const Progress&) {
        return go_on({"other readings of the site file", 0, 0.0, 0.97});
      };
  }

  /// Exchanged control points alone.
  std::vector<Contradiction> exchanged() {
    look_as_stated();
    try_exchanged_points();
    return best();
  }

  std::vector<Contradiction> run() {
    look_as_stated();
    try_numbered_stops();
    if (found_.empty()) try_exchanged_points();
    const bool scale_is_right = stated_.agreeing >= kScaleAgrees && stated_.noise <= kNoise;
    if (nothing_but_exchanges()) {
      std::vector<Reading> scales = units(scale_is_right);
      if (const auto reading = ranging(); reading && !scale_is_right) scales.push_back(*reading);
      try_out(scales);
    }
    // A wrong frame of short lever arms looks much like receivers in another unit: both have their turn.
    if (nothing_but_exchanges() || !poses().empty()) {
      std::vector<Reading> frames = poses();
      for (Reading& reading : wired_otherwise()) frames.push_back(std::move(reading));
      try_out(frames);
    }
    return best();
  }

 private:
  struct Tried {
    Contradiction what;
    ReadingScore score;
  };
  static constexpr double kScaleAgrees =
      0.5;  ///< a share of agreeing arrivals that no wrong scale of all leaves

  void look_as_stated() {
    first_ = few_of(problem_.runs, site_.beacons.size(), kFirstLook);
    second_ = few_of(problem_.runs, site_.beacons.size(), kSecondLook);
    stated_first_ = score_of(site_, first_, options_, false);
    stated_ = score_of(site_, second_, options_, true);
  }

  /// Two points at each other's places take a part of what receivers wired otherwise do to the ranges: what
  /// is found of them settles nothing before all else had its turn.
  [[nodiscard]] bool nothing_but_exchanges() const {
    return std::all_of(found_.begin(), found_.end(),
                       [](const Tried& t) { return t.what.kind == ContradictionKind::kExchanged; });
  }

  [[nodiscard]] bool stopped() const { return options_.on_progress && !options_.on_progress({}); }

  /// Share of the arrivals that agree with what was stated, to the noise that another reading finds: with a
  /// noise many times larger everything agrees with anything.
  [[nodiscard]] double agreeing_as_stated(double noise) const {
    const double limit = options_.rejection_sigmas * noise;
    const auto agreeing = std::count_if(stated_.sizes.begin(), stated_.sizes.end(),
                                        [limit](double size) { return size <= limit; });
    return static_cast<double>(agreeing) / std::max(1.0, stated_.arrivals);
  }

  /// By itself, whatever the statements explain.
  [[nodiscard]] bool is_good(const ReadingScore& s) const {
    return s.agreeing >= std::max(kAgreeingShare, agreeing_as_stated(s.noise)) && s.noise <= kNoise &&
           s.redundancy >= kRedundant;
  }

  [[nodiscard]] bool explains(const ReadingScore& s) const {
    return is_good(s) && stated_.loss - s.loss >= kGain && s.loss <= kFactor * stated_.loss;
  }

  [[nodiscard]] ReadingScore score(const Reading& reading, const std::vector<MeasurementLog>& runs,
                                   bool search_again) const {
    if (!reading.run) return score_of(reading.site(site_), runs, options_, search_again);
    std::vector<MeasurementLog> others = runs;
    for (MeasurementLog& run : others) reading.run(run);
    return score_of(reading.site ? reading.site(site_) : site_, others, options_, search_again);
  }

  /// A first look at each, a second one at those that explain the log far better than the statements do.
  void try_out(const std::vector<Reading>& readings) {
    std::vector<std::pair<double, std::size_t>> ranking;
    for (std::size_t i = 0; i < readings.size() && !stopped(); ++i) {
      const double loss = score(readings[i], first_, false).loss;
      if (loss < kWorthASecondLook * stated_first_.loss) ranking.emplace_back(loss, i);
    }
    std::stable_sort(ranking.begin(), ranking.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::map<ContradictionKind, std::size_t> looked_at;  // of each kind: of poses in a mirrored frame and
                                                         // receivers wired so, each is to have its turn
    std::erase_if(ranking,
                  [&](const auto& r) { return ++looked_at[readings[r.second].what.kind] > kSecondLooks; });
    std::sort(ranking.begin(), ranking.end(),
              [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const auto& [loss, i] : ranking) {
      if (stopped()) return;
      const ReadingScore s = score(readings[i], second_, true);
      if (explains(s)) found_.push_back({readings[i].what, s});
    }
  }

  /// Stops that no epoch column tells apart, or all under one number. What is chosen of the runs depends on
  /// the epochs, so it is chosen anew.
  void try_numbered_stops() {
    std::vector<MeasurementLog> runs = problem_.runs;
    std::vector<std::string> names;
    std::size_t stops = 0;
    bool numbered = false;
    for (MeasurementLog& run : runs) {
      const bool had_epochs = run.has_epochs;
      const std::size_t found = number_stops(run);
      if (found == 0) continue;
      stops += found;
      numbered = numbered || had_epochs;
      names.push_back(run.path + "/tof.csv");
    }
    if (stops == 0) return;
    const std::string files = fmt::format("{}", fmt::join(names, ", "));
    const Contradiction what{
        ContradictionKind::kEpochs,
        files,
        numbered ? "one epoch for all" : "no column epoch",
        fmt::format("that the times of its arrivals come in {} groups with pauses between, and in each of "
                    "them fit a vehicle that stands still",
                    stops),
        0.0,
        "add a column epoch that numbers the stops: rows with the same epoch share one pose of the vehicle"};
    const ReadingScore s = score_of(site_, few_of(runs, site_.beacons.size(), kSecondLook), options_, true);
    if (explains(s)) found_.push_back({what, s});
  }

  /// The best of them. Control points that are exchanged leave most of the shape of the site as it is, so
  /// that many arrivals agree with what was stated: as nothing is adjusted to it, a plain gain in likelihood
  /// suffices, unless a single point that is elsewhere explains more.
  void try_exchanged_points() {
    std::optional<Tried> least;
    for (const Reading& reading : exchanged_points()) {
      if (stopped()) return;
      const ReadingScore s = score(reading, second_, true);
      const bool plain = s.arrivals * (stated_.loss - s.loss) >= 0.5 * kPlainSigmas * kPlainSigmas;
      if (plain && is_good(s) && (!least || s.loss < least->score.loss)) least = {reading.what, s};
    }
    for (std::size_t b = 0; b < site_.beacons.size() && least; ++b) {
      if (!site_.beacons[b].is_control_point()) continue;
      Site released = site_;
      released.beacons[b].position_m = {};
      released.beacons[b].sigma_m = {};
      if (score_of(released, second_, options_, true).loss < least->score.loss - kTie) least.reset();
    }
    if (least && !stopped()) found_.push_back(*least);
  }

  [[nodiscard]] std::optional<Reading> ranging() const {
    if (site_.timing.clock == Clock::kCycleOffset) return {};
    const bool one_way = site_.timing.ranging == Ranging::kOneWay;
    const auto other = [one_way](Site site) {
      site.timing.ranging = one_way ? Ranging::kTwoWay : Ranging::kOneWay;
      return site;
    };
    return Reading{
        {ContradictionKind::kRanging, "the arrivals", one_way ? "one_way" : "two_way",
         one_way ? "that the times of flight are times there and back (two-way), though timing.ranging says "
                   "one_way"
                 : "that the times of flight are one-way times, though timing.ranging says two_way, the time "
                   "there and back",
         0.0, one_way ? "state timing.ranging: two_way, and turnaround_s" : "state timing.ranging: one_way"},
        other,
        {}};
  }

  static Reading unit(const LengthUnit& u, const ScaledParts& parts, const std::string& whose) {
    return {{ContradictionKind::kUnits, "positions of " + whose, "metres",
             fmt::format("that they are in {}", u.name), 0.0,
             fmt::format("multiply them (and their sigmas, where these are in {} too) by {:g}", u.name,
                         u.metres)},
            [u, parts](const Site& site) { return in_unit(site, u, parts); },
            {}};
  }

  /// @param some_only  of beacons of another order of magnitude than the rest alone
  [[nodiscard]] std::vector<Reading> units(bool some_only) const {
    const std::vector<bool> none(site_.beacons.size(), false);
    std::vector<bool> all = none;
    for (std::size_t b = 0; b < all.size(); ++b)
      all[b] = std::any_of(site_.beacons[b].position_m.begin(), site_.beacons[b].position_m.end(),
                           [](const auto& x) { return x.has_value(); });
    const bool placed = std::find(all.begin(), all.end(), true) != all.end();
    std::vector<Reading> readings;
    for (const LengthUnit& u : length_units()) {
      if (placed && !some_only) readings.push_back(unit(u, {all, false}, "the beacons"));
      if (placed && !some_only) readings.push_back(unit(u, {all, true}, "the beacons and receivers"));
      if (!some_only) readings.push_back(unit(u, {none, true}, "the receivers"));
      const std::vector<bool> some = beacons_in_unit(site_, u);
      std::vector<std::string> names;
      for (std::size_t b = 0; b < some.size(); ++b)
        if (some[b]) names.push_back(site_.beacons[b].name);
      if (!names.empty())
        readings.push_back(unit(u, {some, false}, fmt::format("beacons {}", fmt::join(names, ", "))));
    }
    return readings;
  }

  /// Two of a few control points at each other's places. Of three that are all the datum each can be blamed
  /// by itself, as it may move to where it agrees with the two others; an exchange explains the same with
  /// nothing to adjust.
  [[nodiscard]] std::vector<Reading> exchanged_points() const {
    std::vector<std::size_t> points;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      if (site_.beacons[b].is_control_point()) points.push_back(b);
    std::vector<Reading> readings;
    if (points.size() > kFewPoints) return readings;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = i + 1; j < points.size(); ++j) {
        const std::size_t a = points[i], b = points[j];
        const std::string names = site_.beacons[a].name + ", " + site_.beacons[b].name;
        readings.push_back(
            {{ContradictionKind::kExchanged, names, "at the places in the site file",
              "at each other's places", 0.0,
              fmt::format("exchange the positions of control points {} and {} in the site file, or their "
                          "labels on the wall",
                          site_.beacons[a].name, site_.beacons[b].name)},
             [a, b](const Site& site) {
               Site other = site;
               std::swap(other.beacons[a].position_m, other.beacons[b].position_m);
               return other;
             },
             {}});
      }
    return readings;
  }

  [[nodiscard]] std::vector<Reading> poses() const {
    std::vector<Reading> readings;
    if (std::none_of(problem_.runs.begin(), problem_.runs.end(),
                     [](const MeasurementLog& run) { return !run.poses.empty(); }))
      return readings;
    for (const Reflection& reflection : reflections())
      readings.push_back(
          {{ContradictionKind::kPoses, "in poses.tum", "in a right-handed frame",
            fmt::format("that their frame is left-handed (mirrored): {}", reflection.words), 0.0,
            "export the poses in a right-handed frame: z up, headings counter-clockwise from x"},
           {},
           [read = reflection.read](MeasurementLog& run) {
             for (TimedPose& pose : run.poses) pose.T_map_vehicle = read(pose.T_map_vehicle);
           }});
    return readings;
  }

  [[nodiscard]] std::vector<Reading> wired_otherwise() const {
    std::vector<Reading> readings;
    const std::vector<bool> doubtful = doubtful_receivers(site_, solution_.trajectories);
    for (std::size_t v = 0; v < site_.vehicles.size(); ++v)
      for (const Wiring& wiring : wirings(site_, VehicleId(v), doubtful))
        readings.push_back(
            {{ContradictionKind::kWiring, "of " + site_.vehicles[v].name, "wired as in the site file",
              "that " + wiring.words, 0.0, "check the cables, or exchange the places in the site file"},
             [v, wiring](const Site& site) { return rewired(site, VehicleId(v), wiring); },
             {}});
    return readings;
  }

  /// The likeliest, and of other kinds those that are as likely; of one kind the first that is as good as
  /// any, which is the likelier mistake.
  std::vector<Contradiction> best() {
    std::vector<Contradiction> told;
    double least = INFINITY;
    for (const Tried& t : found_) least = std::min(least, t.score.loss);
    for (Tried& t : found_) {
      const bool said = std::any_of(told.begin(), told.end(),
                                    [&](const Contradiction& m) { return m.kind == t.what.kind; });
      if (said || t.score.loss > least + kTie) continue;
      t.what.found += fmt::format(" (so read {:.0f} % of the arrivals agree, as stated {:.0f} %)",
                                  100 * t.score.agreeing, 100 * agreeing_as_stated(t.score.noise));
      t.what.sigmas = std::sqrt(2 * t.score.arrivals * (stated_.loss - t.score.loss));
      told.push_back(std::move(t.what));
    }
    return told;
  }

  const Problem& problem_;
  const Solution& solution_;
  SolveOptions options_;
  Site site_;
  std::vector<MeasurementLog> first_, second_;  ///< evenly spread parts for a first and a second look
  ReadingScore stated_first_, stated_;
  std::vector<Tried> found_;
};

bool is_dragged(const Problem& problem, const Solution& solution) {
  const Site& site = problem.site;
  for (std::size_t r = 0; r < site.receivers.size() && r < solution.state.receiver_p_vehicle_m.size(); ++r)
    for (int i = 0; i < 3; ++i) {
      const double sigma = site.receivers[r].sigma_m[i];
      if (sigma > 0 && std::abs(solution.state.receiver_p_vehicle_m[r][i] - site.receivers[r].position_m[i]) >
                           kDraggedSigmas * sigma)
        return true;
    }
  return false;
}

}  // namespace

bool seems_misread(const Problem& problem, const Solution& solution) {
  std::size_t rows = 0, early = 0;
  for (const MeasurementLog& run : problem.runs) rows += run.arrivals.size();
  if (rows == 0 || solution.status == SolveStatus::kInterrupted) return false;
  if (solution.status == SolveStatus::kNotConverged || solution.beacon_status.empty())
    return true;  // nothing came of it
  for (const LeftOut& l : solution.left_out) early += l.reason == Rejection::kEarly;
  const double all = static_cast<double>(rows);
  if (early >= kEarlyAtLeast && static_cast<double>(early) > kEarlyShare * all) return true;
  if (static_cast<double>(solution.left_out.size()) > kLeftOutShare * all) return true;
  if (problem.site.noise.tof_sigma_s > 0 &&
      solution.tof_sigma_s > kNoiseRatio * problem.site.noise.tof_sigma_s)
    return true;
  return is_dragged(problem, solution);
}

std::vector<Contradiction> find_misreadings(const Problem& problem, const Solution& solution,
                                            const SolveOptions& options) {
  return Search(problem, solution, options).run();
}

std::vector<Contradiction> find_exchanged_points(const Problem& problem, const Solution& solution,
                                                 const SolveOptions& options) {
  return Search(problem, solution, options).exchanged();
}

}  // namespace octant::calib

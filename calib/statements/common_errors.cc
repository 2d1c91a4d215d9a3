// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/common_errors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace octant::calib {
namespace {

using Kind = CommonError::Kind;
using Span = std::pair<double, double>;

/// Below this it is chance, or what a site's many small errors add up to.
constexpr double kBeyondChance = 6.0;
/// Errors whose squared sigmas differ by less than this (twice a log likelihood) are told apart by nothing.
constexpr double kAsLikely = 10.0;
/// Looked at of a long recording.
constexpr std::size_t kArrivals = 20'000;
/// Times of a recording at which a jump is looked for.
constexpr Eigen::Index kJumps = 32;
/// What is faster is no sound, whose speed hangs on the temperature.
constexpr double kFasterThanSound_mps = 1e5;

/// Of a recording: -1/2 at its beginning to 1/2 at its end.
double share_of(const Span& span_s, double time_s) {
  return (time_s - span_s.first) / (span_s.second - span_s.first) - 0.5;
}

/// When the arrivals of a run came.
struct Times {
  Span span_s{INFINITY, -INFINITY};
  std::vector<double> jump_s;  ///< as many arrivals between one and the next
};

Times times_of(const std::vector<Trajectory>& trajectories) {
  std::vector<double> all;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) all.push_back(a.time_s);
  Times times;
  if (all.empty()) return times;
  std::ranges::sort(all);
  times.span_s = {all.front(), all.back()};
  for (std::size_t j = 1; j <= kJumps; ++j) times.jump_s.push_back(all[j * all.size() / (kJumps + 1)]);
  return times;
}

/// The errors that are tested in a run, in order: odometry's way and turns, the medium's change, the clock's
/// drift and its jumps.
class Patterns {
 public:
  static constexpr Eigen::Index kOfOdometry = 2, kCount = kOfOdometry + 2 + kJumps;

  explicit Patterns(Times times) : times_(std::move(times)) {}

  bool operator()(const Trajectory& t, const ObservationRow& row, Eigen::RowVectorXd& by) {
    by.setZero(kCount);
    // Beside measured poses little hangs on odometry, and exact ones tell how the way between rows was bent.
    if (row.kind == RowKind::kOdometry && t.motion == Motion::kPlanar && t.poses.empty()) {
      of_step(t.odometry[row.index], by);
      return true;
    }
    if (row.kind != RowKind::kTof || !(times_.span_s.second > times_.span_s.first)) return false;
    const ArrivalObservation& a = t.arrivals[row.index];
    const double share = share_of(times_.span_s, a.time_s);
    by[kOfOdometry] = -a.tof_s * share / a.sigma_s;
    by[kOfOdometry + 1] = share / a.sigma_s;
    for (Eigen::Index j = 0; j < kJumps; ++j)
      if (a.time_s >= times_.jump_s[static_cast<std::size_t>(j)]) by[kOfOdometry + 2 + j] = 1.0 / a.sigma_s;
    return true;
  }

  /// Of a column behind odometry's.
  [[nodiscard]] CommonError error_of(Eigen::Index column, std::size_t run) const {
    const Eigen::Index what = column - kOfOdometry;
    if (what < 2) return {.kind = what == 0 ? Kind::kSpeed : Kind::kDrift, .run = run};
    return {.kind = Kind::kJump, .run = run, .time_s = times_.jump_s[static_cast<std::size_t>(what - 2)]};
  }

 private:
  /// Rows of a step come one after the other: x, y, heading.
  void of_step(const OdometryObservation& o, Eigen::RowVectorXd& by) {
    const int component = odometry_rows_++ % 3;
    if (component < 2) {
      by[0] = o.T_before_after.translation_m[component] / o.distance_sigma_m;
    } else {
      by[1] = o.T_before_after.heading_rad() / o.heading_sigma_rad;
    }
  }

  Times times_;
  int odometry_rows_ = 0;
};

/// By run.
std::map<std::size_t, std::vector<Trajectory>> some_of_each(const std::vector<Trajectory>& trajectories) {
  std::size_t arrivals = 0;
  for (const Trajectory& t : trajectories) arrivals += t.arrivals.size();
  std::map<std::size_t, std::vector<Trajectory>> some;
  for (const Trajectory& t : trajectories) some[t.run].push_back(some_segments(t, arrivals / kArrivals + 1));
  return some;
}

/// Each error of each run beyond chance, and odometry's, of which all runs have one.
std::vector<CommonError> all_beyond_chance(const std::vector<Trajectory>& trajectories,
                                           const SharedState& state, const AdjustedParameters& parameters,
                                           double growth, int threads) {
  std::vector<CommonError> all;
  const auto add = [&](CommonError error, const ScoreTest& test, Eigen::Index column) {
    error.size = test.size(column);
    error.sigmas = test.sigmas(column) / growth;
    if (std::abs(error.sigmas) > kBeyondChance) all.push_back(error);
  };
  ScoreTest of_odometry{Eigen::VectorXd::Zero(Patterns::kOfOdometry),
                        Eigen::VectorXd::Zero(Patterns::kOfOdometry)};
  std::size_t driven_run = 0;
  for (const auto& [run, of_run] : some_of_each(trajectories)) {
    const Times times = times_of(of_run);
    Patterns patterns(times);
    const ScoreTest test =
        score_test(of_run, state, parameters, Patterns::kCount, std::ref(patterns), threads);
    of_odometry.gradient += test.gradient.head(Patterns::kOfOdometry);
    of_odometry.information += test.information.head(Patterns::kOfOdometry);
    if (test.information.head(Patterns::kOfOdometry).sum() > 0) driven_run = run;
    if (times.jump_s.empty()) continue;  // nothing was heard
    const bool is_sound = of_run.front().nominal_speed_mps < kFasterThanSound_mps;
    for (Eigen::Index column = Patterns::kOfOdometry; column < Patterns::kCount; ++column)
      if (const CommonError error = patterns.error_of(column, run); is_sound || error.kind != Kind::kSpeed)
        add(error, test, column);
  }
  add({.kind = Kind::kWay, .run = driven_run}, of_odometry, 0);
  add({.kind = Kind::kTurns, .run = driven_run}, of_odometry, 1);
  return all;
}

/// Errors of different recordings, or of odometry and of arrivals, do not explain each other.
bool are_rivals(const CommonError& a, const CommonError& b) {
  return is_of_odometry(a) == is_of_odometry(b) && (is_of_odometry(a) || a.run == b.run);
}

std::string longer_by(double step_s) {
  return fmt::format("{:.4g} ms {}", 1e3 * std::abs(step_s), step_s > 0 ? "longer" : "shorter");
}

Contradiction of_odometry(const CommonError& e, const std::string& file) {
  const bool turns = e.kind == Kind::kTurns, much = e.size > 0;
  return {
      ContradictionKind::kLog,
      file,
      "metres and radians as the vehicle went them",
      fmt::format("that {} {:.2g} % too {}", turns ? "its turns are" : "its way is", 100 * std::abs(e.size),
                  turns ? (much ? "large" : "small") : (much ? "long" : "short")),
      e.sigmas,
      fmt::format("look at {}, or multiply {} by {:.4g}",
                  turns ? "the distance between the wheels, or the gyroscope" : "the diameter of the wheels",
                  turns ? "dheading_rad" : "dx_m and dy_m", 1.0 / (1.0 + e.size))};
}

Contradiction of_speed(const CommonError& e, const Site& site, const std::string& path) {
  const double speed = speed_mps(site.medium),
               per_degree = speed_mps(site.medium, site.medium.temperature_degC + 1) - speed;
  const std::string air =
      per_degree > 0 ? fmt::format(", as in air that {} by {:.2g} degC", e.size > 0 ? "warms" : "cools",
                                   std::abs(e.size) * speed / per_degree)
                     : "";
  return {ContradictionKind::kLog,
          path,
          "the medium in one state throughout",
          fmt::format("that sound is {:.2g} % {} at its end than at its beginning{}", 100 * std::abs(e.size),
                      e.size > 0 ? "faster" : "slower", air),
          e.sigmas,
          "log the temperature with the arrivals (temperature_degC in tof.csv), or make a recording of each "
          "part and state its temperature in run.yaml"};
}

}  // namespace

std::vector<CommonError> common_errors(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                       const AdjustedParameters& parameters, double growth, int threads) {
  std::vector<CommonError> all = all_beyond_chance(trajectories, state, parameters, growth, threads);
  std::ranges::stable_sort(all, std::ranges::greater{}, [](const auto& e) { return std::abs(e.sigmas); });
  std::vector<CommonError> errors;
  for (CommonError& e : all) {
    const auto of_kind = [&](const CommonError& other) {
      return other.kind == e.kind && (is_of_odometry(e) || other.run == e.run);
    };
    if (std::ranges::any_of(errors, of_kind)) continue;
    const auto likelier =
        std::ranges::find_if(errors, [&](const auto& other) { return are_rivals(e, other); });
    if (likelier != errors.end()) {
      e.rank = CommonError::Rank::kLess;
      if (likelier->sigmas * likelier->sigmas - e.sigmas * e.sigmas < kAsLikely)
        likelier->rank = CommonError::Rank::kAmongEquals;
    }
    errors.push_back(e);
  }
  for (CommonError& e : errors) e.sigmas = std::abs(e.sigmas);
  return errors;
}

std::string jump_in_words(double time_s, double step_s) {
  return fmt::format("from {:.6g} s on times of flight are {}", time_s, longer_by(step_s));
}

Contradiction contradiction_of(const CommonError& e, const Site& site,
                               const std::vector<MeasurementLog>& runs) {
  const std::string& path = runs[e.run].path;
  if (is_of_odometry(e)) return of_odometry(e, path + "/odometry.csv");
  if (e.kind == Kind::kSpeed) return of_speed(e, site, path);
  if (e.kind == Kind::kDrift)
    return {
        ContradictionKind::kLog,
        path,
        "one clock throughout",
        fmt::format("that it drifts: times of flight are {} at its end than at its beginning",
                    longer_by(e.size)),
        e.sigmas,
        "look at what synchronises beacons and receivers, and let the electronics warm up before recording"};
  return {ContradictionKind::kLog,
          path,
          "one clock throughout",
          "that it jumped: " + jump_in_words(e.time_s, e.size),
          e.sigmas,
          "look at what synchronises beacons and receivers (a restart, a lost pulse), and leave out what was "
          "recorded before the jump or after it"};
}

void take_back(const CommonError& e, Span span_s, MeasurementLog& run) {
  const double factor = 1.0 / (1.0 + e.size);
  if (is_of_odometry(e)) {
    for (OdometryStep& step : run.odometry) {
      if (e.kind == Kind::kTurns) step.dheading_rad *= factor;
      if (e.kind == Kind::kWay) step.dx_m *= factor, step.dy_m *= factor, step.way_m *= factor;
    }
    return;
  }
  for (Arrival& a : run.arrivals) {
    if (e.kind == Kind::kSpeed) a.tof_s /= 1.0 - e.size * share_of(span_s, a.time_s);
    if (e.kind == Kind::kDrift) a.tof_s -= e.size * share_of(span_s, a.time_s);
    if (e.kind == Kind::kJump && a.time_s >= e.time_s) a.tof_s -= e.size;
  }
}

Span span_of(const std::vector<Arrival>& arrivals) {
  Span span_s{INFINITY, -INFINITY};
  for (const Arrival& a : arrivals)
    span_s = {std::min(span_s.first, a.time_s), std::max(span_s.second, a.time_s)};
  return span_s;
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Two hundred simulated sites that are visited again after one change: what recalibration and monitoring find
// of it, what they name it, and how good the new deployment is.
//   octant_second_visits [--sites 200] [--seed 1] [--threads 1] [--drift 1] [--told 1] [--event N]
//   [--verbose]
// --drift: of what six months do (Drift::of_months), so much truly happens; --told: so much is allowed for.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include <fmt/format.h>

#include "calib/calibrate.h"
#include "calib/revisit/revisit.h"
#include "models/changes/change_search.h"
#include "models/support/parallel.h"
#include "tests/studies/changed_site.h"
#include "tests/support/worlds.h"

namespace octant::study {
namespace {

constexpr double kMonths = 6.0, kSeen = 4.0;
constexpr double kConfidence = 0.99;

struct Words {
  std::size_t sites = 200;
  std::uint64_t seed = 1;
  int threads = 1;
  double drift = 1.0, told = 1.0;
  int event = -1;
  bool verbose = false;
};

Drift of_six_months(double share) {
  Drift d = Drift::of_months(kMonths);
  for (double* sigma : {&d.beacon_m, &d.delay_s, &d.receiver_m, &d.speed_mps, &d.log_gain, &d.attenuation})
    *sigma *= std::max(share, 1e-3);  // a prior of nothing at all has no inverse
  return d;
}

/// Names in a subject: "B2, B5" are two.
bool accuses(const Change& c, const std::string& subject) {
  const std::string list = ", " + c.subject + ",";
  return list.find(" " + subject + ",") != std::string::npos;
}

/// What was said of one true change.
struct Told {
  double sigmas = 0.0, distance = 0.0;  ///< see Visibility
  bool found = false, right = false;
};
struct Answer {
  bool ok = false;
  std::string message;
  std::vector<Told> told;
  std::vector<std::string> innocent;  ///< accused subjects
  double seconds = 0.0;
};

/// By how many sigmas a change is seen.
struct Visibility {
  double sigmas = 0.0;    ///< its size over the sigma of its size, as reports print it
  double distance = 0.0;  ///< Mahalanobis' distance in the covariance of its estimate: the power of the test
};
Visibility visibility(const TrueChange& truth, const Comparison& comparison) {
  const ChangeKind kind = truth.kind == ChangeKind::kExchanged ? ChangeKind::kBeaconMoved : truth.kind;
  for (const TestedChange& t : comparison.search.tested) {
    const ChangeHypothesis& h = comparison.hypotheses[t.hypothesis];
    if (h.kind != kind || h.owner != truth.owner) continue;
    if (kind == ChangeKind::kDelay) {
      const double sigmas = truth.delay_s / std::sqrt(t.covariance(0, 0));
      return {sigmas, sigmas};
    }
    const Eigen::Matrix3d C = t.covariance.topLeftCorner<3, 3>();
    const Eigen::Vector3d& by_m = truth.shift_m;
    return {by_m.squaredNorm() / std::sqrt(by_m.dot(C * by_m)), std::sqrt(by_m.dot(C.ldlt().solve(by_m)))};
  }
  return {};
}

bool is_right(const TrueChange& truth, const Change& said) {
  if (said.kind != truth.kind) return false;
  const double off = truth.kind == ChangeKind::kDelay ? std::abs(said.size - truth.delay_s)
                                                      : std::abs(said.size - truth.shift_m.norm());
  return off <= std::max(5 * said.sigma, 0.2 * std::abs(said.size));
}

Answer answer_of(const ChangedSite& site, const Result<calib::Revisit>& found) {
  Answer out;
  if (!found || found->status != calib::SolveStatus::kConverged) {
    out.message = found ? found->message : found.error().message();
    return out;
  }
  out.ok = true;
  out.seconds = found->seconds;
  const auto& changes = found->comparison.changes;
  for (const TrueChange& truth : site.changes) {
    const Visibility seen = visibility(truth, found->comparison);
    Told told{seen.sigmas, seen.distance, false, false};
    int accusations = 0;
    for (const Change& c : changes)
      if (accuses(c, truth.subject)) {
        told.found = true;
        ++accusations;
        told.right = is_right(truth, c);
      }
    told.right = told.right && accusations == 1;
    out.told.push_back(told);
  }
  for (const Change& c : changes)
    if (std::none_of(site.changes.begin(), site.changes.end(),
                     [&](const TrueChange& t) { return accuses(c, t.subject); }))
      out.innocent.push_back(fmt::format("{} {} {:.3g}", to_string(c.kind), c.subject, c.size));
  return out;
}

struct Score {
  Event event = Event::kNothing;
  std::uint64_t seed = 0;
  bool drives = false;
  std::string fault;
  Answer recalibrated, monitored;
  double nees = 0.0, squares = 0.0, fresh_squares = 0.0;
  int coordinates = 0, compared = 0;
};

/// The new deployment against the truth of the second visit, and a fresh calibration of both visits beside
/// it.
void weigh(const ChangedSite& site, const Deployment& left, Score& score) {
  std::vector<int> at;
  std::vector<double> error;
  std::vector<std::size_t> beacons;
  const auto truth = [&](std::size_t b) -> const Eigen::Vector3d& {
    return site.second.truth.beacons[b].position_m;
  };
  for (std::size_t b = 0; b < left.beacons.size(); ++b) {
    if (left.beacons[b].status != BeaconStatus::kCalibrated) continue;
    beacons.push_back(b);
    for (std::size_t i = 0; i < 3; ++i) {
      const int k = left.covariance.index_of(parameters::beacon_position(b, i));
      if (k < 0) continue;
      at.push_back(k);
      error.push_back((left.beacons[b].position_m - truth(b))[static_cast<Eigen::Index>(i)]);
    }
  }
  const Eigen::Map<const Eigen::VectorXd> e(error.data(), static_cast<Eigen::Index>(error.size()));
  const Eigen::MatrixXd C = left.covariance.matrix(at, at);
  score.nees = e.dot(C.ldlt().solve(e));
  score.coordinates = static_cast<int>(at.size());

  BothVisits both = both_visits(site);
  auto problem = calib::make_problem(both.site, {site.first.run, std::move(both.second)});
  if (!problem) return;
  const calib::Solution fresh = calib::solve_in_place(*problem);
  if (fresh.status != calib::SolveStatus::kConverged) return;
  for (const std::size_t b : beacons) {
    score.squares += (left.beacons[b].position_m - truth(b)).squaredNorm();
    score.fresh_squares += (fresh.state.beacon_p_map_m[both.beacon[b]] - truth(b)).squaredNorm();
    ++score.compared;
  }
}

Score visit(Event event, std::uint64_t seed, const Words& words) {
  Score score;
  score.event = event;
  score.seed = seed;
  const ChangedSite site = changed_site(event, seed, of_six_months(words.drift));
  score.drives = site.drives;
  auto problem = calib::make_problem(site.first.site, {site.first.run});
  if (!problem) {
    score.fault = problem.error().message();
    return score;
  }
  const calib::Solution solution = calib::solve(*problem);
  if (solution.status != calib::SolveStatus::kConverged) {
    score.fault = "the first visit: " + solution.message;
    return score;
  }
  Deployment before = calib::make_deployment(*problem, solution, {"2026-01-01T00:00:00Z", "", "", {}});
  before.digest = "first";
  calib::RevisitOptions options;
  options.drift = of_six_months(words.told);
  const auto found = calib::revisit(before, {site.second.run}, options);
  score.recalibrated = answer_of(site, found);
  score.monitored = answer_of(site, calib::revisit(before, {site.second.heldout}, options));
  if (score.recalibrated.ok) weigh(site, found->as_left, score);
  return score;
}

// ------------------------------------------------------------------------------------------------ the table

double binomial_at_most(std::size_t k, std::size_t n, double p) {
  double sum = 0.0;
  for (std::size_t i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(static_cast<double>(n) + 1.0) - std::lgamma(static_cast<double>(i) + 1.0) -
                    std::lgamma(static_cast<double>(n - i) + 1.0) + static_cast<double>(i) * std::log(p) +
                    static_cast<double>(n - i) * std::log1p(-p));
  return sum;
}
/// As many of n as a rate does not exceed with a probability of 99 %.
std::size_t at_most(std::size_t n, double rate) {
  std::size_t k = 0;
  while (k < n && binomial_at_most(k, n, rate) < kConfidence) ++k;
  return k;
}

struct Count {
  std::size_t yes = 0, all = 0;
  void add(bool one) {
    yes += one;
    ++all;
  }
  [[nodiscard]] std::string text() const {
    return all == 0 ? "-"
                    : fmt::format("{}/{} {:.1f} %", yes, all,
                                  100.0 * static_cast<double>(yes) / static_cast<double>(all));
  }
};

struct Tally {
  Count found, right;         ///< of changes seen at four sigmas and more
  Count weak;                 ///< found of those below
  Count accused;              ///< visits at which an innocent is accused
  std::map<int, Count> bins;  ///< found, by whole units of distance up to 10
  std::vector<double> seconds;

  void add(const Answer& answer) {
    if (!answer.ok) return;
    accused.add(!answer.innocent.empty());
    seconds.push_back(answer.seconds);
    for (const Told& t : answer.told) {
      bins[std::min(10, static_cast<int>(t.distance))].add(t.found);
      if (t.sigmas < kSeen) {
        weak.add(t.found);
        continue;
      }
      found.add(t.found);
      if (t.found) right.add(t.right);
    }
  }
};

void print_table(const std::vector<Score>& scores) {
  std::map<Event, std::array<Tally, 2>> by_event;
  std::array<Tally, 2> all, quiet;
  double nees = 0.0, squares = 0.0, fresh = 0.0;
  int coordinates = 0;
  for (const Score& s : scores) {
    by_event[s.event][0].add(s.recalibrated);
    by_event[s.event][1].add(s.monitored);
    all[0].add(s.recalibrated);
    all[1].add(s.monitored);
    if (s.event == Event::kNothing || s.event == Event::kWarmer) {
      quiet[0].add(s.recalibrated);
      quiet[1].add(s.monitored);
    }
    nees += s.nees;
    coordinates += s.coordinates;
    squares += s.squares;
    fresh += s.fresh_squares;
  }
  const char* who[2] = {"recalibrate", "monitor"};
  for (int k = 0; k < 2; ++k) {
    fmt::print("\n{:<16}{:>18}{:>18}{:>18}{:>18}\n", who[k], "found", "named rightly", "found < 4 sigma",
               "innocent accused");
    for (const auto& [event, tally] : by_event) {
      const Tally& t = tally[static_cast<std::size_t>(k)];
      fmt::print("{:<16}{:>18}{:>18}{:>18}{:>18}\n", to_string(event), t.found.text(), t.right.text(),
                 t.weak.text(), t.accused.text());
    }
    Tally& t = all[static_cast<std::size_t>(k)];
    fmt::print("{:<16}{:>18}{:>18}{:>18}{:>18}\n", "all", t.found.text(), t.right.text(), t.weak.text(),
               t.accused.text());
    fmt::print("found, by whole units of Mahalanobis' distance:");
    for (const auto& [sigmas, count] : t.bins)
      fmt::print("  {}{} {}/{}", sigmas, sigmas == 10 ? "+" : "", count.yes, count.all);
    const Count& alarms = quiet[static_cast<std::size_t>(k)].accused;
    fmt::print(
        "\nfalse alarms: {} of {} visits at which nothing changed (bound {} of 99 % at the stated {}), {} of "
        "{} of all (bound {})\n",
        alarms.yes, alarms.all, at_most(alarms.all, kFalseAlarm), kFalseAlarm, t.accused.yes, t.accused.all,
        at_most(t.accused.all, kFalseAlarm));
    if (t.seconds.empty()) continue;
    std::sort(t.seconds.begin(), t.seconds.end());
    fmt::print("seconds of a visit: median {:.2f}, 95 % {:.2f}, longest {:.2f}\n",
               t.seconds[t.seconds.size() / 2], t.seconds[t.seconds.size() * 95 / 100], t.seconds.back());
  }
  fmt::print(
      "\nnew deployments: NEES {:.2f} of its degrees of freedom ({}), RMSE {:.2f} mm, {:.3f} of that of a "
      "fresh calibration of both visits\n",
      nees / std::max(1, coordinates), coordinates, 1e3 * std::sqrt(3 * squares / std::max(1, coordinates)),
      std::sqrt(squares / fresh));
}

void print_score(const Score& s, bool verbose) {
  const auto words = [&](const char* who, const Answer& a) {
    std::string text;
    if (!a.ok) text += fmt::format("  {} fails: {}", who, a.message);
    for (const Told& t : a.told)
      if (verbose || (t.sigmas >= kSeen && !(t.found && t.right)))
        text += fmt::format("  {}: {} at {:.1f} sigma (distance {:.1f})", who,
                            !t.found  ? "missed"
                            : t.right ? "right"
                                      : "wrongly named",
                            t.sigmas, t.distance);
    for (const std::string& name : a.innocent) text += fmt::format("  {} accuses {}", who, name);
    return text;
  };
  const std::string text = s.fault + words("recalibrate", s.recalibrated) + words("monitor", s.monitored);
  if (!verbose && text.empty()) return;
  fmt::print("seed {} {} ({}){}", s.seed, to_string(s.event), s.drives ? "drive" : "stops", text);
  if (verbose && s.compared > 0)
    fmt::print("  rmse {:.2f} fresh {:.2f} mm, NEES {:.2f}", 1e3 * std::sqrt(s.squares / s.compared),
               1e3 * std::sqrt(s.fresh_squares / s.compared), s.nees / std::max(1, s.coordinates));
  fmt::print("\n");
  std::fflush(stdout);
}

Words words_of(int argc, char** argv) {
  Words words;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (key == "--verbose") {
      words.verbose = true;
      continue;
    }
    const char* value = i + 1 < argc ? argv[++i] : "";
    if (key == "--sites")
      words.sites = std::strtoull(value, nullptr, 10);
    else if (key == "--seed")
      words.seed = std::strtoull(value, nullptr, 10);
    else if (key == "--threads")
      words.threads = std::atoi(value);
    else if (key == "--drift")
      words.drift = std::atof(value);
    else if (key == "--told")
      words.told = std::atof(value);
    else if (key == "--event")
      words.event = std::atoi(value);
    else {
      fmt::print(
          stderr,
          "octant_second_visits: {}: --sites, --seed, --threads, --drift, --told, --event or --verbose\n",
          key);
      std::exit(2);
    }
  }
  return words;
}

}  // namespace
}  // namespace octant::study

int main(int argc, char** argv) {
  using namespace octant::study;
  const Words words = words_of(argc, argv);
  std::vector<Score> scores(words.sites);
  octant::for_each_parallel(words.sites, words.threads, [&](std::size_t i) {
    const Event event =
        words.event >= 0 ? kEvents.at(static_cast<std::size_t>(words.event)) : kEvents[i % kEvents.size()];
    scores[i] = visit(event, words.seed + i, words);
    print_score(scores[i], words.verbose);
  });
  print_table(scores);
  return 0;
}

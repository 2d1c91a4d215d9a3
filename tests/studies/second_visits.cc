// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Two hundred simulated sites with a second visit after one change. Tests if recalibration and monitoring
// find and name the change, and the accuracy of the new deployment.
//   octant_second_visits [--sites 200] [--seed 1] [--threads 1] [--drift 1] [--told 1] [--event N]
//   [--verbose]
// Exit 1 if a requirement is not met within its binomial bound.
// --drift: true drift as a multiple of that of six months (drift_after); --told: the assumed multiple.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include <fmt/format.h>

#include "calib/calibrate.h"
#include "calib/revisit/revisit.h"
#include "models/changes/change_search.h"
#include "models/changes/change_sigmas.h"
#include "models/changes/chi_square.h"
#include "models/support/parallel.h"
#include "tests/studies/changed_site.h"
#include "tests/studies/visit_table.h"
#include "tests/support/worlds.h"

namespace octant::study {
namespace {

constexpr double kMonths = 6.0;

struct Words {
  std::size_t sites = 200;
  std::uint64_t seed = 1;
  int threads = 1;
  double drift = 1.0, told = 1.0;
  int event = -1;
  bool verbose = false;
};

Drift of_six_months(double share) {
  Drift d = drift_after(kMonths, {}, 343.0);
  for (double* sigma : {&d.beacon_m, &d.delay_s, &d.receiver_m, &d.speed_mps, &d.log_gain, &d.attenuation})
    *sigma *= std::max(share, 1e-3);  // a prior of nothing at all has no inverse
  return d;
}

/// Names in a subject: "B2, B5" are two.
bool accuses(const Change& c, const std::string& subject) {
  const std::string list = ", " + c.subject + ",";
  return list.find(" " + subject + ",") != std::string::npos;
}

/// The probability that chi-square with a noncentrality exceeds a value: Poisson's mixture of central ones.
double noncentral_tail(double value, int degrees_of_freedom, double noncentrality) {
  // The component along the mean alone exceeds it then; beacons that were exchanged are at 10^4 sigmas, and
  // Poisson's sum would not end.
  constexpr double kCertain = 8.0;
  if (std::sqrt(noncentrality) > std::sqrt(value) + kCertain) return 1.0;
  const double half = 0.5 * noncentrality;
  double sum = 0.0;
  const int most = static_cast<int>(half + 10 * std::sqrt(half + 1.0)) + 20;
  for (int j = 0; j <= most; ++j)
    sum += std::exp(j * std::log(std::max(half, 1e-300)) - half - std::lgamma(j + 1.0)) *
           chi_square_tail(value, degrees_of_freedom + 2 * j);
  return std::min(1.0, sum);
}

/// Significance of a change, before it is known if it was found.
Told visibility(const TrueChange& truth, const Comparison& comparison) {
  const ChangeKind kind = truth.kind == ChangeKind::kExchanged ? ChangeKind::kBeaconMoved : truth.kind;
  Told out;
  for (const TestedChange& t : comparison.search.tested) {
    const ChangeHypothesis& h = comparison.hypotheses[t.hypothesis];
    if (h.kind != kind || h.owner != truth.owner || t.degrees_of_freedom == 0) continue;
    if (kind == ChangeKind::kDelay) {
      out.sigmas = out.distance = truth.delay_s / std::sqrt(t.covariance(0, 0));
    } else {
      const Eigen::Matrix3d C = t.covariance.topLeftCorner<3, 3>();
      const Eigen::Vector3d& by_m = truth.shift_m;
      out.sigmas = by_m.squaredNorm() / std::sqrt(by_m.dot(C * by_m));
      out.distance = std::sqrt(by_m.dot(C.ldlt().solve(by_m)));
    }
    const double each = kFalseAlarm / static_cast<double>(comparison.hypotheses.size());
    const double squares = out.distance * out.distance;
    out.power = noncentral_tail(chi_square_beyond(each, t.degrees_of_freedom), t.degrees_of_freedom, squares);
    out.at_best = noncentral_tail(chi_square_beyond(each, 1), 1, squares);
  }
  return out;
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
    Told told = visibility(truth, found->comparison);
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

/// Compares the new deployment, and a new calibration of both visits, with the truth of the second visit.
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
  return print_table(scores) == 0 ? 0 : 1;
}

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/studies/visit_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include <fmt/format.h>

#include "models/changes/change_search.h"

namespace octant::study {
namespace {

constexpr double kSeen = 4.0;
constexpr double kConfidence = 0.99;

double binomial_at_most(std::size_t k, std::size_t n, double p) {
  double sum = 0.0;
  for (std::size_t i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(static_cast<double>(n) + 1.0) - std::lgamma(static_cast<double>(i) + 1.0) -
                    std::lgamma(static_cast<double>(n - i) + 1.0) + static_cast<double>(i) * std::log(p) +
                    static_cast<double>(n - i) * std::log1p(-p));
  return sum;
}
/// Number out of n that a rate does not exceed with a probability of 99 %.
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
  Count found, right;                 ///< among changes of four sigmas and more
  Count weak;                         ///< found of those below
  double power = 0.0, at_best = 0.0;  ///< sums over the observable changes: expected number of detections
  Count accused;                      ///< visits at which an innocent is accused
  std::map<int, Count> bins;          ///< found, by whole units of distance up to 10
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
      power += t.power;
      at_best += t.at_best;
      if (t.found) right.add(t.right);
    }
  }
};

/// All sites; of each, recalibration and monitoring.
struct Totals {
  std::map<Event, std::array<Tally, 2>> by_event;
  std::array<Tally, 2> all, quiet;  ///< quiet: there was no change
  double nees = 0.0, squares = 0.0, fresh = 0.0;
  int coordinates = 0;
  std::size_t faults = 0;

  void add(const Score& s) {
    const std::array<const Answer*, 2> answers = {&s.recalibrated, &s.monitored};
    for (std::size_t k = 0; k < 2; ++k) {
      by_event[s.event][k].add(*answers[k]);
      all[k].add(*answers[k]);
      if (s.event == Event::kNothing || s.event == Event::kWarmer) quiet[k].add(*answers[k]);
      faults += !answers[k]->ok;
    }
    nees += s.nees;
    coordinates += s.coordinates;
    squares += s.squares;
    fresh += s.fresh_squares;
  }
};

void print_answers(const char* who, std::size_t k, Totals& totals) {
  fmt::print("\n{:<16}{:>18}{:>18}{:>18}{:>18}\n", who, "found", "named rightly", "found < 4 sigma",
             "innocent accused");
  const auto line = [](const char* name, const Tally& t) {
    fmt::print("{:<16}{:>18}{:>18}{:>18}{:>18}\n", name, t.found.text(), t.right.text(), t.weak.text(),
               t.accused.text());
  };
  for (const auto& [event, tally] : totals.by_event) line(to_string(event), tally[k]);
  Tally& t = totals.all[k];
  line("all", t);
  fmt::print("found, by whole units of Mahalanobis' distance:");
  for (const auto& [sigmas, count] : t.bins)
    fmt::print("  {}{} {}/{}", sigmas, sigmas == 10 ? "+" : "", count.yes, count.all);
  fmt::print(
      "\nof {} above 4 sigma the test at its stated level finds {:.1f} on average, one that knew the "
      "direction "
      "beforehand {:.1f}\n",
      t.found.all, t.power, t.at_best);
  if (t.seconds.empty()) return;
  std::sort(t.seconds.begin(), t.seconds.end());
  fmt::print("seconds of a visit: median {:.2f}, 95 % {:.2f}, longest {:.2f}\n",
             t.seconds[t.seconds.size() / 2], t.seconds[t.seconds.size() * 95 / 100], t.seconds.back());
}

class Marks {
 public:
  /// Maximum number of errors out of n if the requirement is met.
  void share(const std::string& what, std::size_t wrong, std::size_t n, double mark) {
    const std::size_t bound = at_most(n, mark);
    line(fmt::format("{}: {} of {} ({:.1f} %), bound {}", what, wrong, n,
                     100.0 * static_cast<double>(wrong) / static_cast<double>(std::max<std::size_t>(n, 1)),
                     bound),
         wrong <= bound);
  }
  void line(const std::string& what, bool kept) {
    missed_ += !kept;
    fmt::print("{:<8}{}\n", kept ? "kept" : "MISSED", what);
  }
  [[nodiscard]] int missed() const { return missed_; }

 private:
  int missed_ = 0;
};

/// Misses that the power of the test permits, and another hundredth if that is less than the requirement.
double attainable(const Tally& t, double mark) {
  const auto n = static_cast<double>(std::max<std::size_t>(t.found.all, 1));
  return std::max(mark, 1.0 - t.power / n);
}

}  // namespace

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

int print_table(const std::vector<Score>& scores) {
  Totals totals;
  for (const Score& s : scores) totals.add(s);
  print_answers("recalibrate", 0, totals);
  print_answers("monitor", 1, totals);
  const double ratio = std::sqrt(totals.squares / totals.fresh);
  const double nees = totals.nees / std::max(1, totals.coordinates);
  fmt::print("\nnew deployments: {} coordinates, RMSE {:.2f} mm\n\nmarks, each within its bound of 99 %\n",
             totals.coordinates, 1e3 * std::sqrt(3 * totals.squares / std::max(1, totals.coordinates)));
  Marks marks;
  const auto missed = [](const Tally& t) { return t.found.all - t.found.yes; };
  const auto wrong = [](const Tally& t) { return t.right.all - t.right.yes; };
  const auto of_stated = [](const char* who, double share) {
    return fmt::format("{} does not find, of changes above 4 sigma, {:.2g} % (the test's own power lets it)",
                       who, 100 * share);
  };
  const Tally &left = totals.all[0], &night = totals.all[1];
  const double own = attainable(left, 0.01), of_night = attainable(night, 0.03);
  marks.share(of_stated("recalibrate", own), missed(left), left.found.all, own);
  marks.share("recalibrate names wrongly 5 % of those found", wrong(left), left.right.all, 0.05);
  marks.share(of_stated("monitor", of_night), missed(night), night.found.all, of_night);
  marks.share("monitor names wrongly 10 % of those found", wrong(night), night.right.all, 0.10);
  for (std::size_t k = 0; k < 2; ++k) {
    const char* const who = k == 0 ? "recalibrate" : "monitor";
    const Count &quiet = totals.quiet[k].accused, &any = totals.all[k].accused;
    marks.share(fmt::format("{} accuses where nothing changed, 1 %", who), quiet.yes, quiet.all, kFalseAlarm);
    marks.share(fmt::format("{} accuses an innocent at any site, 1 %", who), any.yes, any.all, kFalseAlarm);
  }
  marks.line(fmt::format("RMSE {:.3f} of that of a fresh calibration of both visits, at most 1.05", ratio),
             ratio <= 1.05);
  marks.line(fmt::format("NEES {:.2f} of its degrees of freedom, 0.3 to 3", nees), nees > 0.3 && nees < 3.0);
  marks.line(fmt::format("{} visits without an answer", totals.faults), totals.faults == 0);
  return marks.missed();
}

}  // namespace octant::study

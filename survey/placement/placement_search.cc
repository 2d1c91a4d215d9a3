// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/placement_search.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <nlopt.hpp>

namespace octant::survey {
namespace {

constexpr std::size_t kGridPlaces = 160;
constexpr int kSweeps = 20;           ///< largest number of sweeps of exchanges
constexpr std::size_t kDescents = 5;  ///< runs of NLopt's local algorithm, from the best choices
constexpr int kKicks = 8;             ///< exchanges of a layout found, each with a descent after it
constexpr double kGains = 1e-4;       ///< an exchange has to gain more than this part
constexpr std::size_t kEvaluationsPerNumber = 400;  ///< evaluations by NLopt, for each unknown and algorithm

/// A beacon of a layout with its information.
struct Spot {
  MountPoint point;
  std::shared_ptr<const BeaconLayer> layer;
};
using Spots = std::vector<Spot>;

MountLayout layout_of(const Spots& layout) {
  MountLayout points;
  for (const Spot& s : layout) points.push_back(s.point);
  return points;
}

/// Choices from a grid of places whose layers are made once.
class GridSearch {
 public:
  GridSearch(const SearchSpace& space, LayoutScore& score)
      : space_(space), score_(score), kept_(score.no_beacons()) {
    for (const SurveyBeacon& b : space.kept) kept_.add(score.layer(b));
    for (const MountPoint& p : space.mounts.grid(kGridPlaces)) places_.push_back(spot(p));
  }

  [[nodiscard]] Spots layout(const MountLayout& points) const {
    Spots layout;
    for (const MountPoint& p : points) layout.push_back(spot(p));
    return layout;
  }

  /// One place after the other, each where it helps most.
  [[nodiscard]] Spots greedy(std::size_t count) {
    Spots layout;
    LayoutScore::Sum sum = kept_;
    while (layout.size() < count) {
      layout.push_back(places_.front());
      static_cast<void>(best_for(sum, layout.back(), INFINITY, /*soft=*/true));
      sum.add(*layout.back().layer);
    }
    return layout;
  }

  /// The reverse: starts with a beacon at every few positions, and removes the one whose loss is smallest.
  [[nodiscard]] Spots stingy(std::size_t count) {
    Spots layout;
    const std::size_t every = std::max<std::size_t>(1, places_.size() / std::max<std::size_t>(4 * count, 1));
    for (std::size_t i = 0; i < places_.size(); i += every) layout.push_back(places_[i]);
    LayoutScore::Sum sum = total(layout, layout.size());
    while (layout.size() > count) {
      std::size_t least_missed = 0;
      double least = INFINITY;
      for (std::size_t k = 0; k < layout.size(); ++k) {
        LayoutScore::Sum without = sum;
        without.add(*layout[k].layer, -1);
        ++evaluations_;
        if (const double value = score_.value_with(without, nullptr, /*soft=*/true); value < least)
          least = value, least_missed = k;
      }
      layout.erase(layout.begin() + static_cast<std::ptrdiff_t>(least_missed));
      sum = total(layout, layout.size());  // anew, so that differences leave no rounding
    }
    return layout;
  }

  /// Moves one beacon after another to the position of the grid where it improves the layout most, until none
  /// moves. Returns the value reached.
  double exchange(Spots& layout, bool soft) {
    double value = score_.value_with(total(layout, layout.size()), nullptr, soft);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      const double before = value;
      for (std::size_t k = 0; k < layout.size(); ++k)
        value = best_for(total(layout, k), layout[k], value, soft);
      if (!(value < before * (1 - kGains))) break;
    }
    return value;
  }

  [[nodiscard]] std::size_t evaluations() const { return evaluations_; }

 private:
  [[nodiscard]] Spot spot(const MountPoint& p) const {
    return {p, std::make_shared<BeaconLayer>(score_.layer(space_.mounts.beacon(p)))};
  }

  /// All beacons except one (the size of the layout: all).
  [[nodiscard]] LayoutScore::Sum total(const Spots& layout, std::size_t but) const {
    LayoutScore::Sum sum = kept_;
    for (std::size_t k = 0; k < layout.size(); ++k)
      if (k != but) sum.add(*layout[k].layer);
    return sum;
  }

  /// Best position for one beacon with the others fixed, if it is better than `value`. Returns the value
  /// reached.
  double best_for(const LayoutScore::Sum& others, Spot& spot, double value, bool soft) {
    for (const Spot& place : places_) {
      ++evaluations_;
      const double v = score_.value_with(others, place.layer.get(), soft);
      if (!(v < value * (1 - kGains))) continue;
      value = v;
      spot = place;
    }
    return value;
  }

  const SearchSpace& space_;
  LayoutScore& score_;
  LayoutScore::Sum kept_;
  std::vector<Spot> places_;
  std::size_t evaluations_ = 0;
};

nlopt::algorithm algorithm_of(GlobalAlgorithm a) {
  switch (a) {
    case GlobalAlgorithm::kDirect: return nlopt::GN_DIRECT_L;
    case GlobalAlgorithm::kIsres: return nlopt::GN_ISRES;
    case GlobalAlgorithm::kEsch: return nlopt::GN_ESCH;
    default: return nlopt::GN_CRS2_LM;
  }
}

nlopt::algorithm algorithm_of(LocalAlgorithm a) {
  switch (a) {
    case LocalAlgorithm::kBobyqa: return nlopt::LN_BOBYQA;
    case LocalAlgorithm::kCobyla: return nlopt::LN_COBYLA;
    default: return nlopt::LN_SBPLX;
  }
}

/// NLopt over the mounts themselves: one number for each beacon, two where heights or ceilings leave a
/// choice.
class ContinuousSearch {
 public:
  ContinuousSearch(const SearchSpace& space, LayoutScore& score, const PlacementOptions& options,
                   std::size_t count)
      : space_(space), score_(score), options_(options), count_(count) {}

  /// Best point of a descent from `start`, `start` included.
  /// @param soft  minimises the soft value instead of the goal
  [[nodiscard]] MountLayout run(nlopt::algorithm algorithm, const MountLayout& start, double first_step,
                                bool soft) {
    soft_ = soft;
    const auto n = static_cast<unsigned>(count_ * numbers());
    nlopt::opt opt(algorithm, n);
    opt.set_lower_bounds(0.0);
    opt.set_upper_bounds(1.0);
    opt.set_min_objective(&ContinuousSearch::objective, this);
    most_ = options_.evaluations > 0 ? options_.evaluations : kEvaluationsPerNumber * n;
    opt.set_maxeval(static_cast<int>(most_));
    opt.set_xtol_abs(1e-5);
    opt.set_initial_step(first_step);
    nlopt::srand(static_cast<unsigned long>(options_.seed));
    std::vector<double> x = numbers_of(start);
    least_ = value(x);
    best_ = x;
    asked_ = 0;
    try {
      double last = 0.0;
      opt.optimize(x, last);
    } catch (const nlopt::roundoff_limited&) {  // as far as it goes: the best point is kept here
    } catch (const nlopt::forced_stop&) {
      interrupted_ = true;
    }
    return layout_of(best_);
  }

  [[nodiscard]] double value_of(const MountLayout& points) {
    soft_ = false;
    return value(numbers_of(points));
  }
  [[nodiscard]] std::size_t evaluations() const { return evaluations_; }
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  /// Returns false if the search was cancelled.
  bool report(double fraction) {
    interrupted_ = interrupted_ || (options_.on_progress && !options_.on_progress(fraction));
    return !interrupted_;
  }
  void set_stage(double from, double to) { from_ = from, to_ = to; }

 private:
  [[nodiscard]] std::size_t numbers() const { return space_.mounts.is_wide() ? 2 : 1; }

  [[nodiscard]] std::vector<double> numbers_of(const MountLayout& points) const {
    std::vector<double> x;
    for (const MountPoint& p : points) {
      x.push_back(p.along);
      if (numbers() == 2) x.push_back(p.across);
    }
    return x;
  }
  [[nodiscard]] MountLayout layout_of(const std::vector<double>& x) const {
    MountLayout points;
    for (std::size_t k = 0; k < count_; ++k)
      points.push_back({x[k * numbers()], numbers() == 2 ? x[2 * k + 1] : 0.5});
    return points;
  }

  double value(const std::vector<double>& x) {
    ++evaluations_;
    const std::vector<SurveyBeacon> beacons = space_.beacons_at(layout_of(x));
    return soft_ ? score_.soft_value(beacons) : LayoutScore::value(score_.of(beacons));
  }

  static double objective(const std::vector<double>& x, std::vector<double>&, void* self) {
    auto& search = *static_cast<ContinuousSearch*>(self);
    constexpr std::size_t kAtOnce = 64;
    const double part = std::min(1.0, static_cast<double>(search.asked_) / static_cast<double>(search.most_));
    if (++search.asked_ % kAtOnce == 0 && !search.report(search.from_ + part * (search.to_ - search.from_)))
      throw nlopt::forced_stop();
    const double value = search.value(x);
    if (value < search.least_) {
      search.least_ = value;
      search.best_ = x;
    }
    return value;
  }

  const SearchSpace& space_;
  LayoutScore& score_;
  const PlacementOptions& options_;
  std::size_t count_, evaluations_ = 0, asked_ = 0, most_ = 1;
  double least_ = 0.0, from_ = 0.0, to_ = 1.0;
  std::vector<double> best_;
  bool interrupted_ = false, soft_ = false;
};

/// The whole search, stage by stage.
class LayoutSearch {
 public:
  LayoutSearch(const SearchSpace& space, std::size_t count, LayoutScore& score,
               const PlacementOptions& options)
      : options_(options), grid_(space, score), nlopt_(space, score, options, count), count_(count) {}

  SearchResult run(const std::vector<MountLayout>& starts) {
    choose(starts);
    descend_from_the_best();
    global();
    kick();
    result_.evaluations = grid_.evaluations() + nlopt_.evaluations();
    result_.interrupted = nlopt_.interrupted();
    return std::move(result_);
  }

 private:
  /// Exchanges on the grid, from greedy and stingy choices and from all starts.
  void choose(const std::vector<MountLayout>& starts) {
    std::vector<Spots> layouts = {grid_.greedy(count_), grid_.stingy(count_)};
    result_.layouts.push_back(layout_of(layouts.front()));
    for (const auto& start : starts) {
      keep(start);
      layouts.push_back(grid_.layout(start));
    }
    for (std::size_t i = 0; i < layouts.size() &&
                            nlopt_.report(0.3 * static_cast<double>(i) / static_cast<double>(layouts.size()));
         ++i) {
      static_cast<void>(grid_.exchange(layouts[i], /*soft=*/true));
      keep(layout_of(layouts[i]));
      static_cast<void>(grid_.exchange(layouts[i], /*soft=*/false));
      keep(layout_of(layouts[i]));
    }
  }

  /// Minimises the soft value first, which has gradients far from the solution.
  void descend_from_the_best() {
    if (options_.local == LocalAlgorithm::kNone) return;
    auto ranked = result_.layouts;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < ranked.size(); ++i) order.emplace_back(nlopt_.value_of(ranked[i]), i);
    std::ranges::sort(order);
    const std::size_t most = std::min(kDescents, order.size());
    for (std::size_t i = 0; i < most && !nlopt_.interrupted(); ++i) {
      nlopt_.set_stage(0.3 + 0.3 * static_cast<double>(i) / static_cast<double>(most),
                       0.3 + 0.3 * static_cast<double>(i + 1) / static_cast<double>(most));
      const auto& start = ranked[order[i].second];
      if (i == 0) keep(nlopt_.run(algorithm_of(options_.local), start, 0.02, /*soft=*/false));
      const auto near = nlopt_.run(algorithm_of(options_.local), start, 0.04, /*soft=*/true);
      if (!nlopt_.interrupted()) keep(nlopt_.run(algorithm_of(options_.local), near, 0.02, /*soft=*/false));
    }
  }

  void global() {
    if (options_.global == GlobalAlgorithm::kNone || nlopt_.interrupted()) return;
    nlopt_.set_stage(0.6, 0.85);
    keep(nlopt_.run(algorithm_of(options_.global), best_, 0.1, /*soft=*/false));
  }

  /// Exchanges beacons of the best layout with positions of the grid, with a descent after each exchange,
  /// until none improves it.
  void kick() {
    nlopt_.set_stage(0.85, 1.0);
    for (int i = 0; i < kKicks && !nlopt_.interrupted(); ++i) {
      const double before = best_value_;
      Spots layout = grid_.layout(best_);
      static_cast<void>(grid_.exchange(layout, /*soft=*/false));
      keep(layout_of(layout));
      if (options_.local != LocalAlgorithm::kNone)
        keep(nlopt_.run(algorithm_of(options_.local), layout_of(layout), 0.02, /*soft=*/false));
      if (!(best_value_ < before * (1 - kGains))) return;
    }
  }

  void keep(const MountLayout& layout) {
    result_.layouts.push_back(layout);
    const double value = nlopt_.value_of(layout);
    if (!best_.empty() && !(value < best_value_)) return;
    best_ = layout;
    best_value_ = value;
  }

  const PlacementOptions& options_;
  GridSearch grid_;
  ContinuousSearch nlopt_;
  std::size_t count_;
  SearchResult result_;
  MountLayout best_;
  double best_value_ = 0.0;
};

}  // namespace

std::vector<SurveyBeacon> SearchSpace::beacons_at(const MountLayout& layout) const {
  std::vector<SurveyBeacon> beacons = kept;
  for (const MountPoint& p : layout) beacons.push_back(mounts.beacon(p));
  return beacons;
}

MountLayout greedy_layout(const SearchSpace& space, std::size_t count, LayoutScore& score) {
  return layout_of(GridSearch(space, score).greedy(count));
}

SearchResult search_layout(const SearchSpace& space, std::size_t count, LayoutScore& score,
                           const PlacementOptions& options, const std::vector<MountLayout>& starts) {
  return LayoutSearch(space, count, score, options).run(starts);
}

MountLayout refine_layout(const SearchSpace& space, const MountLayout& start, LayoutScore& score,
                          const PlacementOptions& options, SearchResult& result) {
  ContinuousSearch search(space, score, options, start.size());
  search.set_stage(1.0, 1.0);
  auto layout = search.run(algorithm_of(options.local), start, 0.01, /*soft=*/false);
  result.evaluations += search.evaluations();
  result.interrupted = result.interrupted || search.interrupted();
  return layout;
}

}  // namespace octant::survey

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/placement.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "models/physics/polygon.h"
#include "survey/map/floor_grid.h"
#include "survey/placement/layout_score.h"
#include "survey/placement/placement_search.h"

namespace octant::survey {
namespace {

constexpr int kPhases = 8;  ///< phases of the regular layout
constexpr std::size_t kRandomLayouts = 25;
constexpr int kSharpenings = 3;
constexpr int kRefinements = 6;

/// Cells of about this number over the floor, each in the scene's headings.
Result<PoseList> poses_over(const SurveyModel& model, const Scene& scene, std::size_t cells) {
  const double wanted_m = std::sqrt(std::abs(signed_area_m2(model.floor_m)) /
                                    static_cast<double>(std::max<std::size_t>(cells, 1)));
  const auto grid = make_floor_grid(model, scene, std::max(wanted_m, scene.cell_m));
  if (!grid) return fail(grid.error());
  PoseList poses;
  const int headings = model.unknowns.rotation > 0 ? std::max(1, scene.headings) : 1;
  for (int h = 0; h < headings; ++h) {
    const PoseList more = poses_of(*grid, 2 * M_PI * h / headings, model.vehicle_z_m);
    for (std::size_t i = 0; i < more.size(); ++i)
      poses.add(more.x_m[i], more.y_m[i], more.z_m[i], more.heading_rad[i]);
  }
  return poses;
}

bool better(const LayoutFigures& a, const LayoutFigures& b) {
  return LayoutScore::value(a) < LayoutScore::value(b);
}

LayoutFigures best_regular(const SearchSpace& space, std::size_t count, LayoutScore& score) {
  LayoutFigures best;
  for (int phase = 0; phase < kPhases; ++phase) {
    const LayoutFigures f =
        score.of(space.beacons_at(space.mounts.regular(count, static_cast<double>(phase) / kPhases)));
    if (phase == 0 || better(f, best)) best = f;
  }
  return best;
}

LayoutFigures median_random(const SearchSpace& space, std::size_t count, std::uint64_t seed,
                            LayoutScore& score) {
  Random draws(seed, 1);
  std::vector<LayoutFigures> all;
  for (std::size_t i = 0; i < kRandomLayouts; ++i)
    all.push_back(score.of(space.beacons_at(space.mounts.random(count, draws))));
  std::ranges::nth_element(all, all.begin() + kRandomLayouts / 2, better);
  return all[kRandomLayouts / 2];
}

/// A name that is not in use.
std::string next_name(const SurveyModel& model, std::size_t& number) {
  for (;; ++number) {
    std::string name = fmt::format("B{}", number);
    if (std::ranges::none_of(model.beacons, [&](const SurveyBeacon& b) { return b.name == name; })) {
      ++number;
      return name;
    }
  }
}

/// Data shared by all searches of one scene: the mounts, and the poses of the search and of the stated
/// figures.
struct SearchGround {
  SearchSpace space;
  PoseList coarse, fine;
};

Result<SearchGround> search_ground_of(const SurveyModel& model, const Scene& scene,
                                      const PlacementOptions& options) {
  auto mounts = MountSpace::of(scene);
  if (!mounts) return fail(mounts.error());
  auto coarse = poses_over(model, scene, options.cells), fine = poses_over(model, scene, options.final_cells);
  if (!coarse) return fail(coarse.error());
  if (!fine) return fail(fine.error());
  SearchSpace space{std::move(*mounts), options.keep ? model.beacons : std::vector<SurveyBeacon>{}};
  return SearchGround{std::move(space), std::move(*coarse), std::move(*fine)};
}

Result<void> check_number(const SurveyModel& model, std::size_t beacons, const PlacementOptions& options) {
  if (options.keep && beacons <= model.beacons.size())
    return fail(
        {.code = Errc::kUsage,
         .found = fmt::format("{} beacons are asked for and {} are kept", beacons, model.beacons.size()),
         .expected = "more beacons than are kept"});
  if (beacons == 0)
    return fail({.code = Errc::kUsage, .found = "no beacon is asked for", .expected = "a number above zero"});
  return {};
}

/// Poses with the largest errors, which the search is to look at too.
PoseList worst_poses(const LayoutScore& score, std::size_t count) {
  const std::vector<double>& errors = score.errors_m();
  std::vector<std::size_t> order(errors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  count = std::min(count, order.size());
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count),
                            [&](std::size_t a, std::size_t b) { return errors[a] > errors[b]; });
  PoseList poses;
  const PoseList& all = score.poses();
  for (std::size_t k = 0; k < count; ++k)
    poses.add(all.x_m[order[k]], all.y_m[order[k]], all.z_m[order[k]], all.heading_rad[order[k]]);
  return poses;
}

std::vector<MountLayout> starts_of(const MountSpace& mounts, std::size_t count,
                                   const PlacementOptions& options) {
  std::vector<MountLayout> starts;
  const int phases = std::min(kPhases, options.restarts + 2);
  for (int phase = 0; phase < kPhases; phase += kPhases / phases)
    starts.push_back(mounts.regular(count, static_cast<double>(phase) / kPhases));
  Random draws(options.seed, 2);
  for (int i = 0; i < options.restarts; ++i) starts.push_back(mounts.random(count, draws));
  return starts;
}

/// Before the main search, adds the cells that promising layouts of a quick search leave worst, between the
/// cells that it evaluated.
void sharpen(const SearchSpace& space, std::size_t count, LayoutScore& coarse, LayoutScore& fine,
             const PlacementOptions& options) {
  if (options.goal != PlacementGoal::kWorst) return;
  PlacementOptions quick = options;
  quick.global = GlobalAlgorithm::kNone;
  quick.local = LocalAlgorithm::kNone;
  quick.on_progress = nullptr;
  for (int round = 0; round < kSharpenings; ++round) {
    SearchResult found = search_layout(space, count, coarse, quick, {});
    for (auto layout = found.layouts.rbegin(); layout != found.layouts.rend(); ++layout) {
      static_cast<void>(fine.of(space.beacons_at(*layout)));
      coarse.add_poses(worst_poses(fine, std::max<std::size_t>(8, fine.poses().size() / 400)));
    }
  }
}

/// The best of the search's layouts over the fine cells. Where the worst cell counts, cells that the search
/// did not look at and that turn out worst join it, and the best layout is refined, a few times.
MountLayout best_layout(const SearchSpace& space, SearchResult& found, LayoutScore& coarse, LayoutScore& fine,
                        const PlacementOptions& options, LayoutFigures& figures) {
  const auto look = [&](const MountLayout& layout) { return fine.of(space.beacons_at(layout)); };
  MountLayout best = found.layouts.front();
  figures = look(best);
  const auto take = [&](const MountLayout& layout) {
    const LayoutFigures f = look(layout);
    if (!better(f, figures)) return;
    figures = f;
    best = layout;
  };
  for (const auto& layout : found.layouts) take(layout);
  if (options.goal != PlacementGoal::kWorst || options.local == LocalAlgorithm::kNone) return best;
  MountLayout refined = best;
  for (int round = 0; round < kRefinements && !found.interrupted; ++round) {
    static_cast<void>(look(refined));
    coarse.add_poses(worst_poses(fine, std::max<std::size_t>(8, coarse.poses().size() / 20)));
    refined = refine_layout(space, refined, coarse, options, found);
    take(refined);
  }
  return best;
}

Placement place(const SurveyModel& model, const SearchGround& ground, std::size_t beacons,
                const PlacementOptions& options) {
  const SearchSpace& space = ground.space;
  const std::size_t count = beacons - space.kept.size();
  LayoutScore coarse(model, ground.coarse, options), fine(model, ground.fine, options);
  sharpen(space, count, coarse, fine, options);
  SearchResult found = search_layout(space, count, coarse, options, starts_of(space.mounts, count, options));
  Placement placement;
  placement.cells = fine.poses().size();
  placement.regular = best_regular(space, count, fine);
  placement.random = median_random(space, count, options.seed, fine);
  placement.greedy = fine.of(space.beacons_at(found.layouts.front()));
  const MountLayout best = best_layout(space, found, coarse, fine, options, placement.figures);
  placement.evaluations = found.evaluations;
  placement.interrupted = found.interrupted;
  for (const SurveyBeacon& b : space.kept) placement.beacons.push_back({b, ""});
  std::size_t number = 0;
  for (const MountPoint& p : best) {
    placement.beacons.push_back({space.mounts.beacon(p), space.mounts.mount_name(p)});
    placement.beacons.back().beacon.name =
        options.keep ? next_name(model, number) : fmt::format("B{}", number++);
  }
  return placement;
}

}  // namespace

Result<Placement> place_beacons(const SurveyModel& model, const Scene& scene, std::size_t beacons,
                                const PlacementOptions& options) {
  if (const auto sound = check_number(model, beacons, options); !sound) return fail(sound.error());
  const auto ground = search_ground_of(model, scene, options);
  if (!ground) return fail(ground.error());
  return place(model, *ground, beacons, options);
}

Result<SmallestPlacement> smallest_placement(const SurveyModel& model, const Scene& scene, double tolerance_m,
                                             std::size_t most_beacons, const PlacementOptions& options) {
  const auto ground = search_ground_of(model, scene, options);
  if (!ground) return fail(ground.error());
  const SearchSpace& space = ground->space;
  const std::size_t kept = space.kept.size();
  if (const auto sound = check_number(model, std::max(most_beacons, std::size_t{1}), options); !sound)
    return fail(sound.error());
  // A greedy choice determines a sufficient number. The number is then decreased until a search finds no
  // sufficient layout.
  LayoutScore fine(model, ground->fine, options);
  LayoutScore coarse(model, ground->coarse, options);
  const MountLayout greedy = greedy_layout(space, most_beacons - kept, coarse);
  std::size_t enough = most_beacons;
  for (std::size_t n = 1; n <= greedy.size(); ++n) {
    const MountLayout first(greedy.begin(), greedy.begin() + static_cast<std::ptrdiff_t>(n));
    if (fine.of(space.beacons_at(first)).objective_m > tolerance_m) continue;
    enough = kept + n;
    break;
  }
  SmallestPlacement smallest;
  for (std::size_t n = enough; n > kept; --n) {
    Placement placement = place(model, *ground, n, options);
    smallest.tried.emplace_back(n, placement.figures);
    const bool within = placement.figures.objective_m <= tolerance_m;
    if (within || !smallest.reached) smallest.placement = std::move(placement);
    smallest.reached = smallest.reached || within;
    if (!within || smallest.placement.interrupted) break;
  }
  return smallest;
}

Result<LayoutFigures> layout_figures(const SurveyModel& model, const Scene& scene,
                                     const PlacementOptions& options) {
  auto poses = poses_over(model, scene, options.final_cells);
  if (!poses) return fail(poses.error());
  return LayoutScore(model, std::move(*poses), options).of(model.beacons);
}

}  // namespace octant::survey

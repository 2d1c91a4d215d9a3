// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/approach.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calib/adjust/reject.h"
#include "calib/errors/whiteness.h"
#include "calib/problem/flips.h"
#include "calib/start/held_states.h"
#include "calib/start/label_check.h"
#include "calib/start/mirror_images.h"
#include "calib/start/place_search.h"
#include "calib/start/refusals.h"
#include "calib/start/start.h"

namespace octant::calib {
namespace {

constexpr int kMaxStages = 12;
constexpr double kLeastPlaced = 0.25;  ///< fraction of the arrivals, if all beacons are fixed
/// Residual, in addition to the robust scale, above which an epoch is searched again.
constexpr double kSuspectSigmas = 2.0;
/// Errors of beacons at a stage of the graduated adjustment, as a fraction of its scale.
constexpr double kUncertaintyOfScale = 0.5;
/// Robust scale in sigmas above which the headings of epochs are constrained to the result of the search.
constexpr double kRoughScale = 10.0;
/// Repeated searches, by the errors of beacons in sigmas. An improvement below two per cent does not count.
constexpr std::array<double, 5> kSearchScales = {0.0, 20.0, 8.0, 3.0, 0.0};
constexpr double kMuchBetter = 0.98;
/// A stated place is believed unless another one is better by this, half a square of four sigmas.
constexpr double kAsGoodAsStated = 8.0;
/// States are searched again once the robust scale is down to this, and once more at its end.
constexpr double kSearchAgainScale = 30.0;
/// Positions within this fraction of the typical range from one line may be their mirror images.
constexpr double kNearLine = 0.1;
constexpr double kClearImage = 0.75;
/// From one stage of the graduated adjustment to the next.
constexpr double kFiner = 5.0;
/// Remaining fraction of the start's uncertainty in the residuals after fixed paths, and then of the beacons.
constexpr double kShareOfHeld = 1.0 / 3, kLeftOfUncertainty = 0.5;
/// Sigmas of the constraints of a path's states, of position [m] and attitude [rad], one after the other:
/// beacons first, then both together, before the states are free.
constexpr double kHeldTo[] = {0.001, 0.01, 0.1};

class Approacher {
 public:
  Approacher(const Problem& problem, const SolveOptions& options, ProgressMonitor& monitor)
      : problem_(problem), options_(options), monitor_(monitor) {}

  Approach run(bool search_again) {
    out_.ok = approach(search_again);
    return std::move(out_);
  }

 private:
  bool approach(bool search_again) {
    if (!monitor_.report("initial values", 0.02)) return stop(interrupted_solution());
    if (const auto missing = missing_scale(problem_)) return stop(refused(*missing));
    start_ = initial_values(problem_, options_.threads);
    set_start();
    if (!has_poses(0.0)) return false;
    // Clear mirror images are handled before the labels are compared; others after all epochs have been
    // searched again.
    if (!graduated() || !compare_image_in_wall(kClearImage) || !mend_labels() ||
        (search_again && (!search_and_adjust() || !compare_image_in_wall(1.0) || !look_behind_obstacles() ||
                          !compare_images())))
      return stop(interrupted_solution());
    return has_poses(kLeastPlaced);
  }
  bool has_poses(double least_share) {
    auto why_not = without_poses(problem_, out_, least_share);
    return why_not ? stop(std::move(*why_not)) : true;
  }
  bool stop(Solution why) {
    out_.why_not = std::move(why);
    return false;
  }

  void set_start() {
    estimate_.beacon_usable = start_.beacon_found;
    estimate_.beacon_mirrored.assign(estimate_.beacon_usable.size(), false);
    out_.trajectories = std::move(start_.trajectories);
    estimate_.layout = make_layout(problem_, start_.state, estimate_.beacon_usable);
    estimate_.layout.dense_limit = options_.dense_limit;
    estimate_.x = estimate_.layout.vector_of(start_.state);
    readmit_all(out_.trajectories, estimate_.beacon_usable);
    out_.start_headings_rad = epoch_headings_rad(out_.trajectories);
    out_.warnings = start_.warnings;
  }

  [[nodiscard]] double sigma_m() const { return estimate_.sigma_m(problem_); }

  bool adjust_with(double scale, double function_tolerance) {
    estimate_.last = adjust(problem_, estimate_.layout, out_.trajectories, estimate_.x,
                            monitor_.adjust_options(scale, function_tolerance));
    return !estimate_.last.interrupted;
  }

  /// Graduated robustness: from the uncertainty of the start down to the noise, placing states again in
  /// between.
  bool graduated() {
    double scale = std::max(start_.uncertainty_m / sigma_m(), kCauchyScale);
    bool searched_again = false;
    if (scale > kRoughScale && std::ranges::any_of(out_.trajectories, can_be_held)) {
      if (!fitted_to_paths(scale)) return false;
      scale = std::max(scale / kFiner, kCauchyScale);
    }
    for (int stage = 0;; ++stage) {
      if (!monitor_.report(fmt::format("adjustment, robust scale {:.3g} sigma", scale),
                           std::min(0.6, 0.1 + 0.1 * stage)))
        return false;
      const bool last = scale <= kCauchyScale;
      const HeldStates held = HeldStates::headings(scale > kRoughScale ? &out_.trajectories : nullptr);
      if (!adjust_with(scale, last ? 1e-10 : 1e-4)) return false;
      const bool lifted = keep_above();
      if (last && (!lifted || stage > kMaxStages)) return true;
      scale = std::max(scale / kFiner, kCauchyScale);
      if (scale <= kSearchAgainScale && !searched_again) {
        place_again(scale, kUncertaintyOfScale * scale);
        searched_again = true;
      }
    }
  }

  /// Drives in space: the shared parameters are fitted to the paths of the search, these are computed again
  /// among better known beacons, and both are adjusted together.
  bool fitted_to_paths(double scale) {
    const auto fit = [&](double held_to) {
      const HeldStates held = HeldStates::paths(out_.trajectories, held_to, held_to);
      return adjust_with(kShareOfHeld * scale, 1e-4);
    };
    if (!monitor_.report("adjustment to the paths as found", 0.1) || !fit(0.01)) return false;
    place_again(scale, kLeftOfUncertainty * scale);
    return std::all_of(std::begin(kHeldTo), std::end(kHeldTo), fit);
  }

  /// Moves a beacon of unknown height that came below the plane of the receivers back above it.
  bool keep_above() {
    if (problem_.site.motion != Motion::kPlanar) return false;
    const SharedState state = estimate_.state();
    double plane_z_m = 0.0;
    for (const Eigen::Vector3d& o : state.receiver_p_vehicle_m)
      plane_z_m += o.z() / static_cast<double>(state.receiver_p_vehicle_m.size());
    bool lifted = false;
    for (const auto& columns : estimate_.layout.beacon) {
      const int z = columns[2];
      if (z < 0 || std::isfinite(estimate_.layout.parameter(z).prior_sigma) || estimate_.x[z] >= plane_z_m)
        continue;
      estimate_.x[z] = 2 * plane_z_m - estimate_.x[z];
      lifted = true;
    }
    return lifted;
  }

  /// A solution on the way, to which a trial that is no better returns.
  [[nodiscard]] AdjustedLog checkpoint() const { return out_; }
  void restore(AdjustedLog checkpoint) { static_cast<AdjustedLog&>(out_) = std::move(checkpoint); }

  [[nodiscard]] ConsensusCost consensus(double early_more = 0.0) const {
    return consensus_cost_of(problem_, out_, options_.rejection_sigmas, {}, early_more);
  }

  /// Along a wall, a site may be its mirror image in the wall if only the stated sigmas across it distinguish
  /// the sides. The image is adjusted too, and used if it costs less than this fraction.
  bool compare_image_in_wall(double share) {
    const double off_line_m = kNearLine * problem_.typical_range_m;
    const AdjustedLog here = checkpoint();
    const double cost = consensus().total();
    if (!reflect_site(problem_, out_, off_line_m)) return true;
    if (!monitor_.report("the image in the line of what is known", 0.61)) return false;
    if (!adjust_from(off_line_m)) return false;
    if (consensus().total() >= share * cost) restore(here);
    return true;
  }

  /// Exchanged or misplaced beacons, after the arrivals have determined their positions.
  bool mend_labels() {
    const AdjustedLog before = checkpoint();
    LabelCheck check = check_labels(problem_, estimate_.layout, estimate_.x);
    if (check.mended) {
      if (!monitor_.report("adjustment with mended positions", 0.62)) return false;
      place_again(kCauchyScale, 0.0);
      if (!adjust_with(kCauchyScale, 1e-10)) return false;
    }
    if (!check.disregarded.empty() && !believe_stated(before, check)) return false;
    out_.warnings.insert(out_.warnings.end(), check.warnings.begin(), check.warnings.end());
    return true;
  }

  /// A beacon may deviate from the site file because a robust start converged elsewhere. All such beacons are
  /// therefore also adjusted from their given positions, at first together, then one by one. The given
  /// position is ignored only if the result is clearly worse.
  bool believe_stated(const AdjustedLog& before, LabelCheck& check) {
    const auto better_than = [this](const ConsensusCost& other) {
      const SharedState state = estimate_.state();
      const double noise = agreeing_sigma(out_.trajectories, state);
      const double variance =
          noise * noise * whiteness_of(out_.trajectories, state, options_.threads).variance_factor();
      return consensus().total() < other.total() + kAsGoodAsStated * std::max(1.0, variance);
    };
    std::vector<std::size_t> trusted;
    const std::vector<std::size_t> doubted = check.disregarded;
    // Most places in doubt have one common cause: all are believed, and the diagnosis examines the misfit.
    const bool have_common_cause = are_most_places(doubted.size());
    const std::size_t trials = doubted.size() == 1 || have_common_cause ? 1 : 1 + doubted.size();
    AdjustedLog best = checkpoint();
    ConsensusCost cost = consensus();
    for (std::size_t trial = 0; trial < trials && trusted.size() < doubted.size(); ++trial) {
      std::vector<std::size_t> wanted = trusted;
      if (trial == 0) {
        wanted = doubted;
        restore(before);
      } else {
        wanted.push_back(doubted[trial - 1]);
        estimate_.layout = before.estimate.layout;
      }
      LabelCheck again = check_labels(problem_, estimate_.layout, before.estimate.x, wanted);
      if (!adjust_from_stated(wanted)) return false;
      if (have_common_cause || better_than(cost)) {
        trusted = wanted;
        check = std::move(again);
        best = checkpoint();
        cost = consensus();
      } else {
        restore(best);
      }
    }
    return true;
  }

  [[nodiscard]] bool are_most_places(std::size_t count) const {
    constexpr std::size_t kSeveral = 3;
    const auto places = std::ranges::count_if(problem_.site.beacons,
                                              [](const SiteBeacon& b) { return b.place_m().has_value(); });
    return count >= kSeveral && 2 * count > static_cast<std::size_t>(places);
  }

  /// With beacons back at their stated places.
  bool adjust_from_stated(const std::vector<std::size_t>& beacons) {
    if (!monitor_.report("adjustment from stated positions", 0.63)) return false;
    double off_m = 0.0;
    for (const std::size_t b : beacons)
      for (std::size_t i = 0; i < 3; ++i) {
        const int column = estimate_.layout.beacon[b][i];
        if (column < 0 || !problem_.site.beacons[b].position_m[i]) continue;
        estimate_.x[column] = *problem_.site.beacons[b].position_m[i];
        const double prior_m = estimate_.layout.parameter(column).prior_sigma;
        if (std::isfinite(prior_m)) off_m = std::max(off_m, prior_m);
      }
    return adjust_from(off_m);
  }

  /// Places states again among beacons with errors of this size, and adjusts from there.
  bool adjust_from(double off_m) {
    place_again(kCauchyScale, off_m / sigma_m());
    double scale = std::max(off_m / sigma_m(), kCauchyScale);
    while (scale > kCauchyScale) {
      if (!adjust_with(scale, 1e-4)) return false;
      scale /= kFiner;
    }
    place_again(kCauchyScale, 0.0);
    return adjust_with(kCauchyScale, 1e-10);
  }

  /// Beacons of whose arrivals many do not fit are adjusted from the place that more of them agree on as
  /// well, where there is one, and the larger consensus is kept.
  bool look_behind_obstacles() {
    for (const std::size_t b : beacons_that_do_not_fit(out_, options_.rejection_sigmas)) {
      const auto moved = with_beacon_of_larger_consensus(problem_, out_, b, options_.rejection_sigmas);
      if (!moved) continue;
      if (!monitor_.report(fmt::format("another place of beacon {}", problem_.site.beacons[b].name), 0.66))
        return false;
      const AdjustedLog here = checkpoint();
      const double cost = consensus(kEarlyIsRarer).total();
      estimate_.x = *moved;
      // If as many arrivals are late as direct, Cauchy's loss would converge between both.
      reject_outliers(out_.trajectories, estimate_.state(), options_.rejection_sigmas, options_.threads);
      if (!adjust_with(kCauchyScale, 1e-10)) return false;
      readmit_all(out_.trajectories, estimate_.beacon_usable);
      if (!(consensus(kEarlyIsRarer).total() < cost)) restore(here);
    }
    return true;
  }

  /// Mirror images of beacons, or of the whole site, that the ranges do not exclude: the image is adjusted
  /// too, and the better one by all observations is used. If both are equally good, a beacon is undetermined.
  bool compare_images() {
    if (!monitor_.report("mirror images", 0.67)) return false;
    // Repeated if one moved to the other side, because others were compared with its earlier position.
    bool is_turned = true;
    for (int round = 0; round < 2 && is_turned; ++round) {
      is_turned = false;
      for (std::size_t b = 0; b < estimate_.beacon_usable.size(); ++b)
        if (!compare_image_of(b, is_turned)) return false;
    }
    return compare_site_image();
  }

  /// @param is_turned  set where the image in height was kept
  bool compare_image_of(std::size_t b, bool& is_turned) {
    const std::array<int, 3>& columns = estimate_.layout.beacon[b];
    if (!estimate_.beacon_usable[b] || *std::ranges::max_element(columns) < 0) return true;
    estimate_.beacon_mirrored[b] = false;
    auto image = mirror_image(problem_, estimate_.state(), out_.trajectories, b, 3 * sigma_m());
    if (!image) image = image_across_receivers(problem_, estimate_, b);
    if (!image) return true;
    const AdjustedLog here = checkpoint();
    estimate_.layout.set_place(b, *image, estimate_.x);
    if (!adjust_with(kCauchyScale, 1e-8)) return false;
    const AdjustedLog there = checkpoint();
    const Eigen::Vector3d p_here_m = here.estimate.state().beacon_p_map_m[b],
                          p_there_m = there.estimate.state().beacon_p_map_m[b];
    const bool is_height = is_across_receivers(problem_, p_here_m, p_there_m);
    const Preference preferred =
        (is_height ? prefer_height : prefer_by_all)(problem_, here, there, options_.rejection_sigmas);
    // Bearings may have led it back to where it was: that is no second place.
    const bool is_one_place = (p_there_m - p_here_m).norm() <= tolerance_m(problem_),
               is_open = preferred == Preference::kNeither && !is_one_place,
               is_below = is_under_floor(p_here_m), is_image_below = is_under_floor(p_there_m),
               is_kept = preferred == Preference::kSecond || (is_open && is_below && !is_image_below);
    if (!is_kept) restore(here);
    is_turned = is_turned || (is_kept && is_height && !is_one_place);
    estimate_.beacon_mirrored[b] = is_open && is_below == is_image_below;
    return true;
  }

  bool compare_site_image() {
    const AdjustedLog here = checkpoint();
    if (!reflect_site(problem_, out_) && !reflect_beacons(problem_, out_, sigma_m())) return true;
    if (!adjust_with(kCauchyScale, 1e-8)) return false;
    const Eigen::VectorXd image = estimate_.x;  // other observations may have led it back
    const Preference preferred = prefer_by_all(problem_, here, out_, options_.rejection_sigmas);
    if (preferred != Preference::kSecond) restore(here);
    if (preferred != Preference::kNeither) return true;
    for (std::size_t b = 0; b < estimate_.beacon_usable.size(); ++b)
      for (const int column : estimate_.layout.beacon[b])
        if (column >= 0 && std::abs(image[column] - here.estimate.x[column]) > tolerance_m(problem_))
          estimate_.beacon_mirrored[b] = true;
    return true;
  }

  /// States that were placed wrongly while the beacons had errors, which may still be this number of sigmas.
  void place_again(double scale, double uncertainty_sigmas) {
    const EpochFixModel model = search_model(problem_, estimate_.state(), estimate_.beacon_usable);
    for (Trajectory& t : out_.trajectories)
      place_states(t, model, uncertainty_sigmas * sigma_m(), true, kSuspectSigmas + scale, options_.threads);
    readmit_all(out_.trajectories, estimate_.beacon_usable);
  }

  /// Beacons and states hold each other in wrong places: a few flipped headings keep the beacons off, and
  /// those keep the headings. So the search is repeated with less and less trust in the beacons withdrawn,
  /// and the largest consensus is kept.
  bool search_and_adjust() {
    double best = consensus().total();
    std::size_t failures = 0;
    for (const double uncertainty : kSearchScales) {
      const AdjustedLog before = checkpoint();
      if (!monitor_.report(fmt::format("search again, beacons trusted to {:.3g} sigma", uncertainty), 0.65))
        return false;
      place_again(kCauchyScale, uncertainty);
      for (const double scale : {std::max(uncertainty, kCauchyScale), kCauchyScale})
        if (!adjust_with(scale, scale > kCauchyScale ? 1e-4 : 1e-10)) return false;
      const double cost = consensus().total();
      const bool better = cost < best, much_better = cost < kMuchBetter * best;
      if (better) best = cost;
      if (!better) restore(before);
      if (!much_better && ++failures >= 2) break;
    }
    return true;
  }

  const Problem& problem_;
  const SolveOptions& options_;
  ProgressMonitor& monitor_;
  Start start_;
  Approach out_;
  Estimate& estimate_ = out_.estimate;
};

}  // namespace

Approach approach(const Problem& problem, const SolveOptions& options, ProgressMonitor& monitor,
                  bool search_again) {
  return Approacher(problem, options, monitor).run(search_again);
}

}  // namespace octant::calib

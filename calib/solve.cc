// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/adjust.h"
#include "calib/calibrate.h"
#include "calib/datum.h"
#include "calib/flips.h"
#include "calib/gates.h"
#include "calib/label_check.h"
#include "calib/long_log.h"
#include "calib/observability.h"
#include "calib/reject.h"
#include "calib/reliability.h"
#include "calib/start.h"
#include "calib/statistics.h"
#include "calib/whiteness.h"

namespace octant::calib {

const char* to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged: return "ok";
    case SolveStatus::kNotConverged: return "not_converged";
    case SolveStatus::kUndetermined: return "undetermined";
    case SolveStatus::kInterrupted: return "interrupted";
  }
  return "not_converged";
}

namespace {

constexpr int kRejectionRounds = 12;
constexpr int kMaxStages = 12;
constexpr int kNoiseRounds = 3;
constexpr double kNoiseMatters = 0.02;
/// An epoch with an arrival this far off (beside the robust scale) is searched again.
constexpr double kSuspectSigmas = 2.0;
/// Beacons at a stage of the graduated adjustment are off by about this share of its scale.
constexpr double kSlackOfScale = 0.5;
/// While the robust scale is beyond so many sigmas the headings of epochs are held near where the search found them.
constexpr double kRoughScale = 10.0;
/// Repeated searches, in sigmas by which beacons may be off; an improvement below two per cent counts as none.
constexpr std::array<double, 5> kSearchSlacks = {0.0, 20.0, 8.0, 3.0, 0.0};
constexpr double kMuchBetter = 0.98;
/// States are searched again once the robust scale is down to this, and once more at its end.
constexpr double kSearchAgainScale = 30.0;

/// The course of one calibration, stage by stage.
class Calibrator {
 public:
  /// @param own_trajectories  the problem's, if they may be taken
  Calibrator(const Problem& problem, const SolveOptions& options, std::vector<Trajectory>* own_trajectories = nullptr)
      : problem_(problem), options_(options), own_trajectories_(own_trajectories), began_(Clock::now()) {}

  Solution run() {
    if (!approach_by_part() && !approach()) return std::move(solution_);
    if (!settle_noise()) return interrupted();
    conclude();
    return std::move(solution_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// From nothing to shared parameters and states that the largest consensus of arrivals agrees on; false: solution_ says why not.
  bool approach() {
    if (!report("initial values", 0.02)) return stop(interrupted());
    if (const auto missing = missing_scale(problem_)) return stop(refuse(*missing));
    start_ = initial_values(problem_, options_.threads);
    take_start();
    if (!placed_any_) return stop(unplaced());
    if (!graduated() || !mend_labels() || !search_and_adjust()) return stop(interrupted());
    return true;
  }

  /// The same for a long log by way of an evenly spread part of it: the shared parameters then are good to a fraction of the
  /// noise, and each state follows from them alone.
  bool approach_by_part() {
    if (!is_long(problem_)) return false;
    const Result<Problem> part = part_of(problem_, options_.threads);
    if (!part) return false;
    Calibrator of_part(*part, options_);
    if (!of_part.approach()) return false;
    if (!report("states of the whole log", 0.68)) return false;
    start_.beacon_mirrored = of_part.start_.beacon_mirrored;
    usable_ = of_part.usable_;
    layout_ = of_part.layout_;
    x_ = of_part.x_;
    last_ = of_part.last_;
    solution_.warnings = problem_.warnings;
    solution_.warnings.insert(solution_.warnings.end(), of_part.solution_.warnings.begin() + static_cast<std::ptrdiff_t>(part->warnings.size()),
                              of_part.solution_.warnings.end());
    solution_.iterations = of_part.solution_.iterations;
    if (own_trajectories_ != nullptr) {
      trajectories_ = std::move(*own_trajectories_);
    } else {
      trajectories_ = problem_.trajectories;
    }
    const SharedState state = layout_.state_of(x_);
    const double noise = std::max(1.0, agreeing_sigma(of_part.trajectories_, of_part.layout_.state_of(of_part.x_)));
    place_all_stops(problem_, layout_, state, usable_, options_.rejection_sigmas * noise, options_.workers(), trajectories_);
    start_headings_rad_ = epoch_headings_rad(trajectories_);
    return true;
  }

  bool stop(Solution why) {
    solution_ = std::move(why);
    return false;
  }

  bool report(const std::string& stage, double fraction) {
    stage_ = stage;
    fraction_ = fraction;
    return !options_.on_progress || options_.on_progress({stage, 0, 0.0, fraction});
  }

  Solution interrupted() {
    solution_.status = SolveStatus::kInterrupted;
    solution_.message = "interrupted";
    return std::move(solution_);
  }

  Solution refuse(WeakDirection direction) {
    solution_.status = SolveStatus::kUndetermined;
    solution_.message = fmt::format("the data do not determine {}; nothing is exported. To settle it: {}", direction.description, direction.remedy);
    solution_.undetermined = direction.parameters;
    solution_.weak.push_back(std::move(direction));
    finish();
    return std::move(solution_);
  }

  Solution unplaced() {
    WeakDirection direction;
    std::vector<std::string> names;
    for (std::size_t b = 0; b < usable_.size(); ++b) {
      if (usable_[b]) continue;
      direction.parameters.push_back("beacon/" + problem_.site.beacons[b].name);
      names.push_back(problem_.site.beacons[b].name);
    }
    if (names.empty()) {
      // All beacons are known and still no pose came of them: too few are heard together.
      for (const SiteBeacon& beacon : problem_.site.beacons) {
        direction.parameters.push_back("beacon/" + beacon.name);
        names.push_back(beacon.name);
      }
      direction.description = fmt::format("any pose of the vehicle from beacons {}: no epoch hears enough of them at once", fmt::join(names, ", "));
    } else {
      direction.description = fmt::format("any pose of the vehicle, and with it the positions of beacons {}", fmt::join(names, ", "));
    }
    direction.remedy = "give approximate positions of three beacons that do not stand in line with the path, or measured poses of the vehicle";
    direction.blocking = true;
    return refuse(std::move(direction));
  }

  void take_start() {
    usable_ = start_.beacon_found;
    trajectories_ = std::move(start_.trajectories);
    std::vector<bool> held(usable_.size());
    for (std::size_t b = 0; b < usable_.size(); ++b) held[b] = !usable_[b];
    layout_ = make_layout(problem_, start_.state, held);
    layout_.dense_limit = options_.dense_limit;
    x_ = layout_.vector_of(start_.state);
    readmit_all(trajectories_, usable_);
    start_headings_rad_ = epoch_headings_rad(trajectories_);
    for (const Trajectory& t : trajectories_)
      for (const Segment& s : t.segments) placed_any_ = placed_any_ || t.nodes[s.first_node].placed;
    solution_.warnings = problem_.warnings;
    solution_.warnings.insert(solution_.warnings.end(), start_.warnings.begin(), start_.warnings.end());
  }

  [[nodiscard]] double sigma_m() const { return problem_.site.noise.tof_sigma_s * noise_factor_ * layout_.nominal_speed_mps; }

  bool adjust_with(double scale, double function_tolerance) {
    AdjustOptions options;
    options.loss = {scale, scale};
    options.max_iterations = options_.max_iterations;
    options.workers = options_.workers();
    options.function_tolerance = function_tolerance;
    options.on_iteration = [this](int iteration, double cost) {
      ++solution_.iterations;
      return !options_.on_progress || options_.on_progress({stage_, iteration, cost, fraction_});
    };
    last_ = adjust(problem_, layout_, trajectories_, x_, options);
    return !last_.interrupted;
  }

  /// Graduated robustness: from the slack of the start down to the noise, placing states anew on the way.
  bool graduated() {
    double scale = std::max(start_.slack_m / sigma_m(), kCauchyScale);
    bool searched_again = false;
    for (int stage = 0;; ++stage) {
      if (!report(fmt::format("adjustment, robust scale {:.3g} sigma", scale), std::min(0.6, 0.1 + 0.1 * stage))) return false;
      const bool last = scale <= kCauchyScale;
      const HeldHeadings held(scale > kRoughScale ? &trajectories_ : nullptr);
      if (!adjust_with(scale, last ? 1e-10 : 1e-4)) return false;
      const bool lifted = keep_above();
      if (last && (!lifted || stage > kMaxStages)) return true;
      scale = std::max(scale / 5, kCauchyScale);
      if (scale <= kSearchAgainScale && !searched_again) {
        place_again(scale, kSlackOfScale * scale);
        searched_again = true;
      }
    }
  }

  /// Receivers in one plane cannot tell above from below: a beacon of unknown height that slipped below is put back above.
  bool keep_above() {
    if (problem_.site.motion != Motion::kPlanar) return false;
    const SharedState state = layout_.state_of(x_);
    double plane_z_m = 0.0;
    for (const Eigen::Vector3d& o : state.receiver_p_vehicle_m) plane_z_m += o.z() / static_cast<double>(state.receiver_p_vehicle_m.size());
    bool lifted = false;
    for (const auto& columns : layout_.beacon) {
      const int z = columns[2];
      if (z < 0 || std::isfinite(layout_.parameters[static_cast<std::size_t>(z)].prior_sigma) || x_[z] >= plane_z_m) continue;
      x_[z] = 2 * plane_z_m - x_[z];
      lifted = true;
    }
    return lifted;
  }

  /// Exchanged or misplaced beacons, once the arrivals have told where they are.
  bool mend_labels() {
    const LabelCheck check = check_labels(problem_, layout_, x_);
    solution_.warnings.insert(solution_.warnings.end(), check.warnings.begin(), check.warnings.end());
    if (!check.mended) return true;
    if (!report("adjustment with mended positions", 0.62)) return false;
    place_again(kCauchyScale, 0.0);
    return adjust_with(kCauchyScale, 1e-10);
  }

  /// States that fell into a wrong place while the beacons were off, which they may still be by so many sigmas of an arrival.
  void place_again(double scale, double slack_sigmas) {
    const EpochFixModel model = search_model(problem_, layout_.state_of(x_), usable_);
    for (Trajectory& t : trajectories_) place_states(t, model, slack_sigmas * sigma_m(), true, kSuspectSigmas + scale, options_.threads);
    readmit_all(trajectories_, usable_);
  }

  /// What the final rejection will leave: squares up to its limit. Lower is a larger consensus.
  [[nodiscard]] double consensus_cost() const {
    const SharedState state = layout_.state_of(x_);
    const double cap = 0.5 * options_.rejection_sigmas * options_.rejection_sigmas;
    double cost = prior_cost(problem_, layout_, x_);
    for (const Trajectory& t : trajectories_)
      for (const ArrivalObservation& a : t.arrivals)
        if (a.rejection != Rejection::kBeaconUnusable && a.rejection != Rejection::kNoPose)
          cost += std::min(cap, 0.5 * std::pow(arrival_residual(t, a, state), 2));
    return cost;
  }

  /// Beacons and states hold each other in wrong places: a few flipped headings keep the beacons off, and those keep the headings.
  /// So the search is repeated with less and less trust in the beacons withdrawn, and the largest consensus is kept.
  bool search_and_adjust() {
    double best = consensus_cost();
    std::size_t failures = 0;
    for (const double slack : kSearchSlacks) {
      const Eigen::VectorXd x = x_;
      const std::vector<Trajectory> trajectories = trajectories_;
      const AdjustResult last = last_;
      if (!report(fmt::format("search again, beacons trusted to {:.3g} sigma", slack), 0.65)) return false;
      place_again(kCauchyScale, slack);
      for (const double scale : {std::max(slack, kCauchyScale), kCauchyScale})
        if (!adjust_with(scale, scale > kCauchyScale ? 1e-4 : 1e-10)) return false;
      const double cost = consensus_cost();
      const bool better = cost < best, much_better = cost < kMuchBetter * best;
      if (better) {
        best = cost;
      } else {
        x_ = x;
        trajectories_ = trajectories;
        last_ = last;
      }
      if (!much_better && ++failures >= 2) break;
    }
    return true;
  }

  /// Plain squares on the arrivals that agree; the noise as found where the stated one is off.
  bool settle_noise() {
    double factor = agreeing_sigma(trajectories_, layout_.state_of(x_));
    const bool far_off = factor < 0.5 || factor > 1.5;  // small departures wait for the chi-square test
    if (far_off) scale_noise(factor);
    for (int round = 0; round < kNoiseRounds; ++round) {
      if (!reject_and_adjust()) return false;
      const CalibrationStatistics s = statistics_of(problem_, layout_, trajectories_, layout_.state_of(x_), last_.cost, options_.threads);
      statistics_ = s;
      // A prior that is contradicted is no noise of the arrivals: only what the recordings say counts.
      const double squares = 2 * (last_.cost - prior_cost(problem_, layout_, x_));
      if (!(s.redundancy >= 30) || !(squares > 0) || chi_square_p(squares, s.redundancy) > 0.01) break;
      const double off = std::sqrt(squares / s.redundancy);
      if (std::abs(off - 1) < kNoiseMatters) break;  // seen by the test, but of no consequence for any sigma
      scale_noise(off);
    }
    return true;
  }

  void scale_noise(double factor) {
    noise_factor_ *= factor;
    last_.data_information.reset();
    statistics_.reset();
    for (Trajectory& t : trajectories_)
      for (ArrivalObservation& a : t.arrivals) a.sigma_s = problem_.site.noise.tof_sigma_s * noise_factor_;
  }

  bool reject_and_adjust() {
    for (int round = 0; round < kRejectionRounds; ++round) {
      if (!report("adjustment of the arrivals that agree", std::min(0.9, 0.7 + 0.03 * round))) return false;
      const std::size_t changed = mark_rejected(trajectories_, layout_.state_of(x_), options_.rejection_sigmas, options_.threads);
      if (round > 0 && changed == 0) break;
      last_.data_information.reset();
      if (!adjust_with(0.0, 1e-12)) return false;
    }
    return true;
  }

  void conclude() {
    report("covariance and verdict", 0.95);
    solution_.state = layout_.state_of(x_);
    solution_.final_cost = last_.cost;
    solution_.tof_sigma_s = problem_.site.noise.tof_sigma_s * noise_factor_;
    solution_.statistics = statistics_ ? *statistics_ : statistics_of(problem_, layout_, trajectories_, solution_.state, last_.cost, options_.threads);
    solution_.statistics.converged = last_.converged;
    // The factor is told against what the site file states, not against the noise as found.
    solution_.statistics.variance_factor *= noise_factor_ * noise_factor_;
    solution_.statistics.chi2_p =
        chi_square_p(solution_.statistics.variance_factor * solution_.statistics.redundancy, solution_.statistics.redundancy);
    solution_.status = last_.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
    solution_.message = last_.converged ? "converged" : "the adjustment did not converge: " + last_.message;
    solution_.datum = datum_of(problem_);
    // What the data do not determine is often what keeps the iteration from settling, and then that is the finding.
    const Covariance C = judge(problem_, layout_, x_, usable_, mirrored(), options_.strict, trajectories_, solution_, options_.workers(), last_.data_information);
    solution_.reliability = reliability_of(problem_, layout_, trajectories_, solution_.state, C, solution_.beacon_status, noise_factor_, options_.threads);
    collect_left_out();
    noise_warning();
    for (std::string& warning : report_flips(problem_, trajectories_, start_headings_rad_)) solution_.warnings.push_back(std::move(warning));
    for (std::string& warning : suspect_control_points(problem_, solution_.state, trajectories_)) solution_.warnings.push_back(std::move(warning));
    finish();
  }

  /// Beacons that a mirror image explains as well from the final states; the start saw them with rougher ranges.
  [[nodiscard]] std::vector<bool> mirrored() const {
    std::vector<bool> still = start_.beacon_mirrored;
    for (std::size_t b = 0; b < still.size(); ++b)
      if (still[b]) still[b] = has_mirror_image(problem_, solution_.state, trajectories_, b, 3 * sigma_m());
    return still;
  }

  void noise_warning() {
    const CalibrationStatistics& s = solution_.statistics;
    if (s.redundancy >= 30 && noise_factor_ > 1.2)
      solution_.warnings.push_back(fmt::format(
          "residuals are {:.2f} times the stated noise (variance factor {:.3g}); sigmas are scaled to the residuals, but errors that stay the "
          "same at a place or a pair are not noise and make the beacons worse than their sigmas say",
          noise_factor_, s.variance_factor));
    const Whiteness w = whiteness_of(trajectories_, solution_.state, options_.threads);
    if (!w.white)
      solution_.warnings.push_back(fmt::format(
          "residuals are no white noise: those of a beacon-receiver pair keep a common part (variance of pair means {:.3g} times that of noise, "
          "correlation in time {:.2f}), as reflections and antennas cause; such errors do not average out, so expect the beacons off by several "
          "times their stated sigmas, or state noise.pair_sigma_s",
          w.pair_ratio, w.autocorrelation));
  }

  void collect_left_out() {
    for (const Trajectory& t : trajectories_) {
      for (const std::size_t i : t.stateless_arrivals) solution_.left_out.push_back({t.run, i, Rejection::kNoPose, 0.0});
      for (const ArrivalObservation& a : t.arrivals) {
        if (a.rejection == Rejection::kUsed) continue;
        const bool placed = a.rejection == Rejection::kLate || a.rejection == Rejection::kEarly || is_gated(a.rejection);
        solution_.left_out.push_back({t.run, a.arrival, a.rejection, placed ? a.sigma_s * arrival_residual(t, a, solution_.state) : 0.0});
      }
    }
  }

  void finish() {
    solution_.trajectories = std::move(trajectories_);
    solution_.seconds = std::chrono::duration<double>(Clock::now() - began_).count();
  }

  const Problem& problem_;
  const SolveOptions& options_;
  std::vector<Trajectory>* own_trajectories_;
  Clock::time_point began_;
  Start start_;
  std::vector<Trajectory> trajectories_;
  std::vector<std::vector<double>> start_headings_rad_;
  std::vector<bool> usable_;
  ParameterLayout layout_;
  Eigen::VectorXd x_;
  AdjustResult last_;
  Solution solution_;
  std::optional<CalibrationStatistics> statistics_;  ///< at the last states and marks
  double noise_factor_ = 1.0;
  bool placed_any_ = false;
  std::string stage_;
  double fraction_ = 0.0;
};

}  // namespace

Solution solve(const Problem& problem, const SolveOptions& options) { return Calibrator(problem, options).run(); }

Solution solve_in_place(Problem& problem, const SolveOptions& options) { return Calibrator(problem, options, &problem.trajectories).run(); }

}  // namespace octant::calib

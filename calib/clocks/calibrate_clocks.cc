// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/calibrate_clocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/clocks/clock_findings.h"
#include "calib/clocks/clock_fit.h"
#include "calib/errors/statistics.h"
#include "calib/solution/variances.h"
#include "calib/verdict/datum.h"
#include "models/changes/chi_square.h"

namespace octant::calib {
namespace {

/// Points that suffice for a start.
constexpr std::size_t kStartPoints = 40;
constexpr int kMostJumps = 4;
/// A rival solution whose log-likelihood is less than this below the best is within the evidence.
constexpr double kWithinEvidence = 5.0;
/// Share of rejected receptions, factor of the noise, and deviation of a beacon from its prior in sigmas,
/// beyond which the stated positions are tested.
constexpr double kManyRejected = 0.02, kMuchNoise = 1.3, kFarFromPrior = 3.3;
/// A beacon is undetermined where its sigma exceeds this share of the extent of the site.
constexpr double kVague = 0.3;
/// Significance of the test of the common clock.
constexpr double kClockSignificance = 1e-6;

class ClockCalibrator {
 public:
  ClockCalibrator(Site site, std::vector<MeasurementLog> runs, const ClockInput& input,
                  const SolveOptions& options)
      : options_(options), input_(input) {
    result_.problem.site = std::move(site);
    result_.problem.runs = std::move(runs);
  }

  Result<ClockCalibration> run() {
    const Site& site = result_.problem.site;
    start_ = make_clock_problem(site, result_.problem.runs, input_.logs, input_.model, kStartPoints);
    if (start_.receptions.empty())
      return fail({.file = result_.problem.runs.empty() ? site.path : result_.problem.runs.front().path,
                   .found = "no time difference and no transmission with two receptions",
                   .expected = "rows in tdoa.csv or toa.csv"});
    found_ = start_clocks(start_, [this](int k) { return report("starts", 0.01 * k); });
    p_ = make_clock_problem(site, result_.problem.runs, input_.logs, input_.model);
    result_.problem.typical_range_m = p_.extent_m;
    if (!report("adjustment", 0.6)) return interrupted();
    fit_ = adjust_and_reject(p_, continued(start_, found_.x, p_), options_.rejection_sigmas);
    find_jumps();
    if (!report("stated positions", 0.9)) return interrupted();
    fill_solution();
    test_positions();
    return std::move(result_);
  }

 private:
  [[nodiscard]] Solution& solution() { return result_.solution; }
  bool report(const std::string& stage, double fraction) const {
    return !options_.on_progress || options_.on_progress({stage, 0, 0.0, fraction});
  }
  Result<ClockCalibration> interrupted() {
    solution().status = SolveStatus::kInterrupted;
    return std::move(result_);
  }

  void find_jumps() {
    for (int k = 0; k < kMostJumps; ++k) {
      const auto jump = jump_in(p_, fit_);
      if (!jump) return;
      ClockProblem with = p_;
      with.jumps.push_back(*jump);
      Eigen::VectorXd x = Eigen::VectorXd::Zero(with.size());
      const int at = with.jump(with.jumps.size() - 1);
      x.head(at) = fit_.x.head(at);
      x.tail(fit_.x.size() - at) = fit_.x.tail(fit_.x.size() - at);
      x[at] = size_of(*jump);
      const ClockFit fit = adjust_and_reject(with, std::move(x), options_.rejection_sigmas);
      const Eigen::MatrixXd C = covariance_of(with, fit, {at});
      if (C.size() == 0 || !(std::abs(fit.x[at]) > kFarFromPrior * 2 * std::sqrt(C(0, 0)))) return;
      p_ = std::move(with);
      fit_ = fit;
    }
  }

  /// Step of the median residual at a time, in metres.
  [[nodiscard]] double size_of(const ClockJump& jump) const {
    std::vector<double> before, after;
    for (const ClockRow& row : rows_at(p_, fit_.x)) {
      if (row.kind != ClockRowKind::kReception) continue;
      const ClockReception& r = p_.receptions[row.index];
      if (r.run == jump.run && p_.clocks.of_device[r.to.index()] == jump.clock)
        (r.time_s < jump.time_s ? before : after).push_back(row.residual * p_.sigma_m);
    }
    const auto median = [](std::vector<double>& v) {
      std::ranges::nth_element(v, v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2));
      return v[v.size() / 2];
    };
    return before.empty() || after.empty() ? 0.0 : median(after) - median(before);
  }

  void fill_solution() {
    Solution& s = solution();
    s.status = fit_.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
    s.message = fit_.converged ? "converged" : "the adjustment did not converge";
    s.iterations = fit_.iterations;
    s.final_cost = fit_.cost;
    s.tof_sigma_s = p_.sigma_m / p_.speed_mps;
    s.datum = datum_of(result_.problem);
    if (p_.frame_is_datum) set_free_network(s.datum);
    fill_state();
    fill_trajectories();
    fill_covariance();
    s.statistics = {.arrivals = fit_.used,
                    .rejected = fit_.rejected,
                    .unknowns = fit_.unknowns,
                    .redundancy = fit_.redundancy,
                    .variance_factor = fit_.variance_factor * std::pow(fit_.noise_factor, 2),
                    .rms_s = rms_s(),
                    .converged = fit_.converged};
    s.statistics.chi2_p = chi_square_p(s.statistics.variance_factor * fit_.redundancy, fit_.redundancy);
    warn();
  }

  [[nodiscard]] double rms_s() const {
    double squares = 0.0;
    for (const ClockRow& row : rows_at(p_, fit_.x))
      if (row.kind == ClockRowKind::kReception && p_.receptions[row.index].used)
        squares += std::pow(row.residual * p_.sigma_m, 2);
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(fit_.used, 1))) / p_.speed_mps;
  }

  void fill_state() {
    SharedState& state = solution().state;
    state = prior_state(result_.problem.site);
    for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b) {
      state.beacon_p_map_m[b] = fit_.x.segment<3>(p_.beacon(b));
      state.beacon_delay_s[b] = fit_.x[p_.delay(b)] / p_.speed_mps;
    }
    state.speed_offset_mps = {fit_.x[p_.speed()]};
    if (!p_.clocks.is_free) return;
    for (std::size_t run = 0; run < p_.knots_s.size(); ++run)
      for (int c = 0; c < static_cast<int>(p_.clocks.names.size()); ++c) add_clock(run, c);
    const std::size_t last = p_.knots_s.size() - 1;
    for (std::size_t b = 0; b < state.beacon_delay_s.size(); ++b) {
      const auto clock = static_cast<std::size_t>(p_.clocks.of_device[b]);
      state.beacon_delay_s[b] += result_.clocks[last * p_.clocks.names.size() + clock].offset_s;
    }
  }

  /// Clock in the middle of a run. Its rate is the mean one of the run.
  void add_clock(std::size_t run, int c) {
    const std::vector<double>& knots = p_.knots_s[run];
    const std::size_t middle = knots.size() / 2;
    const int at = p_.knot(run, c, middle), first = p_.knot(run, c, 0),
              last = p_.knot(run, c, knots.size() - 1);
    const Eigen::Vector2d line = p_.lines[run][static_cast<std::size_t>(c)];
    const double rate =
        knots.size() == 1 ? fit_.x[at + 1] : (fit_.x[last] - fit_.x[first]) / (knots.back() - knots.front());
    const Eigen::MatrixXd C = covariance_of(p_, fit_, {at, at + 1});
    ClockResult& clock = result_.clocks.emplace_back();
    clock.name = p_.clocks.names[static_cast<std::size_t>(c)];
    clock.run = run;
    clock.time_s = knots[middle];
    clock.offset_s = line[0] + line[1] * (clock.time_s - p_.middle_s[run]) + fit_.x[at] / p_.speed_mps;
    clock.rate = line[1] + rate / p_.speed_mps;
    if (C.size() == 0) return;
    clock.offset_sigma_s = std::sqrt(std::max(C(0, 0), 0.0)) / p_.speed_mps;
    clock.rate_sigma = std::sqrt(std::max(C(1, 1), 0.0)) / p_.speed_mps;
  }

  void fill_trajectories() {
    for (std::size_t run = 0; run < result_.problem.runs.size(); ++run)
      for (std::size_t v = 0; v < result_.problem.site.vehicles.size(); ++v) {
        Trajectory t;
        t.run = run;
        t.vehicle = VehicleId(v);
        t.motion = result_.problem.site.motion;
        for (std::size_t i = 0; i < p_.points.size(); ++i) {
          const ClockPoint& point = p_.points[i];
          if (point.run != run || point.vehicle.index() != v) continue;
          Node node{.time_s = point.time_s, .epoch = point.epoch, .T_map_vehicle = {}, .placed = true};
          const Eigen::Vector3d place = fit_.x.segment<3>(p_.point(i));
          node.T_map_vehicle = Pose::planar(place.x(), place.y(), fit_.x[p_.point(i) + 3]);
          node.T_map_vehicle.translation_m = place;
          t.nodes.push_back(node);
        }
        if (!t.nodes.empty()) solution().trajectories.push_back(std::move(t));
      }
  }

  void fill_covariance() {
    Solution& s = solution();
    std::vector<int> elements;
    const std::vector<bool> fixed = fixed_elements(p_);
    const auto add = [&](const ParameterId& id, int at) {
      if (fixed[static_cast<std::size_t>(at)]) return;
      s.covariance.parameters.push_back(id);
      elements.push_back(at);
    };
    for (std::size_t b = 0; b < p_.site.beacons.size(); ++b) {
      for (std::size_t i = 0; i < 3; ++i)
        add(parameters::beacon_position(b, i), p_.beacon(b) + static_cast<int>(i));
      add(parameters::beacon_delay(b),
          p_.clocks.is_free
              ? p_.knot(p_.knots_s.size() - 1, p_.clocks.of_device[b], p_.knots_s.back().size() / 2)
              : p_.delay(b));
    }
    add(parameters::speed(), p_.speed());
    Eigen::MatrixXd C = covariance_of(p_, fit_, elements);
    if (C.size() == 0)
      C = Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(elements.size()),
                                    static_cast<Eigen::Index>(elements.size())) *
          std::pow(p_.extent_m * 10, 2);
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (s.covariance.parameters[i].kind == ParameterKind::kBeaconDelay) {
        C.row(static_cast<Eigen::Index>(i)) /= p_.speed_mps;
        C.col(static_cast<Eigen::Index>(i)) /= p_.speed_mps;
      }
    s.covariance.matrix = std::move(C);
    judge_beacons();
  }

  void judge_beacons() {
    Solution& s = solution();
    const Variances variances(s);
    std::vector<bool> received(p_.site.beacons.size(), false);
    for (const ClockReception& r : p_.receptions)
      for (const DeviceId end : {r.from, r.to})
        if (r.used && p_.is_beacon(end)) received[end.index()] = true;
    std::vector<std::string> names;
    std::size_t asked = 0;
    for (std::size_t b = 0; b < p_.site.beacons.size(); ++b) {
      const bool is_control = p_.site.beacons[b].is_control_point();
      const bool is_vague = variances.beacon_sigma_m(b).maxCoeff() > kVague * p_.extent_m;
      const bool is_lost = !is_control && (!received[b] || is_vague);
      asked += !is_control;
      s.beacon_status.push_back(is_control ? BeaconStatus::kControlPoint
                                : is_lost  ? BeaconStatus::kUndetermined
                                           : BeaconStatus::kCalibrated);
      if (is_lost) names.push_back(p_.site.beacons[b].name);
    }
    if (names.empty()) return;
    for (const std::string& name : names) s.undetermined.push_back("beacon/" + name);
    const std::string words =
        fmt::format("the receptions do not determine the positions of {}", fmt::join(names, ", "));
    if (2 * names.size() >= asked || options_.strict) {
      s.status = SolveStatus::kUndetermined;
      s.message =
          words + (p_.clocks.is_free ? ": a clock of its own hides one distance of each beacon; record more "
                                       "places of the vehicle around the beacons, on all sides"
                                     : ": record more places of the vehicle, on all sides of the beacons");
    } else {
      s.warnings.push_back(words);
    }
  }

  void warn() {
    Solution& s = solution();
    for (std::size_t j = 0; j < p_.jumps.size(); ++j) {
      const ClockJump& jump = p_.jumps[j];
      const std::string text = fmt::format(
          "The clock of {} jumps by {:.4g} us at {:.3f} s of {}: the calibration allows for it. Check "
          "whether "
          "the device restarted or lost its synchronisation.",
          p_.clocks.names[static_cast<std::size_t>(jump.clock)], 1e6 * fit_.x[p_.jump(j)] / p_.speed_mps,
          jump.time_s - p_.base_s[static_cast<std::size_t>(jump.run)],
          result_.problem.runs[static_cast<std::size_t>(jump.run)].path);
      result_.findings.push_back({"clock_step", text});
    }
    if (found_.agreeing < found_.starts)
      s.warnings.push_back(
          fmt::format("{} of {} starts found this solution, and no start found a better one; this does not "
                      "prove that it is "
                      "the best",
                      found_.agreeing, found_.starts));
    if (found_.rival_cost &&
        *found_.rival_cost < kWithinEvidence * std::min(1.0, std::pow(fit_.noise_factor, 2)))
      s.warnings.push_back(fmt::format(
          "another solution explains the receptions about as well, with beacons up to {:.3g} m elsewhere: "
          "state approximate positions, or record more places of the vehicle",
          *found_.rival_m));
  }

  /// Tests if the beacons share one clock, as the site file states without `clock: free`.
  bool test_common_clock() {
    if (p_.clocks.is_free) return false;
    ClockModel free = input_.model;
    free.is_free = true;
    const ClockProblem problem =
        make_clock_problem(p_.site, result_.problem.runs, input_.logs, free, kStartPoints);
    const ClockStart start =
        start_clocks(problem, [this](int k) { return report("clocks", 0.9 + 0.001 * k); });
    const int dof = 2 * static_cast<int>(p_.site.beacons.size() - 1);
    const double gain = found_.cost - start.cost;
    if (gain < 0.5 * chi_square_beyond(kClockSignificance, dof)) return false;
    double largest_s = 0.0;
    for (std::size_t b = 0; b < p_.site.beacons.size(); ++b) {
      const int clock = problem.clocks.of_device[b];
      largest_s = std::max(largest_s, std::abs(problem.lines.back()[static_cast<std::size_t>(clock)][0] +
                                               start.x[problem.knot(problem.knots_s.size() - 1, clock, 0)] /
                                                   problem.speed_mps));
    }
    solution().contradictions.push_back(
        {ContradictionKind::kDelay, "clocks of the beacons", "one clock for all beacons",
         fmt::format("clocks that differ by up to {:.3g} s", largest_s), std::sqrt(2.0 * gain),
         "state timing.clock: free in the site file, and the same clock for beacons that share one"});
    return true;
  }

  void test_positions() {
    const Site& site = p_.site;
    bool suspicious = fit_.noise_factor > kMuchNoise ||
                      static_cast<double>(fit_.rejected) > kManyRejected * static_cast<double>(fit_.used);
    for (std::size_t b = 0; b < site.beacons.size(); ++b)
      for (std::size_t i = 0; i < 3; ++i)
        if (const SiteBeacon& beacon = site.beacons[b];
            beacon.position_m[i] && beacon.sigma_m[i].value_or(0) > 0)
          suspicious = suspicious || std::abs(fit_.x[p_.beacon(b) + static_cast<int>(i)] -
                                              *beacon.position_m[i]) > kFarFromPrior * *beacon.sigma_m[i];
    suspicious = suspicious || std::abs(fit_.x[p_.speed()]) > kFarFromPrior * site.speed_sigma_mps;
    if (!suspicious || test_common_clock()) return;
    for (ClockReception& r : start_.receptions)  // a clock that jumped has one side of its jump here
      r.used = std::ranges::none_of(p_.jumps, [&](const ClockJump& jump) {
        return jump.run == r.run && jump.clock == start_.clocks.of_device[r.to.index()] &&
               r.time_s >= jump.time_s;
      });
    if (auto wrong = wrong_position(start_, found_.x, std::min(p_.sigma_m, start_.sigma_m)))
      solution().contradictions.push_back(std::move(*wrong));
  }

  const SolveOptions& options_;
  const ClockInput& input_;
  ClockCalibration result_;
  ClockProblem start_, p_;
  ClockStart found_;
  ClockFit fit_;
};

}  // namespace

Result<ClockCalibration> calibrate_clocks(Site site, std::vector<MeasurementLog> runs,
                                          const ClockInput& input, const SolveOptions& options) {
  return ClockCalibrator(std::move(site), std::move(runs), input, options).run();
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/reliability.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/adjust/leverage.h"
#include "calib/adjust/priors.h"
#include "calib/errors/residual_groups.h"
#include "calib/errors/spread_leverage.h"
#include "calib/errors/statistics.h"
#include "calib/problem/ranges.h"
#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

/// Share of a beacon's lateness in the residuals below which it is rounding error.
constexpr double kUnnoticed = 1e-9;
constexpr std::size_t kTimeBins = 16;  // drifts are slow, but a door that opens is not

enum Kind : std::size_t { kTof, kAmplitude, kBearing, kOdometry, kPose, kMotion, kPrior, kDistance, kKinds };
constexpr const char* kKindName[kKinds] = {"tof",  "amplitude", "bearing", "odometry",
                                           "pose", "motion",    "prior",   "control_distance"};

Kind kind_of(RowKind kind) {
  switch (kind) {
    case RowKind::kTof: return kTof;
    case RowKind::kAmplitude: return kAmplitude;
    case RowKind::kBearing: return kBearing;
    case RowKind::kPose: return kPose;
    case RowKind::kOdometry: return kOdometry;
    case RowKind::kMotion: return kMotion;
  }
  return kTof;
}

/// Sums of one part of the observations.
struct ResidualSums {
  std::size_t observations = 0;
  double squares = 0.0, redundancy = 0.0;
  void add(double residual, double r) {
    ++observations;
    squares += residual * residual;
    redundancy += r;
  }
  [[nodiscard]] VarianceComponent component(std::string name, double variance_scale) const {
    VarianceComponent c{std::move(name), observations, redundancy, {}, {}};
    if (redundancy < 1.0 || !std::isfinite(squares)) return c;
    c.factor = variance_scale * squares / redundancy;
    c.chi2_p = chi_square_p(variance_scale * squares, redundancy);
    return c;
  }
};

std::optional<double> median_of(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional(median(values));
}
std::optional<double> largest_of(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional(*std::ranges::max_element(values));
}

class Collector {
 public:
  Collector(const Problem& problem, const ParameterLayout& layout,
            const std::vector<Trajectory>& trajectories, const SharedState& state, const Covariance& C,
            double noise_factor, int threads, std::size_t all_epochs, const LogTotals* log)
      : threads_(threads),
        problem_(problem),
        layout_(layout),
        trajectories_(trajectories),
        state_(state),
        C_(C),
        log_(log),
        sweep_(layout, C),
        variance_scale_(noise_factor * noise_factor),
        beacons_(problem.site.beacons.size()) {
    std::size_t epochs = 0;
    for (const Trajectory& t : trajectories) {
      if (t.segments.size() == t.nodes.size()) epochs += t.segments.size();
      if (has_long_chain(t)) epochs += t.nodes.size();
    }
    step_ = sample_stride(epochs, all_epochs);
    out_.stride = step_ * (log == nullptr ? 1 : log->stride);
  }

  Reliability run() {
    for (const Trajectory& t : trajectories_) {
      const bool stops = t.segments.size() == t.nodes.size();
      if (out_.stride > 1 && (stops || has_long_chain(t))) {
        const auto rows = stops ? sweep_spread_stops(sweep_, t, state_, step_, threads_)
                                : sweep_spread_stretches(sweep_, t, state_, step_, threads_);
        make_room(rows.size());
        for (const SweptRow& row : rows) observation(t, row);
      } else {
        sweep_.sweep(t, state_, 0, t.segments.size(), 1,
                     [&](const RowLeverage& l) { observation(t, swept_row(l)); });
      }
    }
    shared_observations();
    arrivals();
    const double share = sampled_share();
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const bool sampled = kind != kPrior && kind != kDistance;
      out_.redundancy_sum += kinds_[kind].redundancy * (sampled ? share : 1.0);
      if (kinds_[kind].observations > 0)
        out_.kinds.push_back(kinds_[kind].component(kKindName[kind], kind == kTof ? variance_scale_ : 1.0));
    }
    for (std::size_t b = 0; b < beacons_.size(); ++b) beacon(b);
    left_out();
    out_.by_beacon = groups_by_name(by_beacon_, names_of(problem_.site).beacons);
    out_.by_receiver = groups_by_name(by_receiver_, receiver_names());
    out_.by_distance = groups_by_quantity(std::move(by_distance_));
    out_.by_temperature = groups_by_quantity(std::move(by_temperature_));
    out_.by_incidence = groups_by_quantity(std::move(by_incidence_));
    out_.by_time = groups_by_quantity(std::move(by_time_), kTimeBins);
    out_.ok = true;
    return std::move(out_);
  }

 private:
  struct BeaconSums {
    ResidualSums part;
    double sum_s = 0.0, squares_s2 = 0.0;
    std::size_t uncontrolled = 0;
    std::vector<double> mdb_s, influence_m;
  };

  /// Reserves memory, because a growing vector temporarily needs three times its size and these are the
  /// largest of a long log.
  void make_room(std::size_t rows) {
    for (auto* all : {&by_beacon_, &by_receiver_, &by_distance_, &by_incidence_, &by_time_})
      all->reserve(all->size() + rows);
    out_.arrivals.reserve(out_.arrivals.size() + rows);
  }

  void observation(const Trajectory& t, const SweptRow& l) {
    const double r = 1.0 - l.leverage;
    kinds_[kind_of(l.kind)].add(l.residual, r);
    if (l.kind == RowKind::kTof) arrival(t, l, r);
  }

  void arrival(const Trajectory& t, const SweptRow& l, double r) {
    const ArrivalObservation& a = t.arrivals[l.index];
    const double speed = a.model_speed_mps + state_.speed_offset(t.run),
                 range_per_s = a.two_way ? 0.5 * speed : speed;
    ArrivalReliability s;
    s.run = t.run;
    s.arrival = a.arrival;
    s.beacon = a.beacon;
    s.receiver = a.receiver;
    s.residual_s = a.sigma_s * l.residual;
    s.redundancy = r;
    s.controlled = r > kUncontrolled;
    if (s.controlled) {
      s.w = l.residual / std::sqrt(r);
      s.mdb_s = a.sigma_s * kDelta0 / std::sqrt(r);
      s.mdb_m = s.mdb_s * range_per_s;
      s.influence_m = l.shift_m * kDelta0 / std::sqrt(r);
    }
    BeaconSums& b = beacons_[a.beacon.index()];
    b.part.add(l.residual, r);
    b.sum_s += s.residual_s;
    b.squares_s2 += s.residual_s * s.residual_s;
    b.uncontrolled += s.controlled ? 0 : 1;
    if (s.controlled) {
      b.mdb_s.push_back(s.mdb_s);
      b.influence_m.push_back(s.influence_m);
    }
    const auto grouped = [&](double key) { return GroupedResidual{key, s.residual_s, range_per_s}; };
    by_beacon_.push_back(grouped(static_cast<double>(a.beacon.index())));
    by_receiver_.push_back(grouped(static_cast<double>(a.receiver.index())));
    const Pose T = pose_at(t, a.node, a.alpha);
    const Eigen::Vector3d path =
        state_.beacon_p_map_m[a.beacon.index()] - T * state_.receiver_p_vehicle_m[a.receiver.index()];
    by_distance_.push_back(grouped(path.norm()));
    by_incidence_.push_back(grouped(incidence_rad(path, T, a.receiver)));
    by_time_.push_back(grouped(a.time_s - problem_.runs[t.run].arrivals.front().time_s));
    const double temperature = problem_.runs[t.run].arrivals[a.arrival].temperature_degC;
    if (std::isfinite(temperature)) by_temperature_.push_back(grouped(temperature));
    out_.arrivals.push_back(s);
  }

  /// @param path  vector from receiver to beacon, in the map
  [[nodiscard]] double incidence_rad(const Eigen::Vector3d& path, const Pose& T_map_vehicle,
                                     ReceiverId receiver) const {
    const auto& axis = problem_.site.receivers[receiver.index()].axis;
    if (!axis) return std::atan2(path.head<2>().norm(), std::abs(path.z()));
    const Eigen::Vector3d a = T_map_vehicle.rotation * *axis;
    return std::atan2(a.cross(path).norm(), a.dot(path));
  }

  /// Ratio of used to sampled arrivals.
  [[nodiscard]] double sampled_share() const {
    if (out_.stride == 1 || kinds_[kTof].observations == 0) return 1.0;
    std::size_t used = log_ == nullptr ? 0 : log_->used();
    for (const Trajectory& t : trajectories_)
      for (std::size_t i = 0; log_ == nullptr && i < t.arrivals.size(); ++i)
        used += t.arrivals[i].rejection == Rejection::kUsed;
    return static_cast<double>(used) / static_cast<double>(kinds_[kTof].observations);
  }

  /// A lateness acts like the beacon's delay. Data and prior together give N e = N_data e + p e, with p the
  /// information of its prior. With C N e = e it moves the parameters by C N_data e = e - p C e. The
  /// residuals retain p - p^2 C_dd, the part that the prior contradicts.
  [[nodiscard]] std::vector<LatenessInformation> lateness_by_delays() const {
    constexpr std::size_t kAtOnce = 64;
    std::vector<LatenessInformation> late(layout_.beacon.size());
    std::vector<int> delays, beacons;
    const auto solve_delays = [&] {
      const Eigen::MatrixXd moved = C_.columns(delays);
      for (std::size_t k = 0; k < delays.size(); ++k) {
        const double p = prior_weight(delays[k]), per_s = 1.0 / layout_.parameter(delays[k]).si_per_unit;
        const auto by_delay = moved.col(static_cast<Eigen::Index>(k));
        const double share = std::clamp(p * by_delay[delays[k]], 0.0, 1.0);
        LatenessInformation& of_beacon = late[static_cast<std::size_t>(beacons[k])];
        of_beacon.remaining = per_s * per_s * p * (1.0 - share);
        of_beacon.total =
            // Data and prior together, with all other parameters eliminated
            share > 0 ? per_s * per_s * p / share : 0.0;
        for (const int c : layout_.beacon_columns())
          of_beacon.shift_m_per_s = std::max(of_beacon.shift_m_per_s, per_s * p * std::abs(by_delay[c]));
      }
      delays.clear();
      beacons.clear();
    };
    for (std::size_t b = 0; b < late.size(); ++b) {
      const int delay = layout_.column_of(parameters::beacon_delay(b));
      if (delay < 0) continue;
      delays.push_back(delay);
      beacons.push_back(static_cast<int>(b));
      if (delays.size() == kAtOnce) solve_delays();
    }
    solve_delays();
    return late;
  }
  [[nodiscard]] double prior_weight(int column) const {
    const double sigma = layout_.parameter(column).prior_sigma;
    return std::isfinite(sigma) ? 1.0 / (sigma * sigma) : 0.0;
  }

  /// Priors of single parameters, and taped distances.
  void shared_observations() {
    const std::vector<PriorRow> rows = prior_rows(problem_, layout_, layout_.vector_of(state_));
    const std::size_t distances = layout_.parameters.size();  // rows after the priors
    for (std::size_t i = 0; i < distances + problem_.site.distances.size(); ++i)
      if (i >= distances || std::isfinite(layout_.parameters[i].prior_sigma))
        kinds_[i < distances ? kPrior : kDistance].add(
            rows[i].residual, 1.0 - std::min(1.0, sweep_.leverage_of(rows[i].entries)));
  }

  void arrivals() {
    std::vector<std::size_t> order(out_.arrivals.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t few = std::min(kWorst, order.size());
    std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(few),
                              [this](std::size_t a, std::size_t b) {
                                return std::abs(out_.arrivals[a].w) > std::abs(out_.arrivals[b].w);
                              });
    order.resize(few);
    out_.worst = std::move(order);
    for (const ArrivalReliability& a : out_.arrivals) out_.beyond_critical += std::abs(a.w) > kCriticalW;
    const ResidualSums& tof = kinds_[kTof];
    if (tof.observations > 0) out_.mean_redundancy = tof.redundancy / static_cast<double>(tof.observations);
  }

  void beacon(std::size_t index) {
    const BeaconSums& sums = beacons_[index];
    BeaconReliability b;
    b.name = problem_.site.beacons[index].name;
    b.used = sums.part.observations;
    b.uncontrolled = sums.uncontrolled;
    if (b.used > 0) {
      const auto n = static_cast<double>(b.used);
      b.mean_redundancy = sums.part.redundancy / n;
      b.mean_s = sums.sum_s / n;
      b.rms_s = std::sqrt(sums.squares_s2 / n);
    }
    b.component = sums.part.component(b.name, variance_scale_);
    b.mdb_median_s = median_of(sums.mdb_s);
    b.mdb_worst_s = largest_of(sums.mdb_s);
    b.influence_median_m = median_of(sums.influence_m);
    b.influence_worst_m = largest_of(sums.influence_m);
    if (lateness_.empty())
      lateness_ = out_.stride > 1 || C_.matrix() == nullptr ? lateness_by_delays() : sweep_.lateness();
    const LatenessInformation& late = lateness_[index];
    if (late.total > 0 && late.remaining > kUnnoticed * late.total) {
      b.lateness_mdb_s = kDelta0 / std::sqrt(late.remaining);
      b.lateness_influence_m = late.shift_m_per_s * *b.lateness_mdb_s;
    }
    out_.beacons.push_back(std::move(b));
  }

  void left_out() {
    std::vector<RejectionCounts> counts;
    if (log_ != nullptr) {
      counts = log_->of_beacon;
    } else {
      counts = rejections_by_beacon(trajectories_, out_.beacons.size());
      for (const Trajectory& t : trajectories_)
        for (const std::size_t i : t.stateless_arrivals)
          counts[problem_.runs[t.run].arrivals[i].beacon.index()].add(Rejection::kNoPose);
    }
    for (std::size_t b = 0; b < out_.beacons.size(); ++b) {
      BeaconReliability& beacon = out_.beacons[b];
      beacon.used = counts[b].of(Rejection::kUsed);
      beacon.late = counts[b].of(Rejection::kLate);
      beacon.early = counts[b].of(Rejection::kEarly);
      beacon.other = counts[b].all() - beacon.used - counts[b].outliers();
    }
  }

  [[nodiscard]] std::vector<std::string> receiver_names() const {
    std::vector<std::string> names;
    for (std::size_t r = 0; r < problem_.site.receivers.size(); ++r)
      names.push_back(receiver_path(r, names_of(problem_.site)));
    return names;
  }

  int threads_;
  const Problem& problem_;
  const ParameterLayout& layout_;
  const std::vector<Trajectory>& trajectories_;
  const SharedState& state_;
  const Covariance& C_;
  const LogTotals* log_;
  std::size_t step_ = 1;
  LeverageSweep sweep_;
  double variance_scale_;
  std::array<ResidualSums, kKinds> kinds_;
  std::vector<BeaconSums> beacons_;
  std::vector<LatenessInformation> lateness_;
  std::vector<GroupedResidual> by_beacon_, by_receiver_, by_distance_, by_temperature_, by_incidence_,
      by_time_;
  Reliability out_;
};

}  // namespace

ErrorEllipse error_ellipse(const Eigen::Matrix3d& covariance_m2) {
  ErrorEllipse e;
  const SymmetricEigen<Eigen::Matrix2d> flat(covariance_m2.topLeftCorner<2, 2>());
  e.semi_major_m = kEllipse95 * std::sqrt(std::max(0.0, flat.eigenvalues()[1]));
  e.semi_minor_m = kEllipse95 * std::sqrt(std::max(0.0, flat.eigenvalues()[0]));
  const Eigen::Vector2d axis = flat.eigenvectors().col(1);
  e.azimuth_rad = axis.x() < 0 || (axis.x() == 0 && axis.y() < 0) ? std::atan2(-axis.y(), -axis.x())
                                                                  : std::atan2(axis.y(), axis.x());
  const SymmetricEigen<Eigen::Matrix3d> space(covariance_m2, Eigen::EigenvaluesOnly);
  for (int i = 0; i < 3; ++i)
    e.semi_axes_m[static_cast<std::size_t>(i)] =
        kEllipsoid95 * std::sqrt(std::max(0.0, space.eigenvalues()[2 - i]));
  return e;
}

Reliability reliability_of(const Problem& problem, const ParameterLayout& layout,
                           const std::vector<Trajectory>& trajectories, const SharedState& state,
                           const Covariance& C, const std::vector<BeaconStatus>& beacon_status,
                           double noise_factor, int threads, std::size_t all_epochs, const LogTotals* log) {
  if (C.size() != layout.size() || !C.all_finite()) return {};
  Reliability out =
      Collector(problem, layout, trajectories, state, C, noise_factor, threads, all_epochs, log).run();
  for (std::size_t b = 0; b < out.beacons.size() && b < beacon_status.size(); ++b) {
    if (beacon_status[b] != BeaconStatus::kCalibrated) continue;
    out.beacons[b].ellipse = error_ellipse(C.block(layout.beacon[b]));
  }
  return out;
}

}  // namespace octant::calib

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_tracker.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/common/arrival_rejections.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/beacon_bank.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/drive/drive_start.h"
#include "models/support/scratch.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {
namespace {

constexpr std::size_t kDriveScratchBytes =
    9u << 20;  ///< solving for a window of all its nodes twice, and how it follows the calibration
constexpr std::size_t kMaxNodes = 768, kMaxArrivals = 8192;  ///< of a window
constexpr double kFilterWindowGrowth = 1.33;

/// What a row says of a vehicle that moves so: in the plane of three of its numbers.
Pose step_of(const OdometryStep& row, Motion motion) {
  return motion == Motion::kPlanar ? Pose::planar(row.dx_m, row.dy_m, row.dheading_rad) : row.pose();
}

OdometryObservation observation(std::size_t node, const OdometryStep& row, double fraction, Motion motion,
                                const OdometryAccuracy& a) {
  const OdometryVariance variance = variance_of(row, a);
  OdometryObservation o;
  o.node = node;
  o.T_before_after = interpolate(Pose{}, step_of(row, motion), fraction);
  o.distance_sigma_m = std::sqrt(fraction * variance.distance_m2);
  o.heading_sigma_rad = std::sqrt(fraction * variance.heading_rad2);
  return o;
}

}  // namespace

class DriveTracker::Core {
 public:
  Core() = default;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  virtual ~Core() = default;
  virtual void start(const Pose& T_map_vehicle, const PoseCovariance& covariance) = 0;
  virtual void move(const OdometryStep& step, double fraction) = 0;
  virtual void locate(std::span<const Arrival> arrivals, Fix& fix) = 0;
  [[nodiscard]] virtual Pose pose() const = 0;
  [[nodiscard]] virtual PoseCovariance covariance() const = 0;
  [[nodiscard]] virtual bool is_placed() const = 0;
};

/// In so many degrees of freedom.
template <int kDof>
class DriveTracker::CoreOf final : public Core {
 public:
  using Filter = DriveFilterOf<kDof>;
  CoreOf(const Deployment& deployment, const OdometryAccuracy& odometry, const TrackerOptions& options);

  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance) override;
  void move(const OdometryStep& step, double fraction) override;
  void locate(std::span<const Arrival> arrivals, Fix& fix) override;
  [[nodiscard]] bool is_placed() const override { return placed_; }
  [[nodiscard]] Pose pose() const override { return filter_.pose(); }
  [[nodiscard]] PoseCovariance covariance() const override { return filter_.covariance(); }

 private:
  void begin_window(double time_s);
  void keep_recent_half();
  void observe_all(std::span<const Arrival> arrivals);
  /// Tries to find the place from the window, if it is time to.
  void search();
  /// Starts a filter where the window's states, as they are solved, have its end.
  void start_at_end(Filter& filter);
  /// The same of the states as they are solved without a beacon. A filter that began with little known of
  /// its attitude instead would not be linear enough to judge another one.
  void start_without(BeaconId beacon, Filter& filter);
  [[nodiscard]] Segment window() const;

  EpochFixModel model_;
  CalibrationPart calibration_;
  TrackerOptions options_;
  OdometryAccuracy odometry_;
  TrajectoryModel trajectory_model_;
  Filter filter_;
  BeaconBankOf<kDof> bank_;
  NodeCalibration start_calibration_;  ///< how the place found follows the calibration
  bool placed_ = false;
  Trajectory t_;  ///< the stretch that the place is searched with; with a place: the instant alone
  std::vector<Node> with_all_;  ///< its nodes, while they are solved without a beacon
  double next_search_s_ = 0.0;  ///< span of the window at which to search
  OdometryStep row_;            ///< last row, and how long it took
  double row_s_ = 0.0;
  Scratch scratch_;
};

template <int kDof>
DriveTracker::CoreOf<kDof>::CoreOf(const Deployment& deployment, const OdometryAccuracy& odometry,
                                   const TrackerOptions& options)
    : model_(epoch_fix_model(deployment)),
      calibration_(deployment),
      options_(options),
      odometry_(odometry),
      trajectory_model_(trajectory_model(deployment)),
      filter_(model_, options.rejection_sigmas, options.range_uncertainty_m, &calibration_),
      bank_(model_, options.rejection_sigmas, options.range_uncertainty_m, &calibration_, options.protect),
      start_calibration_(filter_.node_calibration_room()),
      scratch_(kDriveScratchBytes) {
  t_.motion = Filter::kMotion;
  t_.moving = true;
  t_.turnaround_s = deployment.timing.turnaround_s;
  t_.nominal_speed_mps = model_.nominal_speed_mps;
  t_.nodes.reserve(kMaxNodes + 1);
  with_all_.reserve(kMaxNodes + 1);
  t_.odometry.reserve(kMaxNodes);
  t_.arrivals.reserve(kMaxArrivals);
  t_.T_hear_send.reserve(kMaxArrivals);
  begin_window(0.0);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::begin_window(double time_s) {
  t_.nodes.assign(1, {.time_s = time_s, .T_map_vehicle = {}});
  t_.odometry.clear();
  t_.arrivals.clear();
  t_.T_hear_send.clear();
  next_search_s_ = options_.start_window_s;
}

/// Forgets the older half of the window.
template <int kDof>
void DriveTracker::CoreOf<kDof>::keep_recent_half() {
  const std::size_t drop = t_.nodes.size() / 2;
  const auto head = [](auto& list, auto until) { list.erase(list.begin(), until); };
  head(t_.nodes, t_.nodes.begin() + static_cast<std::ptrdiff_t>(drop));
  head(t_.odometry, t_.odometry.begin() + static_cast<std::ptrdiff_t>(drop));
  head(t_.arrivals, t_.arrivals.begin() +
                        static_cast<std::ptrdiff_t>(first_of_node(t_.arrivals, drop, 0, t_.arrivals.size())));
  const std::int32_t first =
      t_.arrivals.empty() || t_.arrivals.front().hear_send < 0 ? 0 : t_.arrivals.front().hear_send;
  if (!t_.T_hear_send.empty()) head(t_.T_hear_send, t_.T_hear_send.begin() + first);
  for (OdometryObservation& o : t_.odometry) o.node -= drop;
  for (ArrivalObservation& a : t_.arrivals) {
    a.node -= drop;
    if (a.two_way) a.hear_send -= first;
  }
  next_search_s_ =
      std::min(next_search_s_, kFilterWindowGrowth * (t_.nodes.back().time_s - t_.nodes.front().time_s));
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::start(const Pose& T_map_vehicle, const PoseCovariance& covariance) {
  filter_.start(T_map_vehicle, covariance);
  filter_.set_range_uncertainty(options_.range_uncertainty_m);
  bank_.start();
  placed_ = true;
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::move(const OdometryStep& step, double fraction) {
  if (step.time_s != row_.time_s) {
    row_s_ = step.time_s - row_.time_s;
    row_ = step;
  }
  const OdometryObservation o = observation(t_.nodes.size() - 1, step, fraction, Filter::kMotion, odometry_);
  if (placed_) {
    filter_.predict(o.T_before_after, o, 1.0);
    bank_.predict(o.T_before_after, o, 1.0);
    return;
  }
  if (t_.nodes.size() >= kMaxNodes ||
      t_.nodes.back().time_s - t_.nodes.front().time_s > options_.max_start_window_s)
    keep_recent_half();
  t_.odometry.push_back(o);
  t_.odometry.back().node = t_.nodes.size() - 1;
  t_.nodes.push_back({.time_s = t_.nodes.back().time_s + fraction * row_s_, .T_map_vehicle = {}});
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::observe_all(std::span<const Arrival> arrivals) {
  const Pose row = step_of(row_, Filter::kMotion);
  for (const Arrival& a : arrivals) {
    if (t_.arrivals.size() == kMaxArrivals) keep_recent_half();
    ArrivalObservation o = observe(a, trajectory_model_, speed_of(a, trajectory_model_));
    o.node = t_.nodes.size() - 1;
    if (o.two_way) {
      // What it moved between asking and hearing, at the speed of the last row.
      o.hear_send = static_cast<std::int32_t>(t_.T_hear_send.size());
      t_.T_hear_send.push_back(
          row_s_ > 0 ? interpolate(Pose{}, row, std::min(a.tof_s / row_s_, 1.0)).inverse() : Pose());
    }
    o.rejection = model_.beacon_usable[a.beacon.index()] ? Rejection::kUsed : Rejection::kBeaconUnusable;
    t_.arrivals.push_back(o);
  }
}

template <int kDof>
Segment DriveTracker::CoreOf<kDof>::window() const {
  Segment all;
  all.last_node = t_.nodes.size();
  all.last_arrival = t_.arrivals.size();
  all.last_odometry = t_.odometry.size();
  return all;
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::search() {
  const double span_s = t_.nodes.back().time_s - t_.nodes.front().time_s;
  if (span_s < next_search_s_ || t_.nodes.size() < 2) return;
  next_search_s_ = kFilterWindowGrowth * span_s;
  const ScratchScope scope(scratch_);
  const Segment all = window();
  if (!place_stretch(t_, all, model_, options_)) return;
  start_at_end(filter_);
  const double uncertainty_m = independent_uncertainty_m(t_, all, model_, options_.range_uncertainty_m);
  filter_.set_range_uncertainty(uncertainty_m);
  bank_.start(filter_, t_, [this](BeaconId beacon, Filter& filter) { start_without(beacon, filter); });
  bank_.set_range_uncertainty(uncertainty_m);
  placed_ = true;
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::start_at_end(Filter& filter) {
  const Segment all = window();
  const std::size_t now = t_.nodes.size() - 1;
  const ChainFactor chain = factor_chain(t_, all, model_.state);
  if (chain.ok) node_calibration(t_, all, model_.state, chain, calibration_, now, start_calibration_);
  filter.start(t_.nodes[now].T_map_vehicle,
               start_covariance(t_, all, model_, options_.range_uncertainty_m, now),
               chain.ok ? &start_calibration_ : nullptr);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::start_without(BeaconId beacon, Filter& filter) {
  const ScratchScope scope(scratch_);
  with_all_ = t_.nodes;
  const Segment all = window();
  set_rejections(t_, all, beacon, Rejection::kUsed, Rejection::kBeaconFault);
  refine_stretch(t_, all, model_, options_.range_uncertainty_m);
  start_at_end(filter);
  set_rejections(t_, all, beacon, Rejection::kBeaconFault, Rejection::kUsed);
  t_.nodes = with_all_;
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::locate(std::span<const Arrival> arrivals, Fix& fix) {
  fix.time_s = arrivals.front().time_s;
  fix.vehicle = arrivals.front().vehicle;
  fix.status = FixStatus::kNoConsensus;
  fix.rejections.assign(arrivals.size(), Rejection::kNoPose);
  if (placed_) {
    begin_window(arrivals.front().time_s);
    observe_all(arrivals);
    for (std::size_t i = 0; i < arrivals.size(); ++i)
      fix.rejections[i] = bank_.update(filter_, t_, t_.arrivals[i]);
    placed_ = !filter_.is_lost();
    if (!placed_) begin_window(arrivals.front().time_s);
  } else {
    // The window's clock is the arrivals': rows bring but how long they took.
    const double late_s = arrivals.front().time_s - t_.nodes.back().time_s;
    for (Node& node : t_.nodes) node.time_s += late_s;
    observe_all(arrivals);
    search();
    for (std::size_t i = 0; placed_ && i < arrivals.size(); ++i)
      fix.rejections[i] =
          model_.beacon_usable[arrivals[i].beacon.index()] ? Rejection::kUsed : Rejection::kBeaconUnusable;
  }
  count_rejections(fix);
  if (!placed_) return;
  fix.status = FixStatus::kOk;
  fix.protection_level_m = bank_.protection_level_m(filter_);
  fix.T_map_vehicle = filter_.pose();
  fix.covariance = filter_.covariance();
}

DriveTracker::DriveTracker(const Deployment& deployment, const OdometryAccuracy& odometry,
                           const TrackerOptions& options)
    : Localizer(deployment) {
  if (deployment.motion == Motion::kPlanar) {
    core_ = std::make_unique<CoreOf<3>>(deployment, odometry, options);
  } else {
    core_ = std::make_unique<CoreOf<6>>(deployment, odometry, options);
  }
}

DriveTracker::~DriveTracker() = default;
DriveTracker::DriveTracker(DriveTracker&&) noexcept = default;
DriveTracker& DriveTracker::operator=(DriveTracker&&) noexcept = default;

void DriveTracker::start(const Pose& T_map_vehicle, const PoseCovariance& covariance) noexcept {
  core_->start(T_map_vehicle, covariance);
}

void DriveTracker::move(const OdometryStep& step, double fraction) noexcept { core_->move(step, fraction); }
bool DriveTracker::is_placed() const { return core_->is_placed(); }
Pose DriveTracker::pose() const { return core_->pose(); }
PoseCovariance DriveTracker::covariance() const { return core_->covariance(); }

void DriveTracker::locate_known(const Observations& observations, Fix& fix) noexcept {
  clear(fix);
  if (!observations.arrivals.empty()) core_->locate(observations.arrivals, fix);
}

}  // namespace octant

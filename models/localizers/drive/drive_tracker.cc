// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_tracker.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/common/calibration_part.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/beacon_bank.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/drive/drive_search.h"
#include "models/localizers/drive/loss_test.h"
#include "models/localizers/drive/motion_velocity.h"
#include "models/localizers/drive/odometry_queue.h"
#include "models/localizers/start/drive_start.h"
#include "models/localizers/start/stretch_states.h"
#include "models/physics/plane.h"
#include "models/support/scratch.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {
namespace {

constexpr std::size_t kInstantArrivals = 256;
/// Expected share of echoes.
constexpr double kEchoShare = 0.1;
/// Time during which a velocity is nearly constant in a search without odometry [s].
constexpr double kLasting_s = 0.25;
std::optional<MotionPrior> motion_of_only_vehicle(const Deployment& d) {
  return d.vehicles.empty() ? std::nullopt : d.vehicles.front().motion;
}

}  // namespace

class DriveTracker::Core {
 public:
  Core() = default;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  virtual ~Core() = default;
  virtual void start(const Pose& T_map_vehicle, const PoseCovariance& covariance,
                     const SpeedBelief& speed) = 0;
  virtual void advance_to(double time_s) = 0;
  virtual void locate(std::span<const Arrival> arrivals, Fix& fix) = 0;
  [[nodiscard]] virtual Pose pose() const = 0;
  [[nodiscard]] virtual PoseCovariance covariance() const = 0;
  [[nodiscard]] virtual Velocity velocity() const = 0;
  [[nodiscard]] virtual SpeedBelief speed() const = 0;
  [[nodiscard]] virtual SpeedBelief first_speed() const = 0;
  [[nodiscard]] virtual bool is_placed() const = 0;
  [[nodiscard]] virtual OdometryQueue& odometry() = 0;
  virtual void predict(double time_s, Fix& fix) = 0;
  std::function<void(const OdometryObservation*)> motion_sink;
};

/// Core with kDof degrees of freedom.
template <int kDof>
class DriveTracker::CoreOf final : public Core {
 public:
  using Filter = DriveFilterOf<kDof>;
  using Vector = typename Filter::Vector;
  CoreOf(const Deployment& deployment, const OdometryAccuracy& odometry, const TrackerOptions& options);

  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance, const SpeedBelief& speed) override;
  void advance_to(double time_s) override;
  void locate(std::span<const Arrival> arrivals, Fix& fix) override;
  [[nodiscard]] bool is_placed() const override { return placed_; }
  [[nodiscard]] Pose pose() const override { return filter_.pose(); }
  [[nodiscard]] PoseCovariance covariance() const override { return filter_.covariance(); }
  [[nodiscard]] Velocity velocity() const override { return velocity_of(filter_, odometry_).mean; }
  [[nodiscard]] SpeedBelief speed() const override { return filter_.speed(); }
  [[nodiscard]] SpeedBelief first_speed() const override {
    return {0.0, square(search_options_.air_sigma_mps)};
  }
  [[nodiscard]] OdometryQueue& odometry() override { return odometry_; }
  void predict(double time_s, Fix& fix) override;

 private:
  template <class Visit>
  void for_each_filter(Visit&& visit);
  [[nodiscard]] static VelocityEstimate velocity_of(const Filter& filter, const OdometryQueue& odometry);
  static void set_state(const Filter& filter, const OdometryQueue& odometry, Fix& fix);
  void begin_coasting(Filter& filter) const;
  void coast(Filter& filter, double span_s, double since_s) const;
  void step(Filter& filter, const MotionPart& part) const;
  void coast(double span_s, double since_s);
  void step(const MotionPart& part);
  void move_filters(const OdometryObservation& motion);
  void set_instant(std::span<const Arrival> arrivals);
  void correct(std::span<const Arrival> arrivals, Fix& fix);
  void use_arrivals(std::span<const Arrival> arrivals, Fix& fix);
  void lose();
  [[nodiscard]] bool is_blind() const {
    return !filter_.is_within(search_options_.most_place_m, kLinearTurn_rad);
  }
  void report(Fix& fix);

  EpochFixModel model_;
  CalibrationPart calibration_;
  TrackerOptions options_;
  TrajectoryModel trajectory_model_;
  DriveSearchOptions search_options_;
  OdometryQueue odometry_;
  Filter filter_;
  Filter ahead_;  ///< filter for predictions, with its odometry
  OdometryQueue odometry_ahead_;
  BeaconBankOf<kDof> bank_;
  LossTest loss_;
  bool placed_ = false;
  bool is_temperature_known_ = false;  ///< for the last arrival
  DriveSearchOf<kDof> search_;         ///< search while the pose is unknown or doubtful
  Trajectory instant_;                 ///< arrivals of one time
};

template <int kDof>
DriveTracker::CoreOf<kDof>::CoreOf(const Deployment& deployment, const OdometryAccuracy& odometry,
                                   const TrackerOptions& options)
    : model_(epoch_fix_model(deployment)),
      calibration_(deployment),
      options_(options),
      trajectory_model_(trajectory_model(deployment)),
      search_options_(drive_search_options(deployment, options)),
      odometry_(odometry, Filter::kMotion, motion_of_only_vehicle(deployment)),
      filter_(model_, options.rejection_sigmas, options.range_uncertainty_m, &calibration_),
      ahead_(filter_),
      odometry_ahead_(odometry_),
      bank_(model_, options.rejection_sigmas, options.range_uncertainty_m, &calibration_, options.protect),
      search_(model_, calibration_, drive_states(trajectory_model_, Filter::kMotion), search_options_) {
  static_cast<StateSpace&>(instant_) = search_.window().trajectory();
  instant_.nodes.resize(1);
  instant_.arrivals.reserve(kInstantArrivals);
  instant_.T_hear_send.reserve(kInstantArrivals);
  filter_.set_echo_share(kEchoShare);
  bank_.set_echo_share(kEchoShare);
}

template <int kDof>
template <class Visit>
void DriveTracker::CoreOf<kDof>::for_each_filter(Visit&& visit) {
  visit(filter_);
  bank_.for_each_filter(visit);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::start(const Pose& T_map_vehicle, const PoseCovariance& covariance,
                                       const SpeedBelief& speed) {
  filter_.start(T_map_vehicle, covariance);
  filter_.set_range_uncertainty(options_.range_uncertainty_m);
  filter_.set_speed(speed);
  bank_.start();
  loss_.clear();
  placed_ = true;
  if (!odometry_.has_rows()) begin_coasting(filter_);
}

template <int kDof>
VelocityEstimate DriveTracker::CoreOf<kDof>::velocity_of(const Filter& filter,
                                                         const OdometryQueue& odometry) {
  if (filter.is_coasting())
    return {in_space<kDof>(filter.velocity()), in_space<kDof>(filter.velocity_covariance().diagonal())};
  return {odometry.velocity(),
          in_space<kDof>(along_and_about<kDof>(odometry.speed_variance(), odometry.turn_rate_variance()))};
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::set_state(const Filter& filter, const OdometryQueue& odometry, Fix& fix) {
  fix.status = FixStatus::kOk;
  fix.T_map_vehicle = filter.pose();
  fix.covariance = filter.covariance();
  fix.velocity = velocity_of(filter, odometry);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::begin_coasting(Filter& filter) const {
  filter.begin_coasting(in_motion<kDof>(odometry_.velocity()),
                        along_and_about<kDof>(odometry_.speed_variance(), odometry_.turn_rate_variance()));
}

/// Predicts without odometry.
template <int kDof>
void DriveTracker::CoreOf<kDof>::coast(Filter& filter, double span_s, double since_s) const {
  if (!filter.is_coasting()) begin_coasting(filter);
  filter.coast(span_s, since_s, odometry_.limits());
  filter.pass_time(span_s);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::step(Filter& filter, const MotionPart& part) const {
  filter.end_coasting(in_motion<kDof>(part.velocity),
                      along_and_about<kDof>(part.speed_variance, part.turn_rate_variance));
  filter.pass_time(part.span_s);
  filter.predict(part.observation.T_before_after, part.observation, 1.0);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::coast(double span_s, double since_s) {
  if (motion_sink) motion_sink(nullptr);
  const MotionLimits& limits = odometry_.limits();
  OdometryObservation motion;
  // Bound on the motion by a velocity that lasts for that time.
  motion.distance_sigma_m = limits.speed_mps * std::sqrt(std::min(limits.speed_time_s, kLasting_s) * span_s);
  motion.heading_sigma_rad =
      limits.turn_rate_radps * std::sqrt(std::min(limits.turn_time_s, kLasting_s) * span_s);
  if (placed_) {
    const Pose before = filter_.pose();
    for_each_filter([&](Filter& filter) { coast(filter, span_s, since_s); });
    motion.T_before_after = before.inverse() * filter_.pose();
  }
  odometry_.remember(motion, span_s);
  search_.window().step(motion, span_s);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::step(const MotionPart& part) {
  if (motion_sink) motion_sink(&part.observation);
  if (placed_) for_each_filter([&](Filter& filter) { step(filter, part); });
  odometry_.remember(part.observation, part.span_s);
  search_.window().step(part.observation, part.span_s);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::predict(double time_s, Fix& fix) {
  if (!placed_) return;
  ahead_.copy_state(filter_);
  odometry_ahead_ = odometry_;
  odometry_ahead_.advance_to(
      time_s, [this](const MotionPart& part) { step(ahead_, part); },
      [this](double span_s, double since_s) { coast(ahead_, span_s, since_s); });
  set_state(ahead_, odometry_ahead_, fix);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::move_filters(const OdometryObservation& motion) {
  for_each_filter([&](Filter& filter) { filter.predict(motion.T_before_after, motion, 1.0); });
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::advance_to(double time_s) {
  if (!odometry_.has_begun()) odometry_.begin(time_s);
  const bool was_placed = placed_, was_blind = placed_ && is_blind();
  odometry_.advance_to(
      time_s, [this](const MotionPart& part) { step(part); },
      [this](double span_s, double since_s) { coast(span_s, since_s); });
  if (placed_ && !was_blind && is_blind()) lose();
  // Arrivals before a long gap are not informative about the pose after it.
  if (was_placed && !placed_) search_.begin(odometry_.now_s());
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::lose() {
  placed_ = false;
  loss_.clear();
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::set_instant(std::span<const Arrival> arrivals) {
  instant_.nodes.front().time_s = arrivals.front().time_s;
  instant_.arrivals.clear();
  instant_.T_hear_send.clear();
  for (const Arrival& a : arrivals) {
    ArrivalObservation o = observe(a, trajectory_model_, speed_of(a, trajectory_model_));
    if (o.two_way) {
      // Motion between transmission and reception.
      const Velocity v = a.tof_s * velocity();
      o.hear_send = static_cast<std::int32_t>(instant_.T_hear_send.size());
      instant_.T_hear_send.push_back(Pose{v.head<3>(), exp_rotation(v.tail<3>())}.inverse());
    }
    o.rejection = model_.beacon_usable[a.beacon.index()] ? Rejection::kUsed : Rejection::kBeaconUnusable;
    is_temperature_known_ = std::isfinite(a.temperature_degC);
    instant_.arrivals.push_back(o);
  }
}

/// Corrects the filters; for late arrivals at the state of their time.
template <int kDof>
void DriveTracker::CoreOf<kDof>::correct(std::span<const Arrival> arrivals, Fix& fix) {
  const double time_s = arrivals.front().time_s;
  const auto move = [this](const OdometryObservation& motion) { move_filters(motion); };
  odometry_.back_to(time_s, move);
  use_arrivals(arrivals, fix);
  odometry_.forward_from(time_s, move);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::use_arrivals(std::span<const Arrival> arrivals, Fix& fix) {
  const bool was_calm = loss_.is_calm();
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    fix.rejections[i] = bank_.update(filter_, instant_, instant_.arrivals[i]);
    if (is_by_residual(fix.rejections[i]))
      loss_.add(arrivals[i].beacon, arrivals[i].time_s, filter_.is_explained());
  }
  count_rejections(fix);
  if (was_calm) search_.begin(odometry_.now_s());
  search_.window().add(instant_);
  if (loss_.is_lost()) return lose();
  if (fix.arrivals_used == 0 || !loss_.is_calm()) return;
  report(fix);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::locate(std::span<const Arrival> arrivals, Fix& fix) {
  const double time_s = arrivals.front().time_s;
  fix.time_s = time_s;
  fix.vehicle = arrivals.front().vehicle;
  fix.status = FixStatus::kNoConsensus;
  fix.rejections.assign(arrivals.size(), Rejection::kNoPose);
  count_rejections(fix);
  advance_to(time_s);
  if (time_s < odometry_.oldest_s()) return;
  set_instant(arrivals);
  if (placed_) return correct(arrivals, fix);
  if (!search_.window().has_arrivals()) search_.begin(odometry_.now_s());
  search_.window().add(instant_);
  if (time_s < odometry_.now_s()) return;
  placed_ = search_.search(is_temperature_known_, filter_, bank_, ahead_);
  if (!placed_) return;
  loss_.clear();
  if (!odometry_.has_rows()) for_each_filter([this](Filter& filter) { begin_coasting(filter); });
  for (std::size_t i = 0; i < arrivals.size(); ++i)
    fix.rejections[i] =
        model_.beacon_usable[arrivals[i].beacon.index()] ? Rejection::kUsed : Rejection::kBeaconUnusable;
  count_rejections(fix);
  report(fix);
}

template <int kDof>
void DriveTracker::CoreOf<kDof>::report(Fix& fix) {
  fix.protection_level_m = bank_.protection_level_m(filter_);  // may replace the state of the filter
  set_state(filter_, odometry_, fix);
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
  core_->start(T_map_vehicle, covariance, core_->first_speed());
}

void DriveTracker::start(const DriveTracker& other, const PoseCovariance& widened_by) noexcept {
  core_->odometry() = other.core_->odometry();
  if (other.is_placed()) core_->start(other.pose(), other.covariance() + widened_by, other.core_->speed());
}

bool DriveTracker::move(const OdometryStep& row) noexcept { return core_->odometry().insert(row); }
bool DriveTracker::move(double time_s, const Pose& T_odometry_vehicle) noexcept {
  return core_->odometry().insert(time_s, T_odometry_vehicle);
}
bool DriveTracker::covers(double time_s) const { return core_->odometry().covers(time_s); }
bool DriveTracker::has_odometry() const { return core_->odometry().has_rows(); }
std::optional<double> DriveTracker::now_s() const {
  const OdometryQueue& odometry = core_->odometry();
  return odometry.has_begun() ? std::optional(odometry.now_s()) : std::nullopt;
}
double DriveTracker::oldest_s() const { return core_->odometry().oldest_s(); }
void DriveTracker::advance_to(double time_s) noexcept { core_->advance_to(time_s); }
void DriveTracker::set_motion_sink(std::function<void(const OdometryObservation*)> sink) {
  core_->motion_sink = std::move(sink);
}
void DriveTracker::predict(double time_s, Fix& fix) noexcept { core_->predict(time_s, fix); }
bool DriveTracker::is_placed() const { return core_->is_placed(); }
Pose DriveTracker::pose() const { return core_->pose(); }
PoseCovariance DriveTracker::covariance() const { return core_->covariance(); }
Eigen::Matrix<double, 6, 1> DriveTracker::velocity() const { return core_->velocity(); }
double DriveTracker::speed_offset_mps() const { return core_->speed().offset_mps; }

void DriveTracker::locate_known(const Observations& observations, Fix& fix) noexcept {
  clear(fix);
  if (!observations.arrivals.empty()) core_->locate(observations.arrivals, fix);
}

}  // namespace octant

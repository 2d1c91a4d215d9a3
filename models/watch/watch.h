// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"
#include "models/watch/change_evidence.h"
#include "models/watch/reception.h"
#include "models/watch/watched_pose.h"

namespace octant {

struct WatchOptions {
  double false_alarms_a_month = 0.1;  ///< largest rate without a fault; a month has 30 days of 24 hours
  /// Change of a path to detect [m]; half of it is tolerated. Default: a quarter of the deployment's
  /// tolerance.beacon_m, or 0.015 without a tolerance.
  std::optional<double> matter_m{};
  double speed_drift_mps_per_hour = 0.6;  ///< drift of the speed of sound: about one degree an hour
};

enum class WatchKind {
  kBeaconLate,   ///< its delay changed; size > 0: later
  kBeaconMoved,  ///< its position changed, along the axes of the map
  kBeaconSilent,
  kReceiverLate,
  kReceiverMoved  ///< along the axes of the vehicle
};

[[nodiscard]] const char* to_string(WatchKind kind);

/// A change that contradicts the deployment.
struct WatchAlarm {
  WatchKind kind = WatchKind::kBeaconLate;
  BeaconId beacon;      ///< not valid if it is a receiver
  ReceiverId receiver;  ///< not valid if it is a beacon
  int axis = 0;         ///< axis of the largest shift: 0, 1, 2 for x, y, z
  double size_m = 0.0;  ///< shift along that axis, or delay times speed; signed
  double sigma_m = 0.0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< shift of a beacon or receiver that moved
  double since_s = 0.0;                               ///< start of the data that show it
  double time_s = 0.0;                                ///< time of the alarm
};

/// Monitors beacons and the receivers of a vehicle during a drive for permanent changes: a beacon that was
/// hit, a replaced transducer, a bent receiver, a silent beacon. Allocates all memory at construction, throws
/// no exceptions, and takes some microseconds for each arrival.
///
/// A separate Kalman filter tracks the vehicle (WatchedPose). Its innovations are tested jointly for changes
/// of all beacons and receivers (ChangeEvidence), so that a change is not attributed to others. The drive is
/// divided into blocks of at least four seconds and two metres, which is longer than multipath is correlated;
/// a vehicle at rest provides little information. The member that explains the data best is reported when its
/// evidence meets the rate of false alarms and exceeds that of all others. From then on its arrivals are
/// ignored, and the others are tested without it.
///
/// The speed and, with epochs, a cycle offset are estimated too, so that a change of temperature is not
/// attributed to a beacon.
class Watch {
 public:
  /// @param vehicle  vehicle whose receivers are monitored
  explicit Watch(const Deployment& deployment, const WatchOptions& options = {},
                 VehicleId vehicle = VehicleId(0));

  /// The arrivals of one epoch and the fix that a localizer made of them (its pose and which arrivals it
  /// used). Without a fix only receptions count.
  std::optional<WatchAlarm> observe_epoch(std::span<const Arrival> arrivals, const Fix& fix) noexcept;

  /// For drives with synchronised clocks: call `start` when a localizer has a pose and `is_following` is
  /// false, `move` for each motion up to the next arrival, then `observe_arrival`.
  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance) noexcept;
  void stop() noexcept { following_ = false; }
  [[nodiscard]] bool is_following() const { return following_; }
  void move(const OdometryObservation& motion) noexcept;
  std::optional<WatchAlarm> observe_arrival(const Arrival& arrival) noexcept;

  /// Evidence of an alarm, in nats.
  [[nodiscard]] double threshold() const { return threshold_; }
  /// Returns true if it was reported as changed and is ignored since then.
  [[nodiscard]] bool is_out(BeaconId beacon) const {
    return beacon.valid() && beacon.index() < beacons_.size() && beacons_[beacon.index()].out;
  }
  [[nodiscard]] bool is_out(ReceiverId receiver) const {
    return receiver.valid() && receiver.index() < receivers_.size() && receivers_[receiver.index()].out;
  }
  /// Ignores a beacon that another vehicle reported.
  void leave_out(BeaconId beacon) noexcept;
  /// Estimated offset of the speed from the deployment's [m/s].
  [[nodiscard]] double speed_offset_mps() const { return pose_.speed_offset_mps(); }
  /// Resets everything, after a recalibration or a repair.
  void restart() noexcept;

 private:
  static constexpr std::size_t kNoMember = static_cast<std::size_t>(-1);
  struct Watched {
    bool usable = true, out = false;
    ChangeMatrix prior = ChangeMatrix::Identity();  ///< covariance without a change
    std::size_t member = kNoMember;                 ///< index in the joint test
    std::size_t received = 0;                       ///< number of its last arrival
    double last_s = -std::numeric_limits<double>::infinity();
  };
  /// Last residuals of a pair. If most of them agree, they are not echoes.
  struct Recent {
    static constexpr std::size_t kCount = 7;
    std::array<double, kCount> residual_m{};
    std::size_t count = 0;
    [[nodiscard]] bool agrees(double residual, double within_m) const;
  };
  struct Prediction {
    double residual_m = 0.0, variance_m2 = 0.0;
  };
  [[nodiscard]] bool is_watched(const Arrival& arrival) const;
  void watch_members(const Deployment& deployment);
  [[nodiscard]] std::size_t member_of(BeaconId beacon) noexcept;
  bool predict(const Arrival& arrival, Prediction& out) noexcept;
  void observe(const Arrival& arrival, bool may_correct) noexcept;
  void travel(double distance_m, double time_s) noexcept;
  std::optional<WatchAlarm> verdict(double time_s) noexcept;
  [[nodiscard]] WatchAlarm alarm_of(const FoundChange& change, double time_s) noexcept;

  Motion motion_;
  Medium medium_;
  Timing timing_;
  Noise noise_;
  CorrelatedNoise correlated_;
  SharedState state_;
  WatchOptions options_;
  double let_pass_m_, threshold_;
  double first_speed_variance_, last_speed_s_ = 0.0, epoch_s_ = 0.0, now_s_ = 0.0;
  double speed_degC_ = std::numeric_limits<double>::quiet_NaN(), speed_at_degC_mps_ = 0.0;
  std::vector<Watched> beacons_, receivers_;
  std::vector<BeaconId> beacon_of_member_;
  std::vector<ReceiverId> receiver_of_member_;
  std::vector<Recent> recent_;  ///< for each pair
  std::size_t arrivals_ = 0;
  ChangeEvidence evidence_;
  ReceptionWatch reception_;
  WatchedPose pose_;
  WatchedPose::Vector by_unknowns_ = WatchedPose::Vector::Zero();
  Eigen::VectorXd by_change_;
  bool following_ = false;
  double acceptance_ = 1.0;  ///< share of recent arrivals within the gate
  bool block_open_ = false;
  double block_begin_s_ = 0.0, block_way_m_ = 0.0, place_way_m_ = 0.0;
  std::optional<Eigen::Vector3d> last_place_m_;
};

}  // namespace octant

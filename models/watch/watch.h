// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

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
#include "models/watch/cusum.h"

namespace octant {

struct WatchOptions {
  double false_alarms_a_month = 0.1;  ///< at most, of all charts together, while nothing is wrong
  double fixes_per_s =
      1.0;  ///< epochs, or single arrivals of a drive, that are observed; a month has 30 days of 24 hours
  /// Change of a path that is to be found [m]; half of it is let pass as what calibrations and multipath
  /// leave. None: the deployment's tolerance.beacon_m, and 0.03 where it has none.
  std::optional<double> matter_m{};
  double clip_sigmas =
      3.0;  ///< residuals count up to what matters and this, so that a lone echo moves no chart by much
  double least_steps = 20.0;  ///< that an alarm takes, so that some echoes in a row, which no normal
                              ///< distribution foresees, give none
  double speed_drift_mps_per_hour = 0.6;  ///< how fast the air may change: a degree an hour
};

enum class WatchKind {
  kBeaconLate,   ///< its delay is another one; size > 0: later
  kBeaconMoved,  ///< it stands elsewhere, along an axis of the map
  kReceiverLate,
  kReceiverMoved  ///< along an axis of the vehicle
};

/// What no longer fits the deployment.
struct WatchAlarm {
  WatchKind kind = WatchKind::kBeaconLate;
  BeaconId beacon;      ///< of the first two kinds
  ReceiverId receiver;  ///< of the others
  int axis = 0;         ///< of a move: x, y, z
  double size_m =
      0.0;  ///< with its sign, mean since the change was first seen; of a lateness times the speed
  double sigma_m = 0.0;  ///< of that mean, by the noise alone
  double since_s = 0.0;  ///< when the chart left zero
  double time_s = 0.0;   ///< of the alarm
};

/// Watches beacons and receivers while a robot drives, from the residuals of each arrival against the fix of
/// all others, for changes that came to stay: a ladder hit a beacon, a transducer was replaced, a receiver is
/// bent. For a robot's own program: it stands on models alone, takes all memory at construction, throws
/// nothing, and costs well below a microsecond an arrival.
///
/// With v the residuals after the fix, P their weights, Q_v their cofactors, and c what a change by one metre
/// does to each arrival, the change's score and information (W. Baarda, A testing procedure for use in
/// geodetic networks, 1968) are
///   s = c' P v,   I = c' P Q_v P c = c' P c - c' P H N^-1 H' P c,   s ~ N(b I, I) for a change by b metres,
/// so that the fix of all others need not be made. Each chart adds the log likelihood ratio of b = beta +
/// delta against all |b| <= beta,
///   g = min(delta (s - beta I) - delta^2 I / 2, h / least_steps),   S <- max(0, S + g),   alarm at S > h,
/// once with either sign: Page's test. As E exp(g) <= 1 without a change, an alarm of one chart comes no
/// sooner than exp(h) steps on average (G. Lorden, Annals of Mathematical Statistics 42, 1971), and h =
/// ln(charts steps_a_month / false_alarms_a_month) keeps the stated rate: an upper bound, the true one is
/// some ten times lower. beta is half of what matters, or two sigmas of what the deployment leaves open of
/// the beacon; errors that last (noise.correlated) widen the sigmas by how many arrivals share them.
///
/// The speed is followed along, with the sigma that the deployment states and a slow drift, so that warm air
/// accuses no beacon. When a chart alarms the likeliest of all charts is told, its beacon or receiver is left
/// out from then on, and all charts begin anew.
class Watch {
 public:
  explicit Watch(const Deployment& deployment, const WatchOptions& options = {});

  /// The arrivals of one epoch and the fix that a localizer made of them (its pose and which arrivals it
  /// used). Nothing happens without a fix, or with fewer arrivals than unknowns.
  std::optional<WatchAlarm> observe_epoch(std::span<const Arrival> arrivals, const Fix& fix) noexcept;
  /// One arrival of a drive, and where the vehicle was by all that came before it: pose and covariance of a
  /// filter's prediction.
  std::optional<WatchAlarm> observe_arrival(const Arrival& arrival, const Pose& T_map_vehicle,
                                            const PoseCovariance& covariance) noexcept;

  /// h, in nats.
  [[nodiscard]] double threshold() const { return threshold_; }
  [[nodiscard]] std::size_t charts() const { return charts_.size(); }
  /// Told as changed, and left out since.
  [[nodiscard]] bool is_out(BeaconId beacon) const {
    return beacon.valid() && beacon.index() < beacons_.size() && beacons_[beacon.index()].out;
  }
  [[nodiscard]] bool is_out(ReceiverId receiver) const {
    return receiver.valid() && receiver.index() < receivers_.size() && receivers_[receiver.index()].out;
  }
  /// What the air is faster than the deployment says, as followed along [m/s].
  [[nodiscard]] double speed_offset_mps() const { return speed_offset_mps_; }
  /// All charts at zero, everything in use: after a recalibration or a repair.
  void restart() noexcept;

 private:
  static constexpr int kMostUnknowns = 8;  ///< spatial pose, cycle offset, speed
  static constexpr int kSignatures = 4;    ///< late, moved along x, y, z
  using Unknowns = Eigen::Matrix<double, kMostUnknowns, 1>;
  using Signature = Eigen::Matrix<double, kSignatures, 1>;

  /// An arrival, in metres.
  struct Row {
    BeaconId beacon;
    ReceiverId receiver;
    bool used = false;  ///< by the fix
    double residual_m = 0.0, weight = 0.0;
    Unknowns by_unknowns = Unknowns::Zero();
    Signature by_beacon = Signature::Zero(), by_receiver = Signature::Zero();
  };
  /// What the arrivals of one beacon or receiver say of its four changes, those that the fix used and those
  /// that it left out.
  struct Sums {
    Signature score = Signature::Zero();
    Eigen::Matrix<double, kSignatures, kSignatures> information =
        Eigen::Matrix<double, kSignatures, kSignatures>::Zero();
    Eigen::Matrix<double, kMostUnknowns, kSignatures> by_unknowns =
        Eigen::Matrix<double, kMostUnknowns, kSignatures>::Zero();
    bool any = false;
  };
  struct Member {
    bool usable = true, out = false;
    double beta_m = 0.0;  ///< range error that is let pass
    double last_s = -std::numeric_limits<double>::infinity();
    std::size_t first_chart = 0;
    Sums used, left_out;
  };
  /// One change, one sign.
  struct Chart {
    WatchKind kind = WatchKind::kBeaconLate;
    std::size_t member = 0;
    int signature = 0;
    double sign = 1.0;
    CumulativeSum sum{};
    double score = 0.0, information = 0.0, since_s = 0.0;
  };

  static void forget(Chart& chart) noexcept;
  void add_charts(std::vector<Member>& members, WatchKind late, WatchKind moved);
  [[nodiscard]] bool predict(const Arrival& arrival, const Pose& T_map_vehicle, bool used, Row& row) noexcept;
  void gather(const Row& row) noexcept;
  [[nodiscard]] double limit_of(const Row& row, double variance_m2) const noexcept;
  void clip_and_gather() noexcept;
  void update(Member& member, double time_s) noexcept;
  /// @param score, information, cross  of the member's changes; cross: with its lateness
  void advance_charts(Member& member, const Signature& score, const Signature& information,
                      const Signature& cross, double time_s) noexcept;
  void advance(Chart& chart, double score, double information, double cross, double beta_m,
               double time_s) noexcept;
  [[nodiscard]] std::optional<WatchAlarm> verdict(double time_s) noexcept;
  void follow_speed(double offset_mps, double variance) noexcept;
  void let_speed_drift(double time_s) noexcept;

  Motion motion_;
  Medium medium_;
  Timing timing_;
  Noise noise_;
  CorrelatedNoise correlated_;
  SharedState state_;
  WatchOptions options_;
  double matter_m_ = 0.03;
  double threshold_ = 0.0;
  int pose_unknowns_ = 3, unknowns_ = 3;
  int offset_column_ = -1, speed_column_ = -1;
  double speed_offset_mps_ = 0.0, speed_variance_ = 0.0, first_speed_variance_ = 0.0, last_speed_s_ = 0.0;
  double epoch_s_ = 0.0;  ///< from which a clock's drift counts
  double speed_degC_ = std::numeric_limits<double>::quiet_NaN(), speed_at_degC_mps_ = 0.0;
  bool alarmed_ = false;
  std::vector<Member> beacons_, receivers_;
  std::vector<Chart> charts_;
  std::vector<Row> rows_;
  std::size_t row_count_ = 0;
  Eigen::Matrix<double, kMostUnknowns, kMostUnknowns> inverse_ =
      Eigen::Matrix<double, kMostUnknowns, kMostUnknowns>::Zero();
};

}  // namespace octant

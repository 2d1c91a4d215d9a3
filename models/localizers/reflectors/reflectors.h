// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/common/separation.h"
#include "models/localizers/reflectors/resection.h"
#include "models/support/result.h"

namespace octant {

struct ReflectorsOptions {
  std::optional<double> bearing_sigma_rad{};                 ///< default: the deployment's
  double range_m = std::numeric_limits<double>::infinity();  ///< maximum distance of a reflector
  double gate_sigmas = 4.0;  ///< largest deviation of a bearing from its reflector
  double max_sigma_m = 1.0;  ///< horizontal sigmas above this are poor geometry
  /// A second pose is equally good if its log likelihood is within this margin of the best (2: odds of seven
  /// to one).
  double ambiguity_margin = 2.0;
  int max_hypotheses = 20000;  ///< number of poses tried in a search, which bounds its time
  /// Speed and turn rate by which the vehicle may leave its last fix. 0: the last fix is not used.
  double speed_mps = 1.0;
  double turn_rate_radps = 1.0;
};

/// Checks the reflectors of a deployment. The error states what it lacks.
[[nodiscard]] Result<void> reflectors_fits(const Deployment& deployment);

/// Pose from bearings to reflectors (Smieszek, Dobrzanska and Dobrzanski, "Laser navigation applications for
/// automated guided vehicles", section 2: triangulation). The beacons of the deployment are the reflectors.
/// Bearings are measured at the vehicle's origin; an unlabelled bearing may belong to any reflector.
///
/// Triples of bearings give poses in closed form (`resect`). Unlabelled bearings are tried under every
/// assignment, up to max_hypotheses. Assignments that give no bearing a reflector named by another one come
/// first, the others only if no pose explains all bearings. Each bearing is explained by its nearest
/// reflector, at most at the cost of an outlier. The best poses are adjusted by least squares, and the best
/// result is the fix. The last fix, or `predict`, is a further candidate. With the known motion it acts as a
/// prior, so it decides between poses that the bearings cannot distinguish.
///
/// No fix: kTooFewArrivals with fewer than three bearings; kPoorGeometry on the danger circle or with a sigma
/// above max_sigma_m; kAmbiguous if another pose explains the bearings equally well; kNoConsensus if fewer
/// than three bearings agree, or just three that are not all labelled. The covariance includes the noise of
/// the bearings and the uncertainty of the reflectors. A fix of four or more bearings has a protection level
/// (separation.h), valid for an arbitrary error of one reflector or its identification.
class Reflectors : public Localizer {
 public:
  explicit Reflectors(const Deployment& deployment, const ReflectorsOptions& options = {});

  /// Sets the expected pose at the next `locate`, for example from odometry, instead of the one derived from
  /// the last fix.
  void predict(const Pose& T_map_vehicle, double sigma_m, double sigma_rad) noexcept;

 private:
  /// Uses the first 64 bearings. There is one rejection for each bearing.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  struct Reflector {
    Eigen::Vector2d p_map_m;
    Eigen::Matrix2d covariance_m2;
    BeaconId beacon;
  };
  /// A pose with its cost (negative log likelihood of the bearings, without constants).
  struct Hypothesis {
    ResectedPose pose;
    double cost = std::numeric_limits<double>::infinity();
  };
  struct Prediction {
    ResectedPose pose;
    double sigma_m = 0.0, sigma_rad = 0.0;
    [[nodiscard]] double cost(const ResectedPose& at, double gate_sigmas) const;
    /// True if it is accurate enough to replace a search.
    [[nodiscard]] bool is_tight() const { return sigma_m < 0.5 && sigma_rad < 0.3; }
  };
  static constexpr std::size_t kBest = 8, kSearched = 12, kMaxBearings = 64;

  void begin(const Observations& observations, Fix& fix) noexcept;
  void search(std::span<const Bearing> bearings) noexcept;
  void try_triples(std::span<const Bearing> bearings, std::span<const std::size_t> order,
                   bool of_others) noexcept;
  void try_triple(std::span<const Bearing> bearings, const std::array<std::size_t, 3>& triple,
                  bool of_others) noexcept;
  bool explains_all(std::span<const Bearing> bearings) noexcept;
  Hypothesis& rival_of(const ResectedPose& pose) noexcept;
  void keep(const Hypothesis& hypothesis, Hypothesis& rival) noexcept;
  double explain(const ResectedPose& pose, std::span<const Bearing> bearings,
                 double bound = std::numeric_limits<double>::infinity()) noexcept;
  bool refine(Hypothesis& hypothesis, std::span<const Bearing> bearings,
              Eigen::Matrix3d& information) noexcept;
  FixStatus judge(std::span<const Bearing> bearings, Hypothesis& best, Eigen::Matrix3d& information) noexcept;
  void predict_sight(std::size_t reflector, const ResectedPose& from) noexcept;
  [[nodiscard]] double off_rad(const ResectedPose& pose, std::size_t bearing,
                               const Eigen::Vector2d& sight_m) const noexcept;
  [[nodiscard]] double variance(const Reflector& reflector, const Eigen::Vector2d& sight_m) const noexcept;
  void protect(const ResectedPose& pose, std::span<const Bearing> bearings, Fix& fix) noexcept;

  ReflectorsOptions options_;
  std::vector<Reflector> reflectors_;
  std::vector<int> index_;  ///< index of each beacon in reflectors_; -1: unusable
  double sigma_rad_ = 0.01;
  std::optional<Prediction> prediction_, given_;
  std::optional<double> last_fix_s_;
  ResectedPose last_;
  Eigen::Vector2d last_sigma_ = Eigen::Vector2d::Zero();  ///< m, rad
  // Memory of a search.
  std::array<Hypothesis, kBest> best_;
  int tried_ = 0;
  std::vector<int> match_;               ///< reflector of each bearing, or -1
  std::vector<Eigen::Vector2d> sights_;  ///< unit vector of each bearing in the vehicle frame
  /// A reflector as seen from the tested pose.
  struct Seen {
    Eigen::Vector2d sight_m;  ///< in the vehicle frame
    double variance = 0.0;    ///< variance of its bearing; 0: not computed yet
    bool used = false;        ///< or out of range
  };
  std::vector<Seen> seen_;
  std::vector<char> named_;  ///< true for reflectors that a bearing names
  BeaconSums sums_;
};

}  // namespace octant

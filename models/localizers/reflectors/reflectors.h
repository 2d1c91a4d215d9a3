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
  std::optional<double> bearing_sigma_rad{};                 ///< not given: the deployment's
  double range_m = std::numeric_limits<double>::infinity();  ///< beyond it a reflector is not seen
  double gate_sigmas = 4.0;  ///< a bearing further off is not of that reflector
  double max_sigma_m = 1.0;  ///< a horizontal sigma beyond this is poor geometry
  /// A second pose counts as equally good when its log likelihood is within this of the best (2: odds of
  /// seven to one).
  double ambiguity_margin = 2.0;
  int max_hypotheses = 20000;  ///< poses tried in a search; bounds its time
  /// What the last fix says of the next: how fast the vehicle moves and turns. 0: nothing.
  double speed_mps = 1.0;
  double turn_rate_radps = 1.0;
};

/// Which reflectors there must be: errors say what the deployment lacks.
[[nodiscard]] Result<void> reflectors_fits(const Deployment& deployment);

/// Pose from bearings to reflectors (Smieszek, Dobrzanska and Dobrzanski, "Laser navigation applications for
/// automated guided vehicles", section 2: triangulation). The deployment's beacons are the reflectors;
/// bearings are taken at the vehicle frame's origin; a bearing without a reflector's name may be of any.
///
/// Triples of bearings give poses in closed form (`resect`), for unlabelled bearings under every assignment,
/// until max_hypotheses are tried: first those that give no bearing a reflector which another names, then,
/// unless a pose was found that explains all, the others. The poses that explain all bearings best, each
/// bearing by its nearest reflector and at most at the price of an outlier, are adjusted by least squares;
/// the best is the fix. The last fix, or `predict`, is one more pose to try and weighs in with what is known
/// of the motion, so that it decides between poses that the bearings cannot tell apart.
///
/// No fix: kTooFewArrivals under three bearings; kPoorGeometry on the danger circle or with a sigma beyond
/// max_sigma_m; kAmbiguous where another pose explains the bearings as well; kNoConsensus where fewer than
/// three bearings agree, or three alone and not all of them labelled. The covariance is that of the bearings'
/// noise and of the reflectors' own. A fix of four bearings or more has a protection level (separation.h):
/// one reflector, or what was taken for it, may be off by anything.
class Reflectors : public Localizer {
 public:
  explicit Reflectors(const Deployment& deployment, const ReflectorsOptions& options = {});

  /// Where the vehicle is at the next `locate`, as odometry has it; instead of what follows from the last
  /// fix.
  void predict(const Pose& T_map_vehicle, double sigma_m, double sigma_rad) noexcept;

 private:
  /// Bearings beyond the first 64 are not used. Rejections are one for each bearing.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  struct Reflector {
    Eigen::Vector2d p_map_m;
    Eigen::Matrix2d covariance_m2;
    BeaconId beacon;
  };
  /// A pose, and how far it is from explaining the bearings (minus log likelihood, without constants).
  struct Hypothesis {
    ResectedPose pose;
    double cost = std::numeric_limits<double>::infinity();
  };
  struct Prediction {
    ResectedPose pose;
    double sigma_m = 0.0, sigma_rad = 0.0;
    [[nodiscard]] double cost(const ResectedPose& at, double gate_sigmas) const;
    /// Whether it may stand in for a search.
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
  std::vector<int> index_;  ///< of each beacon in reflectors_; -1: unusable
  double sigma_rad_ = 0.01;
  std::optional<Prediction> prediction_, given_;
  std::optional<double> last_fix_s_;
  ResectedPose last_;
  Eigen::Vector2d last_sigma_ = Eigen::Vector2d::Zero();  ///< m, rad
  // Room for a search.
  std::array<Hypothesis, kBest> best_;
  int tried_ = 0;
  std::vector<int> match_;               ///< of each bearing: reflector, or -1
  std::vector<Eigen::Vector2d> sights_;  ///< of each bearing: unit vector in the vehicle frame
  /// A reflector from the pose under test.
  struct Seen {
    Eigen::Vector2d sight_m;  ///< in the vehicle frame
    double variance = 0.0;    ///< of its bearing; 0: nobody looked yet
    bool used = false;        ///< or out of range
  };
  std::vector<Seen> seen_;
  std::vector<char> named_;  ///< of each reflector: by a bearing
  BeaconSums sums_;
};

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace octant {

/// Change of a member (a beacon or a receiver): a delay as a length, and a displacement along three axes [m].
using ChangeVector = Eigen::Matrix<double, 4, 1>;
using ChangeMatrix = Eigen::Matrix<double, 4, 4>;

/// Form of a member's change: its delay or its position.
enum class ChangeForm { kLate, kMoved };
inline constexpr ChangeForm kChangeForms[] = {ChangeForm::kLate, ChangeForm::kMoved};

struct FoundChange {
  std::size_t member = 0;
  ChangeForm form = ChangeForm::kLate;
  ChangeVector size_m = ChangeVector::Zero();         ///< joint estimate
  ChangeMatrix covariance_m2 = ChangeMatrix::Zero();  ///< for the errors that the blocks show
  double since_s = 0.0;                               ///< start of the first block with the change
};

/// Joint test for changes of beacons and receivers (A. S. Willsky and H. L. Jones, A generalized likelihood
/// ratio approach to the detection and estimation of jumps in linear systems, 1976), with priors.
///
/// An innovation nu with variance S depends on the errors theta of all members: nu = g' theta + noise. Sums
/// over a block of the drive are N = sum g g' / S and s = sum g nu / S. Theta has the covariance of the
/// calibration, so errors of one member are not attributed to another one. A hypothesis adds a change of one
/// member from a block on. Its evidence is the logarithm of the marginal likelihood ratio:
///   u' (V + D)^-1 u / 2 - ln det(1 + D^-1 V) / 2,   u = s_h - N_h' theta,   V = N_hh - N_h' C N_h
/// with theta and C the estimate and covariance without a change, s_h, N_h the sums from that block on, and D
/// the information of the prior of a change.
///
/// Errors that depend on the place (multipath) are not white noise. Blocks are longer than their correlation
/// length, so the residual sums of the blocks show by what factor the variance of s exceeds N. N and s are
/// divided by this factor, and the evidence is that of Student's distribution with as many degrees of freedom
/// as blocks.
class ChangeEvidence {
 public:
  /// @param beacons  number of members that are beacons; they come before the receivers
  /// @param threshold  evidence of an alarm
  /// @param least_m  largest change that is tolerated
  ChangeEvidence(std::size_t beacons, std::size_t receivers, double threshold, double least_m);

  [[nodiscard]] std::size_t columns() const { return 4 * priors_.size(); }
  /// Covariance of the member's theta.
  void set_prior(std::size_t member, const ChangeMatrix& covariance_m2);
  /// Forgets the sums that concern a member.
  void forget(std::size_t member);
  void restart();

  void add(const Eigen::VectorXd& by_theta, double innovation_m, double variance_m2);
  void begin_block(double time_s);
  /// Ends the block, after which the test of the last blocks is due. Not to be called during a test.
  void end_block() noexcept;
  [[nodiscard]] bool is_testing() const { return step_ > 0; }
  /// Does the next step of the test, if one is due: some tenths of a millisecond. Returns a change after the
  /// last step.
  [[nodiscard]] std::optional<FoundChange> evaluate();

 private:
  static constexpr std::size_t kBlocks = 25;  ///< including the current block
  struct Block {
    Eigen::MatrixXd N;  ///< lower triangle
    Eigen::VectorXd s;
    double begin_s = 0.0;
  };
  struct Candidate {
    FoundChange change;
    double evidence = 0.0;
    double other_form = 0.0;  ///< evidence of the other form
    std::size_t blocks = 0;   ///< number of blocks with the change
  };
  /// u and V of a member.
  struct Score {
    ChangeVector u;
    ChangeMatrix V;
  };
  [[nodiscard]] const Block& recent(std::size_t age) const {
    return blocks_[(newest_ + kBlocks - age) % kBlocks];
  }
  [[nodiscard]] static Eigen::Index first_column(std::size_t member) {
    return static_cast<Eigen::Index>(4 * member);
  }
  [[nodiscard]] bool is_tested(std::size_t member) const {
    return N_(first_column(member), first_column(member)) > 0.0;
  }
  void solve();
  void sum_since(std::size_t blocks);
  void compare(std::size_t blocks);
  [[nodiscard]] Score score_of(std::size_t member);
  [[nodiscard]] static Candidate candidate_of(const Score& score, ChangeForm form);
  [[nodiscard]] Candidate best_form(std::size_t member);
  void find_residuals(const FoundChange& change);
  [[nodiscard]] double inflation_of(std::size_t member);
  [[nodiscard]] double typical_inflation(std::size_t accused);
  [[nodiscard]] std::optional<FoundChange> decide();

  std::size_t beacons_;
  double threshold_, least_m_;
  std::vector<ChangeMatrix> priors_;  ///< information of each member
  std::vector<Block> blocks_;
  std::size_t newest_ = 0, filled_ = 0, step_ = 0, summed_ = 0;
  std::size_t suspect_ = 0, confirmed_ = 0;  ///< member of the last test, and the sum of its tests
  double inflation_ = 1.0;
  Candidate best_;
  double rival_evidence_ = 0.0;     ///< evidence of the best other member
  Eigen::MatrixXd N_, covariance_;  ///< sums of all blocks
  Eigen::MatrixXd N_since_;         ///< sums of the blocks with the change
  Eigen::VectorXd s_, s_since_, estimate_, theta_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> product_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd residuals_;  ///< for each block, by its age
  std::vector<double> inflations_;
};

}  // namespace octant

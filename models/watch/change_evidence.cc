// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/change_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octant {
namespace {

/// Least total number of blocks for a test; they show the errors that depend on the place.
constexpr std::size_t kLeastBlocks = 6;
/// Prior sigma of a change along each axis [m].
constexpr double kChanged_m = 0.2;
/// Log-likelihood ratio between the suspect and any other member (one in a thousand), and between the forms
/// of the change (one in twenty).
constexpr double kMemberMargin = 7.0, kFormMargin = 3.0;
/// Sum of the tests of a member (+1 with a change, -1 without, not below zero) at which it is reported, so
/// that its blocks outweigh the earlier ones; and the sum if its form remains unclear.
constexpr std::size_t kConfirm = 5, kWaitForForm = 9;

/// Evidence and estimate for a change along `k` of the four columns.
template <int k>
double evidence(const Eigen::Matrix<double, k, 1>& u, const Eigen::Matrix<double, k, k>& V,
                Eigen::Matrix<double, k, 1>& size_m, Eigen::Matrix<double, k, k>& covariance_m2) {
  constexpr double kPrior = 1.0 / (kChanged_m * kChanged_m);
  const Eigen::LLT<Eigen::Matrix<double, k, k>> factor(V + kPrior * Eigen::Matrix<double, k, k>::Identity());
  size_m = factor.solve(u);
  covariance_m2 = factor.solve(Eigen::Matrix<double, k, k>::Identity());
  const Eigen::Matrix<double, k, k> L = factor.matrixL();
  return 0.5 * u.dot(size_m) - L.diagonal().array().log().sum() + 0.5 * k * std::log(kPrior);
}

/// Size of a change under a prior of `least_m` along each axis. Components that the arrivals do not determine
/// that well do not count. @param weight  factor on the information
double certain_size_m(const FoundChange& change, double weight, double least_m) {
  const ChangeMatrix prior = least_m * least_m * ChangeMatrix::Identity();
  return (prior * ChangeMatrix(prior + change.covariance_m2 / weight).llt().solve(change.size_m)).norm();
}

}  // namespace

ChangeEvidence::ChangeEvidence(std::size_t beacons, std::size_t receivers, double threshold, double least_m)
    : beacons_(beacons),
      threshold_(threshold),
      least_m_(least_m),
      priors_(beacons + receivers, ChangeMatrix::Identity()),
      blocks_(kBlocks) {
  const auto n = static_cast<Eigen::Index>(columns());
  for (Block& block : blocks_) {
    block.N.setZero(n, n);
    block.s.setZero(n);
  }
  for (Eigen::MatrixXd* matrix : {&N_, &covariance_, &N_since_}) matrix->setZero(n, n);
  for (Eigen::VectorXd* vector : {&s_, &s_since_, &estimate_, &theta_}) vector->setZero(n);
  product_.setZero(n, 4);
  residuals_.setZero(n, kBlocks);
  factor_ = Eigen::LLT<Eigen::MatrixXd>(n);
  inflations_.reserve(priors_.size());
}

void ChangeEvidence::set_prior(std::size_t member, const ChangeMatrix& covariance_m2) {
  priors_[member] = Eigen::LLT<ChangeMatrix>(covariance_m2).solve(ChangeMatrix::Identity());
}

void ChangeEvidence::forget(std::size_t member) {
  for (Block& block : blocks_) {
    block.N.middleRows<4>(first_column(member)).setZero();
    block.N.middleCols<4>(first_column(member)).setZero();
    block.s.segment<4>(first_column(member)).setZero();
  }
}

void ChangeEvidence::restart() {
  filled_ = step_ = confirmed_ = 0;
  inflation_ = 1.0;
  begin_block(0.0);
}

void ChangeEvidence::add(const Eigen::VectorXd& by_theta, double innovation_m, double variance_m2) {
  Block& block = blocks_[newest_];
  block.N.selfadjointView<Eigen::Lower>().rankUpdate(by_theta, 1.0 / variance_m2);
  block.s += innovation_m / variance_m2 * by_theta;
}

void ChangeEvidence::begin_block(double time_s) {
  Block& block = blocks_[newest_];
  block.N.setZero();
  block.s.setZero();
  block.begin_s = time_s;
}

void ChangeEvidence::end_block() noexcept {
  filled_ = std::min(filled_ + 1, kBlocks - 1);
  newest_ = (newest_ + 1) % kBlocks;
  if (filled_ >= kLeastBlocks) step_ = 1;
}

std::optional<FoundChange> ChangeEvidence::evaluate() {
  if (step_ == 0) return std::nullopt;
  const std::size_t at = step_++;
  if (at == 1) {
    solve();
  } else if (at <= filled_) {
    compare(at);
  } else {
    step_ = 0;
    return decide();
  }
  return std::nullopt;
}

/// Estimates theta without a change.
void ChangeEvidence::solve() {
  N_.setZero();
  s_.setZero();
  for (std::size_t age = 1; age <= filled_; ++age) {
    N_ += recent(age).N;
    s_ += recent(age).s;
  }
  covariance_ = N_ / inflation_;
  for (std::size_t m = 0; m < priors_.size(); ++m)
    covariance_.block<4, 4>(first_column(m), first_column(m)) += priors_[m];
  factor_.compute(covariance_);
  covariance_.setIdentity();
  factor_.solveInPlace(covariance_);
  estimate_.noalias() = covariance_ * s_ / inflation_;
  best_ = Candidate{};
  rival_evidence_ = 0.0;
  N_since_.setZero();
  s_since_.setZero();
  summed_ = 0;
}

ChangeEvidence::Score ChangeEvidence::score_of(std::size_t member) {
  const auto N = N_since_.middleCols<4>(first_column(member));
  product_.noalias() = covariance_ * N;
  Score score;
  score.u = (s_since_.segment<4>(first_column(member)) - N.transpose() * estimate_) / inflation_;
  score.V = N.middleRows<4>(first_column(member)) / inflation_ -
            N.transpose() * product_ / (inflation_ * inflation_);
  return score;
}

ChangeEvidence::Candidate ChangeEvidence::candidate_of(const Score& score, ChangeForm form) {
  Candidate out;
  out.change.form = form;
  if (form == ChangeForm::kLate) {
    Eigen::Matrix<double, 1, 1> size, covariance;
    out.evidence = evidence<1>(score.u.head<1>(), score.V.topLeftCorner<1, 1>(), size, covariance);
    out.change.size_m[0] = size[0];
    out.change.covariance_m2(0, 0) = covariance(0, 0);
  } else {
    Eigen::Vector3d size;
    Eigen::Matrix3d covariance;
    out.evidence = evidence<3>(score.u.tail<3>(), score.V.bottomRightCorner<3, 3>(), size, covariance);
    out.change.size_m.tail<3>() = size;
    out.change.covariance_m2.bottomRightCorner<3, 3>() = covariance;
  }
  return out;
}

void ChangeEvidence::sum_since(std::size_t blocks) {
  if (blocks < summed_) {
    N_since_.setZero();
    s_since_.setZero();
    summed_ = 0;
  }
  for (; summed_ < blocks; ++summed_) {
    N_since_.triangularView<Eigen::Lower>() += recent(summed_ + 1).N;
    s_since_ += recent(summed_ + 1).s;
  }
  N_since_.triangularView<Eigen::StrictlyUpper>() = N_since_.transpose();
}

/// Returns the likelier form of a member's change during the summed blocks.
ChangeEvidence::Candidate ChangeEvidence::best_form(std::size_t member) {
  const Score score = score_of(member);
  Candidate best = candidate_of(score, ChangeForm::kLate), moved = candidate_of(score, ChangeForm::kMoved);
  if (moved.evidence > best.evidence) std::swap(best, moved);
  best.other_form = moved.evidence;
  best.change.member = member;
  best.blocks = summed_;
  return best;
}

/// Compares the changes of all members during the last `blocks` blocks.
void ChangeEvidence::compare(std::size_t blocks) {
  sum_since(blocks);
  for (std::size_t m = 0; m < priors_.size(); ++m) {
    if (!is_tested(m)) continue;
    const Candidate candidate = best_form(m);
    const bool is_best = candidate.evidence > best_.evidence;
    if (m != best_.change.member)
      rival_evidence_ = std::max(rival_evidence_, is_best ? best_.evidence : candidate.evidence);
    if (is_best) best_ = candidate;
  }
}

/// Computes the residual sums of the blocks, with the suspect's change in the summed ones.
void ChangeEvidence::find_residuals(const FoundChange& change) {
  const Eigen::Index first = first_column(change.member);
  theta_ = estimate_;
  theta_.noalias() -= covariance_ * (N_since_.middleCols<4>(first) * change.size_m) / inflation_;
  theta_.segment<4>(first) += change.size_m;
  for (std::size_t age = 1; age <= filled_; ++age) {
    if (age == summed_ + 1) theta_.segment<4>(first) -= change.size_m;
    auto residual = residuals_.col(static_cast<Eigen::Index>(age - 1));
    residual = recent(age).s;
    residual.noalias() -= recent(age).N.selfadjointView<Eigen::Lower>() * theta_;
  }
}

/// Ratio of the variance of a member's residual sums, including a lag of one block, to that of white noise.
/// The block in which the change occurred is excluded.
double ChangeEvidence::inflation_of(std::size_t member) {
  if (summed_ > 0) residuals_.col(static_cast<Eigen::Index>(summed_ - 1)).setZero();
  double sum = 0.0, white = 0.0;
  for (Eigen::Index c = first_column(member); c < first_column(member) + 4; ++c) {
    const auto r = residuals_.row(c).head(static_cast<Eigen::Index>(filled_));
    sum += r.squaredNorm() + std::max(0.0, 2.0 * r.head(r.size() - 1).dot(r.tail(r.size() - 1)));
    white += N_(c, c);
  }
  return white > 0.0 ? sum / white : 0.0;
}

/// Median over the beacons, or over the receivers, without the suspect; at least 1. Returns the larger one.
double ChangeEvidence::typical_inflation(std::size_t accused) {
  double largest = 1.0;
  for (const bool beacons : {true, false}) {
    inflations_.clear();
    for (std::size_t m = beacons ? 0 : beacons_; m < (beacons ? beacons_ : priors_.size()); ++m)
      if (m != accused && is_tested(m)) inflations_.push_back(inflation_of(m));
    if (inflations_.empty()) continue;
    const auto middle = inflations_.begin() + static_cast<std::ptrdiff_t>(inflations_.size() / 2);
    std::ranges::nth_element(inflations_, middle);
    largest = std::max(largest, *middle);
  }
  return largest;
}

std::optional<FoundChange> ChangeEvidence::decide() {
  sum_since(best_.blocks);
  find_residuals(best_.change);
  const double typical = typical_inflation(best_.change.member),
               own = std::max(typical, inflation_of(best_.change.member));
  // A larger variance reduces a likelihood ratio in proportion, and its estimation from few blocks reduces it
  // further (Student).
  const double n = static_cast<double>(filled_), weight = inflation_ / own;
  const auto student = [&](double gain) {
    return 0.5 * n * std::log1p(2.0 * std::max(0.0, gain) * weight / n);
  };
  const bool is_change = student(best_.evidence) > threshold_ &&
                         student(best_.evidence - rival_evidence_) > kMemberMargin &&
                         certain_size_m(best_.change, weight, least_m_) > least_m_;
  if (best_.change.member != suspect_) confirmed_ = 0;
  suspect_ = best_.change.member;
  if (is_change)
    ++confirmed_;
  else if (confirmed_ > 0)
    --confirmed_;
  const bool is_confirmed = is_change && confirmed_ >= kConfirm && best_.blocks > 2;
  Candidate later = best_;
  bool is_clear = false;
  if (is_confirmed) {
    // The change occurred during the first of the blocks, so its size and form are estimated from the later
    // ones.
    sum_since(best_.blocks - 1);
    later = best_form(best_.change.member);
    is_clear = student(later.evidence - later.other_form) >= kFormMargin;
    if (!is_clear) later.change = candidate_of(score_of(best_.change.member), ChangeForm::kLate).change;
  }
  inflation_ = typical;
  if (!is_confirmed || (!is_clear && confirmed_ < kWaitForForm)) return std::nullopt;
  FoundChange change = later.change;
  change.member = best_.change.member;
  change.covariance_m2 /= weight;
  change.since_s = recent(best_.blocks).begin_s;
  return change;
}

}  // namespace octant

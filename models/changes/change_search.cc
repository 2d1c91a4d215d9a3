// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/change_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "models/changes/change_sigmas.h"
#include "models/changes/chi_square.h"
#include "models/support/decompositions.h"

namespace octant {
namespace {

using Held = std::vector<std::size_t>;

/// Least squares on the columns of some hypotheses.
struct ChangeFit {
  double explained = 0.0;  ///< decrease of chi-square
  int rank = 0;
  Eigen::VectorXd estimate;  ///< values of all hypotheses, one after the other
  Eigen::MatrixXd covariance;
};

class ChangeSearcher {
 public:
  ChangeSearcher(const Innovation& innovation, const std::vector<ChangeHypothesis>& hypotheses)
      : hypotheses_(hypotheses),
        G_(innovation.B.transpose() * innovation.B),
        h_(innovation.B.transpose() * innovation.y) {
    out_.chi2 = innovation.y.squaredNorm();
    out_.degrees_of_freedom = innovation.degrees_of_freedom;
    const double each = kFalseAlarm / static_cast<double>(std::max<std::size_t>(hypotheses.size(), 1));
    for (const ChangeHypothesis& hypothesis : hypotheses_) {
      const int rank = fit({static_cast<std::size_t>(&hypothesis - hypotheses_.data())}).rank;
      price_.push_back(rank > 0 ? chi_square_beyond(each, rank) : INFINITY);
    }
  }

  ChangeSearch run(const Held& also_from) {
    while (improve()) continue;
    const Held from_none = held_;
    held_ = also_from;
    std::erase_if(held_, [this](std::size_t k) { return !std::isfinite(price_[k]); });
    if (!held_.empty())
      while (improve()) continue;
    if (cost(from_none) <= cost(held_)) held_ = from_none;
    report();
    return std::move(out_);
  }

 private:
  [[nodiscard]] ChangeFit fit(const Held& held) const {
    std::vector<int> columns;
    std::vector<double> sigmas;
    for (const std::size_t k : held) {
      columns.insert(columns.end(), hypotheses_[k].columns.begin(), hypotheses_[k].columns.end());
      sigmas.insert(sigmas.end(), hypotheses_[k].sigma.begin(), hypotheses_[k].sigma.end());
    }
    ChangeFit out;
    if (columns.empty()) return out;
    // In units of the prior: information of at least one halves a variance and counts as a degree of freedom.
    const Eigen::Map<const Eigen::VectorXd> sigma(sigmas.data(), static_cast<Eigen::Index>(sigmas.size()));
    const SymmetricEigen<Eigen::MatrixXd> eigen(sigma.asDiagonal() * G_(columns, columns) *
                                                sigma.asDiagonal());
    const Eigen::VectorXd& information = eigen.eigenvalues();
    out.rank = static_cast<int>((information.array() > 1.0).count());
    const Eigen::MatrixXd V = sigma.asDiagonal() * eigen.eigenvectors();
    out.covariance = V * (information.array().max(0.0) + 1.0).inverse().matrix().asDiagonal() * V.transpose();
    out.estimate = out.covariance * h_(columns);
    out.explained = out.estimate.dot(h_(columns));
    return out;
  }

  /// Remaining sum of squares plus costs.
  [[nodiscard]] double cost(const Held& held) const {
    double total = out_.chi2 - fit(held).explained;
    for (const std::size_t k : held) total += price_[k];
    return total;
  }

  /// Makes the best single step: one change more, one less, or one replaced.
  bool improve() {
    Held best;
    double least = cost(held_) - 1e-9 * (1.0 + out_.chi2);
    const auto consider = [&](const Held& candidate) {
      if (const double c = cost(candidate); c < least) {
        least = c;
        best = candidate;
        found_ = true;
      }
    };
    found_ = false;
    for (std::size_t at = 0; at <= held_.size(); ++at) {
      Held without = held_;
      if (at < held_.size()) {
        without.erase(without.begin() + static_cast<std::ptrdiff_t>(at));
        consider(without);
      }
      for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
        if (!std::isfinite(price_[k]) || std::ranges::find(held_, k) != held_.end()) continue;
        Held with = without;
        with.push_back(k);
        consider(with);
      }
    }
    if (found_) held_ = best;
    return found_;
  }

  void report() {
    const double all = fit(held_).explained;
    out_.chi2_left = out_.chi2 - all;
    for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
      TestedChange t;
      t.hypothesis = k;
      Held with = held_, without;
      std::ranges::copy_if(held_, std::back_inserter(without), [k](std::size_t other) { return other != k; });
      t.held = without.size() < held_.size();
      if (!t.held) with.push_back(k);
      // Its own columns come first, so that they are at the head of the estimate.
      std::stable_partition(with.begin(), with.end(), [k](std::size_t other) { return other == k; });
      const ChangeFit fitted = fit(with);
      const ChangeFit rest = fit(without);
      const auto size = static_cast<Eigen::Index>(hypotheses_[k].columns.size());
      t.drop = std::max(0.0, fitted.explained - rest.explained);
      t.degrees_of_freedom = fitted.rank - rest.rank;
      t.estimate = fitted.estimate.head(size);
      t.covariance = fitted.covariance.topLeftCorner(size, size);
      if (t.degrees_of_freedom > 0)
        t.p = std::min(
            1.0, static_cast<double>(hypotheses_.size()) * chi_square_tail(t.drop, t.degrees_of_freedom));
      out_.tested.push_back(std::move(t));
    }
  }

  const std::vector<ChangeHypothesis>& hypotheses_;
  Eigen::MatrixXd G_;
  Eigen::VectorXd h_;
  std::vector<double> price_;
  Held held_;
  bool found_ = false;
  ChangeSearch out_;
};

}  // namespace

std::vector<std::size_t> ChangeSearch::held() const {
  std::vector<std::size_t> all;
  for (const TestedChange& t : tested)
    if (t.held) all.push_back(t.hypothesis);
  return all;
}

std::vector<ChangeHypothesis> change_hypotheses(const KnownParameters& known) {
  const ChangeSigmas sigmas = released_sigmas(known.speed_mps);
  std::vector<ChangeHypothesis> all;
  for (std::size_t i = 0; i < known.parameters.size(); ++i) {
    const ParameterId& p = known.parameters[i];
    const auto add = [&](ChangeKind kind, int size) {
      ChangeHypothesis h{
          kind, p.owner, {}, std::vector<double>(static_cast<std::size_t>(size), sigmas.of(p))};
      for (int k = 0; k < size; ++k) h.columns.push_back(static_cast<int>(i) + k);
      all.push_back(std::move(h));
    };
    switch (p.kind) {
      case ParameterKind::kBeaconPosition:
        if (p.component == 0) add(ChangeKind::kBeaconMoved, 3);
        break;
      case ParameterKind::kBeaconDelay: add(ChangeKind::kDelay, 1); break;
      case ParameterKind::kBeaconGain: add(ChangeKind::kAmplitude, 1); break;
      case ParameterKind::kReceiverPosition:
        if (p.component == 0) add(ChangeKind::kReceiver, 3);
        break;
      case ParameterKind::kSpeed: add(ChangeKind::kSpeed, 1); break;
      default: break;
    }
  }
  return all;
}

ChangeSearch search_changes(const Innovation& innovation, const std::vector<ChangeHypothesis>& hypotheses,
                            const std::vector<std::size_t>& also_from) {
  return ChangeSearcher(innovation, hypotheses).run(also_from);
}

}  // namespace octant

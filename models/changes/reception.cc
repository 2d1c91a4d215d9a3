// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/reception.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "models/changes/change_search.h"

namespace octant {
namespace {

constexpr std::size_t kBins = 40;    ///< number of bins of distance
constexpr std::size_t kBlocks = 16;  ///< number of blocks of time with equal numbers of arrivals
constexpr std::size_t kStarts = 8;   ///< number of final parts that are tested
constexpr std::size_t kOutOfReach = kBins;
constexpr double kLeastShare = 0.75;     ///< smallest rate relative to the others under the null hypothesis
constexpr double kLeastVariance = 0.04;  ///< relative variance of the rates of equal beacons: 20 %
constexpr double kFewestClusters =
    4.0;  ///< expected number for a neighbour that shows the spread of the rates
constexpr std::size_t kFewestOthers = 3;  ///< smallest number of such neighbours
constexpr double kNormalMad = 1.4826;     ///< ratio of standard deviation to median absolute deviation

using BinRates = std::array<double, kBins>;
using BlockCounts = std::array<double, kBlocks>;

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double negative_binomial_at_most(double count, double mean, double variance) {
  if (!(mean > 0)) return 1.0;
  const double k = 1.0 / variance;
  double term = std::exp(-k * std::log1p(mean / k)), sum = term;
  for (double x = 0.0; x + 1.0 <= count && sum < 1.0; x += 1.0) {
    term *= (x + k) / (x + 1.0) * mean / (k + mean);
    sum += term;
  }
  return std::min(1.0, sum);
}

void ReceptionLog::add(double time_s, std::size_t subject, std::span<const double> distance_m) {
  time_s_.push_back(time_s);
  subject_.push_back(subject);
  for (const double d : distance_m) distance_m_.push_back(static_cast<float>(d));
}

/// Rates by distance, expectations and tests for one log.
class ReceptionJudge {
 public:
  ReceptionJudge(const ReceptionLog& log, double cluster)
      : log_(log), cluster_(std::max(1.0, cluster)), count_(log.subjects_), is_neighbour_(count_, true) {
    double farthest_m = 0.0;
    for (std::size_t e = 0; e < log.time_s_.size(); ++e)
      if (const double d = distance_m(e, log.subject_[e]); d <= log.reach_m_)
        farthest_m = std::max(farthest_m, d);
    for (const float d : log.distance_m_)
      bin_.push_back(static_cast<std::uint8_t>(
          d > farthest_m || d > log.reach_m_
              ? kOutOfReach
              : std::min(kBins - 1, static_cast<std::size_t>(kBins * d / std::max(farthest_m, 1e-9)))));
  }

  std::vector<Reception> run() {
    constexpr int kRounds = 4;
    std::vector<Reception> found(count_);
    for (int round = 0; round < kRounds; ++round) {
      estimate_rates();
      expect();
      bool is_settled = true;
      for (std::size_t b = 0; b < count_; ++b) {
        found[b] = tested(b);
        is_settled = is_settled && is_neighbour_[b] != found[b].is_silent;
        is_neighbour_[b] = !found[b].is_silent;
      }
      if (is_settled) break;
    }
    return found;
  }

 private:
  [[nodiscard]] double distance_m(std::size_t e, std::size_t b) const {
    return static_cast<double>(log_.distance_m_[e * count_ + b]);
  }
  [[nodiscard]] std::size_t bin(std::size_t e, std::size_t b) const { return bin_[e * count_ + b]; }
  [[nodiscard]] std::size_t block(std::size_t e) const { return e * kBlocks / log_.time_s_.size(); }
  [[nodiscard]] bool is_counted(std::size_t e) const {
    return is_neighbour_[log_.subject_[e]] && bin(e, log_.subject_[e]) != kOutOfReach;
  }

  /// Breslow's estimate of the rate in each bin of distance, and its parts by subject.
  void estimate_rates() {
    constexpr int kIterations = 5;
    received_.assign(count_, {});
    for (std::size_t e = 0; e < log_.time_s_.size(); ++e)
      if (is_counted(e)) received_[log_.subject_[e]][bin(e, log_.subject_[e])] += 1.0;
    rate_.fill(1.0);
    for (int k = 0; k < kIterations; ++k) {
      exposed_.assign(count_, {});
      for (std::size_t e = 0; e < log_.time_s_.size(); ++e) {
        if (!is_counted(e)) continue;
        const double sum = sum_of_rates(e);
        for (std::size_t b = 0; b < count_ && sum > 0; ++b)
          if (is_neighbour_[b] && bin(e, b) != kOutOfReach) exposed_[b][bin(e, b)] += 1.0 / sum;
      }
      rate_ = rate_without(count_);
    }
  }

  [[nodiscard]] double sum_of_rates(std::size_t e) const {
    double sum = 0.0;
    for (std::size_t b = 0; b < count_; ++b)
      if (is_neighbour_[b] && bin(e, b) != kOutOfReach) sum += rate_[bin(e, b)];
    return sum;
  }

  /// Rates as all subjects but one show them; -1 where they do not.
  [[nodiscard]] BinRates rate_without(std::size_t left_out) const {
    BinRates rate;
    for (std::size_t k = 0; k < kBins; ++k) {
      double received = 0.0, exposed = 0.0;
      for (std::size_t b = 0; b < count_; ++b)
        if (b != left_out) {
          received += received_[b][k];
          exposed += exposed_[b][k];
        }
      rate[k] = exposed > 0 ? received / exposed : left_out < count_ ? -1.0 : 0.0;
    }
    return rate;
  }

  /// Rates for the expectation of a subject: the lower one of a bin and the next bin outward that the others
  /// determine, because the limit of reach may lie between them. Beyond the last of these bins the
  /// expectation is zero.
  [[nodiscard]] BinRates cautious_rate(std::size_t b) const {
    const BinRates shown = rate_without(b);
    BinRates rate{};
    double outer = INFINITY;
    for (std::size_t k = kBins; k-- > 0;) {
      if (shown[k] >= 0) {
        rate[k] = std::min(shown[k], outer);
        outer = shown[k];
      } else if (std::isfinite(outer)) {
        double inner = 0.0;
        for (std::size_t i = k; i-- > 0 && inner == 0.0;) inner = std::max(0.0, shown[i]);
        rate[k] = std::min(inner, outer);
      }
    }
    return rate;
  }

  void expect() {
    expected_.assign(count_, {});
    came_.assign(count_, {});
    std::vector<BinRates> cautious;
    for (std::size_t b = 0; b < count_; ++b) cautious.push_back(cautious_rate(b));
    for (std::size_t e = 0; e < log_.time_s_.size(); ++e) {
      came_[log_.subject_[e]][block(e)] += 1.0;
      if (!is_counted(e)) continue;
      const double sum = sum_of_rates(e);
      for (std::size_t b = 0; b < count_; ++b) {
        if (b == log_.subject_[e] || bin(e, b) == kOutOfReach) continue;
        const double others = sum - (is_neighbour_[b] ? rate_[bin(e, b)] : 0.0);
        if (others > 1e-6 * sum) expected_[b][block(e)] += cautious[b][bin(e, b)] / others;
      }
    }
  }

  [[nodiscard]] static double from(const BlockCounts& blocks, std::size_t start) {
    double sum = 0.0;
    for (std::size_t k = start; k < kBlocks; ++k) sum += blocks[k];
    return sum;
  }

  /// Relative variance of the rates of the others from some block on; infinite where they do not show it.
  [[nodiscard]] double variance_of_others(std::size_t subject, std::size_t start) const {
    std::vector<double> ratio, noise;
    for (std::size_t b = 0; b < count_; ++b) {
      const double expected = from(expected_[b], start);
      if (b == subject || !is_neighbour_[b] || expected < kFewestClusters * cluster_) continue;
      ratio.push_back(from(came_[b], start) / expected);
      noise.push_back(cluster_ / expected);
    }
    if (ratio.size() < kFewestOthers) return INFINITY;
    const double middle = median_of(ratio);
    if (!(middle > 0)) return INFINITY;
    for (double& r : ratio) r = std::abs(r / middle - 1.0);
    const double mad = kNormalMad * median_of(ratio);
    return std::max(kLeastVariance, mad * mad - median_of(noise));
  }

  [[nodiscard]] Reception tested(std::size_t b) const {
    Reception out{from(came_[b], 0), from(expected_[b], 0), false, {}};
    // The whole visit has half of the false alarms, its final parts share the other half.
    double limit_p = kFalseAlarm / static_cast<double>(2 * count_);
    for (std::size_t start = 0; start < kBlocks; start += kBlocks / kStarts) {
      const double expected = from(expected_[b], start), received = from(came_[b], start);
      if (received >= kLeastShare * expected) continue;
      const double variance = variance_of_others(b, start);
      if (!std::isfinite(variance)) continue;
      const double p = negative_binomial_at_most(std::floor(received / cluster_),
                                                 kLeastShare * expected / cluster_, variance);
      const double part_p = start > 0 ? p * (kStarts - 1) : p;
      if (part_p >= limit_p) continue;
      limit_p = part_p;
      out.is_silent = true;
      const std::size_t first = (start * log_.time_s_.size() + kBlocks - 1) / kBlocks;
      out.silence = {"", expected, received, start > 0, log_.time_s_[first]};
      if (start == 0) break;
    }
    return out;
  }

  const ReceptionLog& log_;
  double cluster_;
  std::size_t count_;
  std::vector<std::uint8_t> bin_;
  std::vector<bool> is_neighbour_;  ///< true if it is received as expected
  BinRates rate_{};
  std::vector<BinRates> received_, exposed_;  ///< for each subject
  std::vector<BlockCounts> came_, expected_;  ///< for each subject
};

std::vector<Reception> ReceptionLog::judge(double cluster) const {
  if (time_s_.empty()) return std::vector<Reception>(subjects_);
  return ReceptionJudge(*this, cluster).run();
}

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/ids.h"

namespace octant {

/// Page's test for a lost place. It counts pings: the arrivals of one beacon within some milliseconds share
/// an echo, and so count once, by their majority. A ping that does not fit counts +1, one that fits -1. Where
/// one ping in ten is an echo, six more misfits than fits happen by chance once in some hundred thousand
/// pings; where the place is lost, within some six.
class LossTest {
 public:
  void add(BeaconId beacon, double time_s, bool fits) {
    if (beacon != beacon_ || std::abs(time_s - begin_s_) > kPing_s) {
      score_ = score();
      beacon_ = beacon;
      begin_s_ = time_s;
      fits_ = misfits_ = 0;
    }
    ++(fits ? fits_ : misfits_);
  }
  void clear() { *this = LossTest(); }
  /// The last pings fit.
  [[nodiscard]] bool is_calm() const { return score() == 0; }
  [[nodiscard]] bool is_lost() const { return score() >= kLost; }

 private:
  static constexpr double kPing_s = 0.02;
  static constexpr int kLost = 6;
  [[nodiscard]] int score() const {
    if (fits_ + misfits_ == 0) return score_;
    return std::max(0, score_ + (misfits_ > fits_) - (fits_ > misfits_));
  }
  BeaconId beacon_;
  double begin_s_ = 0.0;
  int score_ = 0, fits_ = 0, misfits_ = 0;
};

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/ids.h"

namespace octant {

/// Page's test for a lost place. It counts pings: the arrivals of one beacon within some milliseconds share
/// an echo, and so count once: as one that fits where at least half of them do. A ping that does not fit
/// counts +1, one that fits -2. That is the log likelihood ratio, up to a factor, of a place that is lost
/// (nearly no ping fits) against one that is right (three in ten are echoes). Six more misfits than that
/// explain happen by chance once in some thousand pings at three echoes in ten, and once in a million at one
/// in ten.
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
    return std::max(0, score_ + (fits_ >= misfits_ ? -2 : 1));
  }
  BeaconId beacon_;
  double begin_s_ = 0.0;
  int score_ = 0, fits_ = 0, misfits_ = 0;
};

}  // namespace octant

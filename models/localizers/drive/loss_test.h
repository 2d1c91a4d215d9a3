// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "models/localizers/drive/ping.h"

namespace octant {

/// Page's test for a lost pose. It counts pings: the arrivals of one beacon within some milliseconds share an
/// echo, so they count once, by majority. A ping that disagrees counts +1, one that agrees -1. If one ping in
/// ten is an echo, a sum of six occurs by chance once in about a hundred thousand pings; if the pose is lost,
/// within about six.
class LossTest {
 public:
  void add(BeaconId beacon, double time_s, bool fits) {
    if (!ping_.includes(beacon, time_s)) {
      score_ = score();
      ping_ = {beacon, time_s};
      fits_ = misfits_ = 0;
    }
    ++(fits ? fits_ : misfits_);
  }
  void clear() { *this = LossTest(); }
  /// Returns true if the last pings agree.
  [[nodiscard]] bool is_calm() const { return score() == 0; }
  [[nodiscard]] bool is_lost() const { return score() >= kLost; }

 private:
  static constexpr int kLost = 6;
  [[nodiscard]] int score() const {
    if (fits_ + misfits_ == 0) return score_;
    return std::max(0, score_ + (misfits_ > fits_) - (fits_ > misfits_));
  }
  Ping ping_;
  int score_ = 0, fits_ = 0, misfits_ = 0;
};

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "models/localizers/drive/ping.h"

namespace octant {

/// Page's test for a lost pose. It counts pings: the arrivals of one beacon within some milliseconds share an
/// echo, so they count once. A ping that disagrees counts +1, one that agrees -1. If one ping in ten is an
/// echo, a sum of six occurs by chance once in about a hundred thousand pings; if the pose is lost, within
/// about six.
class LossTest {
 public:
  /// Adds an arrival. @param agrees  verdict on its whole ping so far, which replaces an earlier one
  void add(BeaconId beacon, double time_s, bool agrees) {
    if (!ping_.includes(beacon, time_s)) {
      before_ = score_;
      ping_ = {beacon, time_s};
    }
    score_ = std::max(0, before_ + (agrees ? -1 : 1));
  }
  void clear() { *this = LossTest(); }
  /// Returns true if the last pings agree.
  [[nodiscard]] bool is_calm() const { return score_ == 0; }
  [[nodiscard]] bool is_lost() const { return score_ >= kLost; }

 private:
  static constexpr int kLost = 6;
  Ping ping_;
  int score_ = 0, before_ = 0;  ///< with and without the last ping
};

}  // namespace octant

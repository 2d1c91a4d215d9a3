// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace octant::calib {

/// Processes that solve one problem together: all have the recordings, each solves and reduces its share of
/// the tiles, and the results are added. The launcher (MPI) implements it; without it there is one process.
class Ranks {
 public:
  virtual ~Ranks() = default;
  [[nodiscard]] virtual int count() const = 0;
  [[nodiscard]] virtual int index() const = 0;
  /// Every element becomes its sum over all ranks, the same on each to the last bit. All ranks call it in the
  /// same order.
  virtual void sum(std::span<double> values) const = 0;

 protected:
  Ranks() = default;
  Ranks(const Ranks&) = default;
  Ranks& operator=(const Ranks&) = default;
};

/// Who works on the tiles; the result does not depend on it.
struct Workers {
  int threads = 1;
  const Ranks* ranks = nullptr;  ///< not owned; null: this process is alone
};

}  // namespace octant::calib

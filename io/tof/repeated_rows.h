// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: repeated rows of tof.csv.

#include <cstddef>
#include <vector>

#include "models/run.h"

namespace octant::io {

/// Removes arrivals that repeat another one of the same time in everything but their line: a row that is
/// written twice is one measurement. Processes the rows in the order of the file, which is that of their
/// times.
class RepeatedRows {
 public:
  /// Examines the arrivals from `first` on, which follow those of the previous call, and removes repeated
  /// ones.
  /// @return  lines of the removed rows
  [[nodiscard]] std::vector<int> drop(std::vector<Arrival>& all, std::size_t first);

 private:
  std::vector<Arrival> latest_;  ///< arrivals of the latest time so far
};

}  // namespace octant::io

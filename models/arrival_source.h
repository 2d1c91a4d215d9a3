// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "models/run.h"
#include "models/support/result.h"

namespace octant {

/// Source of recordings whose arrivals do not fit in memory. Each pass reads them again, in blocks of some
/// thousands. The source chooses where blocks begin: an epoch may begin in one block and end in the next.
class ArrivalSource {
 public:
  virtual ~ArrivalSource() = default;

  /// Recordings without their arrivals. `rows`, `rejected`, warnings and digests are complete after scan().
  [[nodiscard]] virtual std::size_t runs() const = 0;
  [[nodiscard]] virtual const MeasurementLog& log(std::size_t run) const = 0;

  /// Receives the next block of a run. Returns false to end the pass.
  using Visit = std::function<bool(std::size_t run, const std::vector<Arrival>& block)>;
  /// Reads everything once, run by run and in order, with all checks of the reader. Must be called first.
  [[nodiscard]] virtual Result<void> scan(const Visit& visit) = 0;
  /// Appends the arrivals of blocks [first, last) of a run to `arrivals`. May be called from several threads.
  [[nodiscard]] virtual Result<void> read(std::size_t run, std::size_t first, std::size_t last,
                                          std::vector<Arrival>& arrivals) const = 0;

 protected:
  ArrivalSource() = default;
  ArrivalSource(const ArrivalSource&) = default;
  ArrivalSource& operator=(const ArrivalSource&) = default;
};

}  // namespace octant

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "models/run.h"
#include "models/support/result.h"

namespace octant {

/// Recordings whose arrivals are too many to be held: they are read again and again, in blocks of some
/// thousands that lie where the source likes (an epoch may begin in one and end in the next).
class ArrivalSource {
 public:
  virtual ~ArrivalSource() = default;

  /// The recordings without their arrivals. `rows`, `rejected`, warnings and digests are complete after
  /// scan().
  [[nodiscard]] virtual std::size_t runs() const = 0;
  [[nodiscard]] virtual const MeasurementLog& log(std::size_t run) const = 0;

  /// Takes a block, the next of its run; false: no more of them are wanted.
  using Visit = std::function<bool(std::size_t run, const std::vector<Arrival>& block)>;
  /// Reads everything once, run by run, in order, with all the checks of reading. To be called first.
  [[nodiscard]] virtual Result<void> scan(const Visit& visit) = 0;
  /// Puts the arrivals of blocks [first, last) of a run behind what `arrivals` holds. Several threads may do
  /// so.
  [[nodiscard]] virtual Result<void> read(std::size_t run, std::size_t first, std::size_t last,
                                          std::vector<Arrival>& arrivals) const = 0;

 protected:
  ArrivalSource() = default;
  ArrivalSource(const ArrivalSource&) = default;
  ArrivalSource& operator=(const ArrivalSource&) = default;
};

}  // namespace octant

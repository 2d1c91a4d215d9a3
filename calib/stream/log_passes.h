// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "calib/adjust/tile.h"
#include "calib/errors/statistics.h"
#include "calib/start/approach.h"
#include "calib/stream/log_index.h"
#include "calib/verdict/conclude.h"
#include "models/arrival_source.h"

namespace octant::calib {

/// How much of a log is at hand at once. The chunks depend on the memory alone, so that no sum depends on the
/// number of threads.
struct StreamPlan {
  std::size_t chunk_arrivals = 0;
  int workers = 1;  ///< chunks worked on side by side
};
[[nodiscard]] StreamPlan stream_plan(std::size_t memory_bytes, int threads);

/// What one reading of a log leaves of it at an estimate.
struct PassSum {
  ReducedSystem system;      ///< of all arrivals in use, plain squares; its cost is theirs
  double cost_before = 0.0;  ///< with the marks as they were before the pass
  std::size_t changed = 0;   ///< marks
  ObservationCounts counts;  ///< without residuals
};

/// A log that is read again for each look at it, chunk by chunk on several threads. Between the readings
/// there remains where each stop is (28 bytes) and what became of each arrival (one byte); ranks keep those
/// of their own chunks and read no others. Errors: those of reading, Errc::kInterrupted where the course is
/// to stop.
class LogPasses {
 public:
  /// All must outlive it. @param frame  site and runs without arrivals
  LogPasses(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
            const SolveOptions& options, int workers, Course& course);
  ~LogPasses();

  struct Placed {
    std::vector<double> residuals;  ///< magnitudes of evenly spread ones
    std::vector<double> ranges_m;   ///< the same, by the site's priors
    PassSum sum;                    ///< where marks were asked for
  };
  /// Places all stops anew (see place_all_stops).
  /// @param mark  then rejects, settles with plain squares and sums up
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool mark);

  enum class Marks {
    kKept,
    kFirst,   ///< rejected at the states as they are, which are settled then
    kSettled  ///< rejected at settled states, which are settled again where marks changed
  };
  /// Settles all stops at the estimate.
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, Marks marks);

  struct Told {
    Findings findings;
    std::vector<std::vector<Arrival>> arrivals;  ///< of each run, those of the epochs at hand
    std::vector<Trajectory> trajectories;        ///< of these
  };
  /// What is to be said of all arrivals at the end, and every so many-th epoch to look at.
  [[nodiscard]] Result<Told> tell(const Estimate& estimate);

 private:
  struct Work;
  struct Stops;
  class Teller;

  template <class Do>
  Result<void> for_each_chunk_of_mine(Do&& work);
  Result<void> load(std::size_t chunk, Work& w) const;
  void restore(const Stops& stops, double sigma_s, Work& w) const;
  void keep(const Work& w, Stops& stops) const;
  void add_up(std::vector<double>& numbers) const;
  [[nodiscard]] std::vector<double> in_order(std::vector<std::vector<double>> of_chunks) const;

  const Problem& frame_;
  const ArrivalSource& source_;
  const LogIndex& index_;
  const SolveOptions& options_;
  Course& course_;
  TrajectoryModel model_;
  std::size_t first_, last_;  ///< chunks of this rank
  std::vector<std::unique_ptr<Work>> workers_;
  std::vector<Stops> stops_;  ///< of each chunk
};

}  // namespace octant::calib

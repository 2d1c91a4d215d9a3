// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calib/sums/ranks.h"

namespace octant::app {

/// Processes started together by an MPI launcher (mpirun, srun). A single process without a launcher, or if
/// Octant was built without -DOCTANT_MPI=ON. Only the first process writes output.
class Job {
 public:
  Job(int* argc, char*** argv);
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  /// Null for a single process.
  [[nodiscard]] const calib::Ranks* ranks() const;
  [[nodiscard]] bool is_first() const { return ranks() == nullptr || ranks()->index() == 0; }
  /// Collects the texts of all ranks on the first rank; elsewhere the result is empty. All ranks must call
  /// it.
  [[nodiscard]] std::vector<std::string> gather(const std::string& text) const;
  /// Ends this rank with its exit code. If it failed and the others do not fail as well, the whole job is
  /// terminated, so that no rank waits forever.
  [[nodiscard]] int finish(int code);

 private:
  class Mpi;
  std::unique_ptr<Mpi> mpi_;
};

}  // namespace octant::app

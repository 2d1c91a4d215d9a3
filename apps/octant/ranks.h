// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calib/sums/ranks.h"

namespace octant::app {

/// The processes that an MPI launcher (mpirun, srun) started together; a process on its own where there was
/// none, or where Octant was built without -DOCTANT_MPI=ON. The first of them talks and writes; the others
/// are silent.
class Job {
 public:
  Job(int* argc, char*** argv);
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  /// null: this process is alone.
  [[nodiscard]] const calib::Ranks* ranks() const;
  [[nodiscard]] bool is_first() const { return ranks() == nullptr || ranks()->index() == 0; }
  /// What every rank has to say, on the first; elsewhere empty. All ranks call it.
  [[nodiscard]] std::vector<std::string> gather(const std::string& text) const;
  /// Ends the work of this rank with its exit code. Where it failed and the others do not come to the same
  /// end, the whole job is ended, so that nobody waits for it.
  [[nodiscard]] int finish(int code);

 private:
  class Mpi;
  std::unique_ptr<Mpi> mpi_;
};

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/solution/solution.h"

namespace octant::calib {

const char* to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged: return "ok";
    case SolveStatus::kNotConverged: return "not_converged";
    case SolveStatus::kUndetermined: return "undetermined";
    case SolveStatus::kInterrupted: return "interrupted";
  }
  return "not_converged";
}

}  // namespace octant::calib

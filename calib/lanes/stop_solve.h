// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/lanes/stop_pack.h"

namespace octant::calib {

struct StopOutcome {
  Lanes cost;       ///< 1/2 sum of rho
  Lanes converged;  ///< 1: converged; 0: not converged or singular, to be solved by the careful method
};

/// Gauss-Newton steps (damped where the cost would rise) on the states of eight epochs, as `solve_states`
/// does for one.
void solve_stops(const StopTables& tables, const StopPack& pack, StopStates& states, StopOutcome& outcome);

/// Name of the vector instructions in use, chosen when the program runs.
const char* stop_kernel_target();

}  // namespace octant::calib

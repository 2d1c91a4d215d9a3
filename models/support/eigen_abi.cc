// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/eigen_abi.h"

namespace octant::abi {

// The libraries' own settings, and no others, can be linked.
template <>
const char EigenSettings::as_octants_libraries = 0;

}  // namespace octant::abi

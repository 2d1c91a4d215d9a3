// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/calibrate.h"
#include "calib/revisit/revisit.h"
#include "models/deployment.h"

namespace octant::calib {

/// Completes the new deployment with its provenance.
[[nodiscard]] Deployment finished(const Revisit& revisit, const Deployment& before,
                                  const Provenance& provenance);

}  // namespace octant::calib

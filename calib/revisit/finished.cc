// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/finished.h"

#include "models/changes/comparison.h"
#include "models/changes/known_parameters.h"

namespace octant::calib {

Deployment finished(const Revisit& revisit, const Deployment& before, const Provenance& provenance) {
  Deployment d = revisit.as_left;
  d.created = provenance.created;
  d.program_version = provenance.version;
  d.program_command = provenance.command;
  d.inputs = provenance.inputs;
  d.warnings = revisit.warnings;
  d.digest.clear();
  d.previous =
      Previous{before.digest, before.created, revisit.drift,
               changed_parameters(revisit.comparison, known_parameters(before)), revisit.comparison.changes};
  return d;
}

}  // namespace octant::calib

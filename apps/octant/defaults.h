// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "apps/octant/session.h"

namespace octant::app {

/// Sets the common options as the user's file of defaults has them, before the words of the command do:
/// $OCTANT_DEFAULTS (empty: none), else defaults.yaml in $XDG_CONFIG_HOME/octant or ~/.config/octant, where
/// there is one. Failures: those of read_defaults, and $OCTANT_DEFAULTS that names no file.
void apply_defaults(Session& session);

}  // namespace octant::app

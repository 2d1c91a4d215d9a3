// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "apps/octant/session.h"

namespace octant::app {

/// Applies the user's defaults to the common options before the command line is parsed. They are read from
/// $OCTANT_DEFAULTS (if empty, there are none), else from defaults.yaml in $XDG_CONFIG_HOME/octant or
/// ~/.config/octant, if it exists. Fails like read_defaults, and if $OCTANT_DEFAULTS names no file.
void apply_defaults(Session& session);

}  // namespace octant::app

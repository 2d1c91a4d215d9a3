// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"

namespace octant::app {

struct CheckArgs {
  std::string site;
  std::vector<std::string> runs;
  bool strict = false;  ///< a single undetermined beacon is exit 5
};
/// All of `octant check` behind its words.
int check_recordings(const CheckArgs& args, Session& session);

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "models/support/result.h"

namespace octant::python {

/// Raises octant.errors' exception of a failure's category. The caller holds Python's lock.
[[noreturn]] void raise(const Error& error);

/// The commands that give an object: check, calibrate, verify, survey, monitor. They take paths, as on the
/// command line, and give what `--json` prints.
void bind_calls(pybind11::module_& m);

}  // namespace octant::python

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "models/support/result.h"

namespace octant::python {

/// Raises the exception of octant.errors for the category of a failure. The caller must have Python's lock.
[[noreturn]] void raise(const Error& error);

/// Commands with an object as result: check, calibrate, verify, survey, monitor. Arguments are paths, as on
/// the command line, and the result is that of `--json`.
void bind_calls(pybind11::module_& m);

}  // namespace octant::python

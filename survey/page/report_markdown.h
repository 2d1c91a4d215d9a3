// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "survey/report/report_document.h"

namespace octant::survey {

/// A document as Markdown: the same words and tables, drawings by their captions.
[[nodiscard]] std::string to_markdown(const ReportDocument& document);

}  // namespace octant::survey

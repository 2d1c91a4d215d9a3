// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "survey/report/report_document.h"

namespace octant::survey {

/// Writes a document as one page: headings in order, tables with captions and scopes, drawings with captions,
/// a skip link, light and dark colours, A4. The content security policy is `default-src 'none'`.
/// @param plotly  plotly.js as gzip in base64 (plotly_js.h); empty: the page has no script
[[nodiscard]] std::string to_html(const ReportDocument& document, std::string_view plotly);

/// Head of a page of ours up to and with <body>: policy, title, style.
[[nodiscard]] std::string page_head(const std::string& title, const std::string& more_style, bool scripts);

}  // namespace octant::survey

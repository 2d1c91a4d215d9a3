// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/deployment.h"
#include "survey/report/report_document.h"

namespace octant::survey {

/// Data of a calibration that the program does not know; if a member is empty, the certificate has a line to
/// fill in by hand.
struct CertificateInput {
  std::string number;        ///< unique; empty: made of site and digest
  std::string organisation;  ///< who calibrated: name and address
  std::string operator_name;
  std::string customer;
  std::string place;
  std::string issued;  ///< ISO 8601
  std::string digest;  ///< SHA-256 of the deployment file's content
};

/// A record of a calibration with what ISO/IEC 17025:2017 7.8.2 and 7.8.4 ask of one: identification,
/// conditions, method, results with expanded uncertainty and its coverage factor, traceability, state as
/// found where an earlier deployment was recalibrated, decision rule. It claims no accreditation.
[[nodiscard]] ReportDocument certificate_document(const Deployment& deployment,
                                                  const CertificateInput& input);

}  // namespace octant::survey

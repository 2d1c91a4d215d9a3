// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::io {

enum class VisitKind { kCalibration, kMonitoring, kVerification };
[[nodiscard]] const char* to_string(VisitKind kind);

/// A beacon as estimated by a calibration.
struct VisitBeacon {
  std::string name;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double delay_s = 0.0, delay_sigma_s = 0.0;
  BeaconStatus status = BeaconStatus::kCalibrated;
};

/// Speed as estimated by a calibration, at the reference temperature of its medium.
struct VisitSpeed {
  double speed_mps = 0.0, sigma_mps = 0.0;
  double offset_mps = 0.0;  ///< offset from the model of the medium, after the correction for temperature
  double temperature_degC = 0.0;
};

/// One result about a site on one day: a calibration, a monitoring, a verification.
struct Visit {
  std::int64_t id = 0;  ///< number in the history, from 1
  VisitKind kind = VisitKind::kCalibration;
  std::string site;
  std::int64_t happened_s = 0;  ///< seconds since 1970, UTC: when the deployment or the result was made
  std::int64_t added_s = 0;     ///< time of its addition to the history
  std::string digest;           ///< SHA-256 of the document's content; layout does not matter
  /// Digest of the deployment to which the result belongs; for a calibration, that of its own deployment
  std::string deployment_digest;
  std::optional<std::array<double, 2>> temperature_degC;  ///< lowest and highest temperature of the recording
  std::optional<VisitSpeed> speed;                        ///< speed of a calibration
  std::string verdict;  ///< grade of a calibration; ok, gate_failed, ... of a result
  std::string who, note, source,
      program;           ///< operator, remark, path as it was added, version of octant that made it
  std::string document;  ///< the JSON itself; not in lists
  std::vector<VisitBeacon> beacons;  ///< beacons of a calibration; not in lists
};

/// Extracts a visit from a deployment file or from the JSON object of `octant verify` or `octant monitor`.
/// The caller sets the `verdict` of a calibration, the operator and the note. Errors: another kind of
/// document, no date, no site, a deployment that was altered.
[[nodiscard]] Result<Visit> visit_of(const std::string& text, const std::string& file);
[[nodiscard]] Result<Visit> read_visit(const std::string& path);

/// Selection of visits; empty members do not restrict it.
struct VisitFilter {
  std::string site;
  std::optional<VisitKind> kind;
};

struct Addition {
  std::int64_t id = 0;
  bool is_new = false;  ///< false: the history had the same document
};

/// The visits to one or several sites in one SQLite file or in a PostgreSQL database. Several programs may
/// read and write at the same time. Visits are on the disk when add() returns. If a program is killed, an
/// addition is stored completely or not at all.
class History {
 public:
  /// @param path    of the file, or a connection string (postgresql://user@host/database) if this Octant was
  /// built with libpq
  /// @param create  makes the file or the tables if they are missing
  /// Errors: not a history, one of a newer octant, a database of another program.
  [[nodiscard]] static Result<History> open(const std::string& path, bool create);
  History(History&&) noexcept;
  History& operator=(History&&) noexcept;
  ~History();

  /// Adds all visits in one transaction. Documents that are in the history already stay unchanged.
  [[nodiscard]] Result<std::vector<Addition>> add(const std::vector<Visit>& visits);
  /// By date, without documents and beacons.
  [[nodiscard]] Result<std::vector<Visit>> list(const VisitFilter& filter = {});
  /// Calibrations by date, with their beacons and without documents.
  [[nodiscard]] Result<std::vector<Visit>> calibrations(const std::string& site);
  /// Returns one visit with its document. Errors: no visit has this number.
  [[nodiscard]] Result<Visit> get(std::int64_t id);

 private:
  struct Content;
  explicit History(std::unique_ptr<Content> content);
  std::unique_ptr<Content> content_;
};

}  // namespace octant::io

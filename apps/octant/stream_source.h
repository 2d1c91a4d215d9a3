// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "io/run/run_stream.h"
#include "models/arrival_source.h"

namespace octant::app {

/// Run folders as a source of arrivals that can be read repeatedly.
class StreamSource : public ArrivalSource {
 public:
  /// Errors are those of read_run(), except for invalid rows of tof.csv, which scan() reports.
  /// @param session  receives the warnings of the readers
  [[nodiscard]] static Result<std::unique_ptr<StreamSource>> open(const std::vector<std::string>& folders,
                                                                  const NameTable& names,
                                                                  const Timing& timing, Session& session,
                                                                  double constant_speed_mps = 0.0);

  [[nodiscard]] std::size_t runs() const override { return streams_.size(); }
  [[nodiscard]] const MeasurementLog& log(std::size_t run) const override { return streams_[run].log(); }
  [[nodiscard]] std::vector<const MeasurementLog*> logs() const;
  [[nodiscard]] Result<void> scan(const Visit& visit) override;
  [[nodiscard]] Result<void> read(std::size_t run, std::size_t first, std::size_t last,
                                  std::vector<Arrival>& arrivals) const override {
    return streams_[run].read_blocks(first, last, arrivals);
  }
  /// Upper estimate of the number of arrivals, available before scan().
  [[nodiscard]] std::size_t rows_estimate() const;
  [[nodiscard]] std::size_t odometry_rows() const;

 private:
  StreamSource(const std::vector<std::string>& folders, const NameTable& names, const Timing& timing,
               Session& session)
      : folders_(folders), names_(names), timing_(timing), session_(session) {}

  std::vector<std::string> folders_;
  NameTable names_;
  Timing timing_;
  Session& session_;
  double constant_speed_mps_ = 0.0;  ///< see io::ReadRunOptions
  std::vector<io::RunStream> streams_;
};

/// Returns true if recordings are certain to need less memory than given, even if their rows are as short as
/// possible.
[[nodiscard]] bool fits_for_sure(const std::vector<std::string>& folders, std::size_t memory_bytes);

}  // namespace octant::app

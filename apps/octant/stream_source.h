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

/// Run folders as a source of arrivals that are read again and again.
class StreamSource : public ArrivalSource {
 public:
  /// Errors: those of read_run() but for the rows of tof.csv, which scan() finds.
  /// @param session  hears the warnings of reading
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
  /// A guess at the number of arrivals, rather too many; before scan().
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
  double constant_speed_mps_ = 0.0;  ///< as in io::ReadRunOptions
  std::vector<io::RunStream> streams_;
};

/// Whether recordings are so small that they take less than this, however short their rows.
[[nodiscard]] bool fits_for_sure(const std::vector<std::string>& folders, std::size_t memory_bytes);

}  // namespace octant::app

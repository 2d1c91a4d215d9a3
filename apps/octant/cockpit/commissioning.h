// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/octant/cockpit/calibration_view.h"
#include "apps/octant/cockpit/http.h"
#include "apps/octant/cockpit/live_state.h"
#include "apps/octant/cockpit/recorder.h"
#include "apps/octant/cockpit/row_source.h"
#include "apps/octant/cockpit/site_edit.h"

namespace octant::app {

/// Inputs of a commissioning, or of the monitoring of a deployment. With neither, a commissioning begins with
/// the names of the stream, and the operator describes the site.
struct CommissioningInput {
  std::optional<Site> site;              ///< set for a commissioning
  std::optional<Deployment> deployment;  ///< set for monitoring
  std::string path;                      ///< of either
  std::string run;                       ///< run folder to write; empty: monitoring without a record
  std::string run_yaml;                  ///< its run.yaml
  double lateness_s = 0.2;
  [[nodiscard]] NameTable names() const {
    return site ? names_of(*site) : deployment ? names_of(*deployment) : NameTable();
  }
};

/// The commissioning of a site. Three threads use it: the one that reads the source adds rows, a thread of
/// its own calibrates what is recorded, and the web server asks for the state and passes on commands.
class Commissioning {
 public:
  /// Fails if the run folder cannot be written. @param session  must outlive it
  Commissioning(CommissioningInput input, Session& session);
  ~Commissioning();
  Commissioning(const Commissioning&) = delete;
  Commissioning& operator=(const Commissioning&) = delete;

  /// Reads the source once, records what came and updates the state.
  RowSource::Event advance(RowSource& source);
  [[nodiscard]] const std::string& run() const { return input_.run; }
  /// Writes all rows, and waits for the disk.
  void close();
  /// Calibrates the complete run and writes its results, as the command `finish`.
  void finish(bool accept);
  /// Result of the last command `finish`; null before it.
  [[nodiscard]] Json finished() const;

  /// Answers a request of the page.
  [[nodiscard]] HttpResponse answer(const HttpRequest& request);
  /// The state as a server-sent event if it has changed since the last call.
  [[nodiscard]] std::string next_event();
  /// State of the schema `cockpit`.
  [[nodiscard]] Json state() const;
  [[nodiscard]] RecorderCounts counts() const;

 private:
  using Clock = std::chrono::steady_clock;
  void work();
  /// Adds new names of the stream. Beacons of a site that was described here are added to its file.
  void learn(const NameTable& names);
  void record(const io::LiveRow& row);
  /// Adds a row to the run; it waits while the run is calibrated to finish.
  void keep(const io::LiveRow& row);
  void sync_disk();
  [[nodiscard]] bool is_calibration_due() const;
  [[nodiscard]] HttpResponse obey(const Json& command);
  /// Map of the floor with beacons at other places; it changes nothing.
  [[nodiscard]] HttpResponse floor_if(const Json& question) const;
  [[nodiscard]] Result<void> carry_out(const std::string& what, const Json& command);
  [[nodiscard]] Result<void> set_point(const Json& command);
  [[nodiscard]] Result<void> set_site(const Json& command);
  [[nodiscard]] Json light() const;
  [[nodiscard]] Json stops_json() const;
  /// Position of a beacon in the site file or the deployment; null if it is not known.
  [[nodiscard]] Json stated_m(const std::string& beacon) const;
  void add_recording(Json& state) const;
  /// Reads the site file again after a change.
  [[nodiscard]] Result<void> reread(Result<void> changed);

  CommissioningInput input_;
  NameTable names_;  ///< of the rows
  Session& session_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<RunRecorder> recorder_;
  LiveState live_;
  SiteEdit site_edit_;
  CalibrationView view_;
  std::string source_, recording_error_, operator_;
  std::map<std::string, std::size_t> bad_lines_;
  bool is_source_over_ = false, is_calibrating_ = false, is_closing_ = false, is_site_changed_ = true;
  std::optional<bool> finish_order_;           ///< accept
  std::vector<io::LiveRow> held_rows_;         ///< that came while the command finish is carried out
  Json finished_ = nullptr, tried_ = nullptr;  ///< result of the last finish with a deployment, and of any
  std::vector<bool> is_known_;                 ///< by beacon: in the site file
  std::size_t known_receivers_ = std::numeric_limits<std::size_t>::max();
  std::map<std::string, std::size_t> unknown_;  ///< rows of beacons that are not in the site file
  std::size_t calibrated_arrivals_ = 0, version_ = 1, sent_version_ = 0, floor_version_ = 0;
  double calibration_s_ = 0.0, behind_s_ = 0.0;
  Clock::time_point calibrated_at_{}, ticked_at_{}, synced_at_{}, row_at_ = Clock::now();
  std::thread worker_, syncer_;
};

}  // namespace octant::app

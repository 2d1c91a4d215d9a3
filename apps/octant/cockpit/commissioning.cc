// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/commissioning.h"

#include <algorithm>
#include <cmath>

#include <unistd.h>

#include "apps/octant/steps/steps.h"
#include "survey/geometry/make_survey_model.h"

namespace octant::app {
namespace {

using std::chrono::milliseconds;

constexpr int kReadTimeout_ms = 50;
constexpr milliseconds kTickPeriod{1000}, kSyncPeriod{500}, kQuietTime{200}, kLeastPause{300};
constexpr std::size_t kMostShownStopRows = 1000;

double seconds_of(std::chrono::steady_clock::duration span) {
  return std::chrono::duration<double>(span).count();
}

}  // namespace

Commissioning::Commissioning(CommissioningInput input, Session& session)
    : input_(std::move(input)),
      names_(input_.names()),
      session_(session),
      live_(input_.names(), input_.lateness_s, input_.deployment.has_value()),
      site_edit_(input_.path) {
  is_known_.assign(names_.beacons.size(), true);
  if (!input_.run.empty()) {
    recorder_.emplace(input_.run, input_.names(),
                      input_.site         ? input_.site->motion
                      : input_.deployment ? input_.deployment->motion
                                          : Motion::kPlanar,
                      input_.lateness_s);
    need(recorder_->begin(input_.run_yaml));
  }
  if (input_.deployment) {
    live_.use(*input_.deployment);
    if (auto model = survey::make_survey_model(*input_.deployment, view_.scene)) {
      view_.model = std::move(*model);
      view_.floor = floor_json(*view_.model, view_.scene, &*input_.deployment, session_.threads());
    }
    floor_version_ = 1;
  } else {
    worker_ = std::thread([this] { work(); });
  }
  if (recorder_) syncer_ = std::thread([this] { sync_disk(); });
}

Commissioning::~Commissioning() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  wake_.notify_all();
  if (worker_.joinable()) worker_.join();
  if (syncer_.joinable()) syncer_.join();
}

void Commissioning::learn(const NameTable& names) {
  const std::size_t before = is_known_.size();
  names_ = names;
  if (recorder_) recorder_->set_names(names_);
  const bool is_given =
      (input_.site || input_.deployment) && known_receivers_ == std::numeric_limits<std::size_t>::max();
  bool are_known = !input_.site && !input_.deployment;
  if (input_.site && !is_given && before < names_.beacons.size()) {
    const auto first = names_.beacons.begin() + static_cast<std::ptrdiff_t>(before);
    const auto added = reread(site_edit_.append({first, names_.beacons.end()}));
    are_known = added.has_value();
    if (!added) session_.warn(added.error().message());
  }
  is_known_.resize(names_.beacons.size(), are_known);
  if (!is_given) live_.set_names(names_);
}

/// Rows with names that the site file does not have are no part of the run.
void Commissioning::record(const io::LiveRow& row) {
  const auto* arrival = std::get_if<Arrival>(&row);
  const bool is_over = !recorder_ || !finished_.is_null();
  if (arrival != nullptr) {
    const bool is_known = is_known_[arrival->beacon.index()];
    if (!is_known) ++unknown_[names_.beacons[arrival->beacon.index()]];
    if (!is_known || arrival->receiver.index() >= known_receivers_) {
      if (!is_over) recorder_->add_unknown(*arrival, is_known ? "unknown_receiver" : "unknown_beacon");
      return;
    }
  }
  live_.add(row);
  if (!is_over) keep(row);
}

void Commissioning::keep(const io::LiveRow& row) {
  if (finish_order_) return held_rows_.push_back(row);
  if (const auto* arrival = std::get_if<Arrival>(&row)) recorder_->add(*arrival);
  if (const auto* step = std::get_if<OdometryStep>(&row)) recorder_->add(*step);
  if (const auto* pose = std::get_if<OdometryPose>(&row)) recorder_->add(*pose);
}

RowSource::Event Commissioning::advance(RowSource& source) {
  std::vector<io::LiveRow> rows;
  const auto event = source.read(kReadTimeout_ms, [&rows](const io::LiveRow& row) { rows.push_back(row); });
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  if (const NameTable* names = source.new_names()) learn(*names);
  for (const io::LiveRow& row : rows) record(row);
  if (!rows.empty()) row_at_ = now, ++version_;
  const bool is_quiet = now - row_at_ > kQuietTime;
  if (is_quiet && event != RowSource::Event::kRows) live_.flush();
  if (recorder_) {
    const auto written = recorder_->flush(is_quiet);
    recording_error_ = written ? "" : written.error().message();
  }
  if (event == RowSource::Event::kEnd && !is_source_over_) is_source_over_ = true, ++version_;
  source_ = source.description();
  bad_lines_ = source.bad_lines();
  behind_s_ = rows.empty() ? 0.0 : seconds_of(Clock::now() - now);
  if (now - ticked_at_ < kTickPeriod) return event;
  ticked_at_ = now;
  live_.tick();
  ++version_;
  wake_.notify_all();
  return event;
}

void Commissioning::close() {
  const std::lock_guard lock(mutex_);
  if (!recorder_) return;
  need(recorder_->flush(true));
  for (const int fd : recorder_->descriptors()) fdatasync(fd), ::close(fd);
}

/// Waits for the disk apart from the thread that records, which it must not delay.
void Commissioning::sync_disk() {
  std::unique_lock lock(mutex_);
  while (!is_closing_) {
    wake_.wait_for(lock, kSyncPeriod, [this] { return is_closing_; });
    const std::vector<int> files = recorder_->descriptors();
    lock.unlock();
    for (const int fd : files) fdatasync(fd), ::close(fd);
    lock.lock();
  }
}

/// A calibration pauses as long as it took, so that it uses at most half of a core.
bool Commissioning::is_calibration_due() const {
  if (!input_.site || !finished_.is_null()) return false;
  const double pause_s = std::max(calibration_s_, seconds_of(kLeastPause));
  return (is_site_changed_ || recorder_->counts().arrivals != calibrated_arrivals_) &&
         seconds_of(Clock::now() - calibrated_at_) > pause_s;
}

void Commissioning::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    while (!is_closing_ && !finish_order_ && !is_calibration_due()) wake_.wait_for(lock, kLeastPause);
    if (finish_order_) {
      const auto written = recorder_->flush(true);
      if (!written) recording_error_ = written.error().message();
      lock.unlock();
      Json finished = finish_commissioning(input_.path, input_.run, *finish_order_, session_);
      lock.lock();
      if (finished["deployment"].is_string()) finished_ = finished;
      tried_ = std::move(finished);
      finish_order_.reset();
      if (finished_.is_null())
        for (const io::LiveRow& row : held_rows_) keep(row);
      held_rows_.clear();
      ++version_;
      wake_.notify_all();
    }
    if (is_closing_) return;
    if (!is_calibration_due()) continue;
    calibrated_arrivals_ = recorder_->counts().arrivals;
    is_site_changed_ = false;
    is_calibrating_ = true;
    lock.unlock();
    const auto began = Clock::now();
    CalibrationView view = calibration_view(input_.path, input_.run, session_);
    lock.lock();
    if (calibrated_arrivals_ == 0) view.message.clear();
    calibrated_at_ = Clock::now();
    calibration_s_ = seconds_of(calibrated_at_ - began);
    is_calibrating_ = false;
    if (view.deployment) live_.use(*view.deployment);
    if (!view.floor.empty()) ++floor_version_;
    if (view.floor.empty()) view.floor = std::move(view_.floor);
    view_ = std::move(view);
    ++version_;
  }
}

void Commissioning::finish(bool accept) {
  std::unique_lock lock(mutex_);
  if (worker_.joinable() && finished_.is_null()) finish_order_ = accept;
  wake_.notify_all();
  wake_.wait(lock, [this] { return !finish_order_ || is_closing_; });
}

Json Commissioning::finished() const {
  const std::lock_guard lock(mutex_);
  return tried_;
}

RecorderCounts Commissioning::counts() const {
  const std::lock_guard lock(mutex_);
  return recorder_ ? recorder_->counts() : RecorderCounts();
}

std::string Commissioning::next_event() {
  {
    const std::lock_guard lock(mutex_);
    if (version_ == sent_version_) return "";
    sent_version_ = version_;
  }
  return "event: state\ndata: " + dump(state()) + "\n\n";
}

Json Commissioning::light() const {
  const bool has_verdict = view_.calibration.is_object();
  const std::string grade = has_verdict ? view_.calibration["verdict"]["grade"].get<std::string>() : "";
  const std::string words = has_verdict ? view_.calibration["verdict"]["sentence"].get<std::string>()
                            : !view_.message.empty()           ? view_.message
                            : recorder_->counts().arrivals > 0 ? "Calibrating ..."
                                                               : "No arrival yet.";
  if (!recording_error_.empty())
    return {{"colour", "not_yet"}, {"grade", nullptr}, {"words", "Recording failed. " + recording_error_}};
  const char* colour = grade == "Good" ? "good" : grade == "Contradicted" ? "contradicted" : "not_yet";
  return {{"colour", colour}, {"grade", has_verdict ? Json(grade) : Json(nullptr)}, {"words", words}};
}

Json Commissioning::stops_json() const {
  Json stops = Json::array();
  const auto& all = recorder_->stops();
  auto at = std::prev(all.end(), static_cast<std::ptrdiff_t>(std::min(all.size(), kMostShownStopRows)));
  for (; at != all.end(); ++at) {
    Json stop = {{"epoch", at->first},
                 {"first_s", at->second.first_s},
                 {"last_s", at->second.last_s},
                 {"arrivals", at->second.arrivals},
                 {"beacons", at->second.beacons.size()}};
    if (const auto p = recorder_->points().find(at->first); p != recorder_->points().end())
      stop["control_point"] = {{"name", p->second.name},
                               {"x_m", p->second.x_m},
                               {"y_m", p->second.y_m},
                               {"sigma_m", p->second.sigma_m}};
    stops.push_back(std::move(stop));
  }
  return stops;
}

Json Commissioning::stated_m(const std::string& beacon) const {
  if (input_.deployment)
    for (const DeploymentBeacon& b : input_.deployment->beacons)
      if (b.name == beacon) return b.position_m;
  if (input_.site)
    for (const SiteBeacon& b : input_.site->beacons)
      if (const auto place = b.place_m(); place && b.name == beacon) return *place;
  return nullptr;
}

void Commissioning::add_recording(Json& state) const {
  static constexpr std::array<const char*, 4> kModes = {"undecided", "rows", "marked", "drive"};
  state["recording"] = nullptr;
  state["stops"] = Json::array();
  state["open_stop"] = nullptr;
  if (!recorder_) return;
  const RecorderCounts& c = recorder_->counts();
  state["recording"] = {{"folder", recorder_->folder()},
                        {"arrivals", c.arrivals},
                        {"odometry_rows", c.odometry},
                        {"late", c.late},
                        {"between_stops", c.between_stops},
                        {"deleted", c.deleted},
                        {"stop_is_over", c.stop_is_over},
                        {"late_odometry", c.late_odometry},
                        {"unknown", c.unknown},
                        {"lost", c.lost},
                        {"clock_steps", c.clock_steps},
                        {"behind_s", behind_s_},
                        {"error", recording_error_},
                        {"stop_mode", kModes[static_cast<std::size_t>(recorder_->mode())]}};
  if (recorder_->open_stop()) state["open_stop"] = *recorder_->open_stop();
  state["stops"] = stops_json();
}

Json Commissioning::state() const {
  const std::lock_guard lock(mutex_);
  const Tolerance tolerance = input_.site         ? input_.site->tolerance
                              : input_.deployment ? input_.deployment->tolerance
                                                  : Tolerance();
  Json state = {{"type", "octant_cockpit"},
                {"version", 1},
                {"mode", input_.site         ? "commissioning"
                         : input_.deployment ? "monitoring"
                                             : "setup"},
                {"site", input_.site         ? input_.site->name
                         : input_.deployment ? input_.deployment->site
                                             : ""},
                {"site_file", input_.path},
                {"site_changes", site_edit_.changes()},
                {"tolerance",
                 {{"beacon_m", tolerance.beacon_m ? Json(*tolerance.beacon_m) : Json(nullptr)},
                  {"fix_m", tolerance.fix_m ? Json(*tolerance.fix_m) : Json(nullptr)}}},
                {"source", {{"name", source_}, {"is_over", is_source_over_}, {"bad_lines", bad_lines_}}}};
  live_.add_to(state);
  for (std::size_t b = 0; b < state["beacons"].size(); ++b) {
    Json& beacon = state["beacons"][b];
    beacon["stated_m"] = stated_m(beacon["id"].get<std::string>());
  }
  add_recording(state);
  state["calibration"] = view_.calibration;
  state["calibrating"] = is_calibrating_;
  state["calibration_s"] = calibration_s_;
  state["next_stop"] = view_.next_stop;
  state["light"] = input_.site ? light() : Json(nullptr);
  state["receivers"] = Json::array();
  for (const auto& r : names_.receivers)
    state["receivers"].push_back(names_.vehicles[r.vehicle.index()] + "/" + r.name);
  state["floor_version"] = view_.floor.empty() ? 0 : floor_version_;
  state["finishing"] = finish_order_.has_value();
  state["finished"] = finished_;
  state["finish_failure"] = tried_.is_object() && finished_.is_null() ? tried_["message"] : Json("");
  state["unknown_beacons"] = unknown_;
  state["operator"] = operator_.empty() ? Json(nullptr) : Json(operator_);
  return state;
}

}  // namespace octant::app

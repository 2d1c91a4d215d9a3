// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/row_source.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "io/site/site_id.h"
#include "io/text/text.h"

namespace octant::app {
namespace {

/// A name in a line; empty if a site file cannot have it as an id.
std::string stream_name(const Json& line, const char* key, const std::string& otherwise) {
  const auto at = line.find(key);
  if (at == line.end() || at->is_null()) return otherwise;
  const std::string name = at->is_string()           ? at->get<std::string>()
                           : at->is_number_integer() ? at->dump()
                                                     : "";
  return io::is_site_id(name) ? name : "";
}

class LineSource : public RowSource {
 public:
  LineSource(std::string where, ByteSource source, std::optional<NameTable> names, double constant_speed_mps,
             Session& session)
      : where_(std::move(where)),
        source_(std::move(source)),
        speed_mps_(constant_speed_mps),
        reader_(names.value_or(NameTable()), constant_speed_mps),
        session_(session),
        names_(names.value_or(NameTable())),
        learns_all_(!names),
        given_beacons_(names ? names->beacons.size() : kMostBeacons) {}

  Event read(int timeout_ms, const Sink& sink) override {
    using From = ByteSource::Event;
    if (is_over_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
      return Event::kEnd;
    }
    const From event = source_.wait(timeout_ms);
    const auto line = [&](std::string_view text) {
      ++lines_;
      auto row = reader_.row(text);
      if (!row && learn_names(text)) row = reader_.row(text);
      if (!row) return bad_.add(row.error().message(), lines_, session_);
      if (const auto* arrival = std::get_if<Arrival>(&*row);
          arrival != nullptr && arrival->beacon.index() >= given_beacons_)
        bad_.add("unknown beacon " + io::in_quotes(names_.beacons[arrival->beacon.index()]), lines_,
                 session_);
      sink(*row);
    };
    const auto too_long = [this] { bad_.add("a line of more than 65536 bytes", ++lines_, session_); };
    if (event == From::kBytes) cutter_.feed(source_.bytes(), line, too_long);
    if (event == From::kBreak || event == From::kEnd || event == From::kFailed) cutter_.end(line, too_long);
    if (event == From::kFailed) session_.warn(fmt::format("{}: {}", where_, source_.why()));
    is_over_ = event == From::kEnd || event == From::kFailed;
    return is_over_ ? Event::kEnd : event == From::kQuiet ? Event::kQuiet : Event::kRows;
  }
  [[nodiscard]] std::string description() const override { return where_; }
  [[nodiscard]] const NameTable* new_names() override {
    return std::exchange(has_new_names_, false) ? &names_ : nullptr;
  }
  [[nodiscard]] std::map<std::string, std::size_t> bad_lines() const override { return bad_.kinds(); }

 private:
  /// Adds the names of a line that is a valid row with them. @return false if there is no new one
  bool learn_names(std::string_view text) {
    const Json line = Json::parse(text, nullptr, false);
    if (!line.is_object()) return false;
    NameTable more = names_;
    const std::string vehicle = stream_name(line, "vehicle", "robot"),
                      beacon = stream_name(line, "beacon", "");
    bool is_new = false;
    const auto add = [&is_new](auto& list, auto entry, std::size_t most) {
      if (list.size() < most) list.push_back(std::move(entry)), is_new = true;
    };
    if (!beacon.empty() && !more.find_beacon(beacon).valid()) add(more.beacons, beacon, kMostBeacons);
    if (learns_all_) {
      if (!vehicle.empty() && !more.find_vehicle(vehicle).valid()) add(more.vehicles, vehicle, kMostVehicles);
      const VehicleId id = more.find_vehicle(vehicle);
      const std::string receiver = stream_name(line, "receiver", "r0");
      const bool has = std::ranges::any_of(
          more.receivers, [&](const auto& r) { return r.vehicle == id && r.name == receiver; });
      if (id.valid() && !beacon.empty() && !receiver.empty() && !has)
        add(more.receivers, NameTable::Receiver{receiver, id}, kMostReceivers);
    }
    if (!is_new) return false;
    io::LiveReader reader(more, speed_mps_);
    if (!reader.row(text)) return false;
    names_ = std::move(more);
    reader_ = std::move(reader);
    return has_new_names_ = true;
  }

  static constexpr std::size_t kMostBeacons = 1000, kMostReceivers = 100, kMostVehicles = 20;
  std::string where_;
  ByteSource source_;
  double speed_mps_;
  io::LineCutter cutter_;
  io::LiveReader reader_;
  Session& session_;
  BadLines bad_;
  NameTable names_;
  std::size_t lines_ = 0;
  bool is_over_ = false, has_new_names_ = false, learns_all_;  ///< or beacons only
  std::size_t given_beacons_;                                  ///< that are no invalid lines
};

class ReplaySource : public RowSource {
 public:
  ReplaySource(MeasurementLog run, double speed) : run_(std::move(run)), speed_(speed) {
    const double infinity = std::numeric_limits<double>::infinity();
    first_s_ = std::min(run_.arrivals.empty() ? infinity : run_.arrivals.front().time_s,
                        run_.odometry.empty() ? infinity : run_.odometry.front().time_s);
  }

  Event read(int timeout_ms, const Sink& sink) override {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began_;
    const double until_s =
        speed_ > 0 ? first_s_ + speed_ * passed.count() : std::numeric_limits<double>::infinity();
    std::size_t rows = 0;
    while (rows < kMostRows && pass_next(until_s, sink)) ++rows;
    const bool is_over = arrival_ == run_.arrivals.size() && step_ == run_.odometry.size();
    if (rows == 0) std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    return rows > 0 ? Event::kRows : is_over ? Event::kEnd : Event::kQuiet;
  }
  [[nodiscard]] std::string description() const override { return run_.path; }

 private:
  static constexpr std::size_t kMostRows = 2000;  ///< in one call, so that commands are served meanwhile

  bool pass_next(double until_s, const Sink& sink) {
    const bool has_step = step_ < run_.odometry.size(), has_arrival = arrival_ < run_.arrivals.size();
    if (has_step && (!has_arrival || run_.odometry[step_].time_s <= run_.arrivals[arrival_].time_s)) {
      if (run_.odometry[step_].time_s > until_s) return false;
      sink(run_.odometry[step_++]);
      return true;
    }
    if (!has_arrival || run_.arrivals[arrival_].time_s > until_s) return false;
    sink(run_.arrivals[arrival_++]);
    return true;
  }

  MeasurementLog run_;
  double speed_, first_s_ = 0.0;
  std::size_t arrival_ = 0, step_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace

namespace {

std::unique_ptr<RowSource> open_stream(const std::string& where, std::optional<NameTable> names,
                                       double constant_speed_mps, Session& session) {
  constexpr std::string_view kSerial = "serial:";
  const std::string path = where == "stdin"             ? "-"
                           : where.starts_with(kSerial) ? where.substr(kSerial.size())
                                                        : where;
  ByteSource source = need(ByteSource::open(path));
  if (!source.listens().empty()) session.note(source.listens());
  return std::make_unique<LineSource>(where, std::move(source), std::move(names), constant_speed_mps,
                                      session);
}

}  // namespace

std::unique_ptr<RowSource> open_line_source(const std::string& where, NameTable names,
                                            double constant_speed_mps, Session& session) {
  return open_stream(where, std::move(names), constant_speed_mps, session);
}

std::unique_ptr<RowSource> open_nameless_source(const std::string& where, Session& session) {
  return open_stream(where, std::nullopt, 0.0, session);
}

std::unique_ptr<RowSource> replay_source(MeasurementLog run, double speed) {
  return std::make_unique<ReplaySource>(std::move(run), speed);
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/row_source.h"

#include <algorithm>
#include <limits>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace octant::app {
namespace {

class LineSource : public RowSource {
 public:
  LineSource(std::string where, ByteSource source, NameTable names, double constant_speed_mps,
             Session& session)
      : where_(std::move(where)),
        source_(std::move(source)),
        reader_(std::move(names), constant_speed_mps),
        session_(session) {}

  Event read(int timeout_ms, const Sink& sink) override {
    using From = ByteSource::Event;
    if (is_over_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
      return Event::kEnd;
    }
    const From event = source_.wait(timeout_ms);
    const auto line = [&](std::string_view text) {
      ++lines_;
      const auto row = reader_.row(text);
      if (row) return sink(*row);
      bad_.add(row.error().message(), lines_, session_);
    };
    const auto too_long = [this] { bad_.add("a line of more than 65536 bytes", ++lines_, session_); };
    if (event == From::kBytes) cutter_.feed(source_.bytes(), line, too_long);
    if (event == From::kBreak || event == From::kEnd || event == From::kFailed) cutter_.end(line, too_long);
    if (event == From::kFailed) session_.warn(fmt::format("{}: {}", where_, source_.why()));
    is_over_ = event == From::kEnd || event == From::kFailed;
    return is_over_ ? Event::kEnd : event == From::kQuiet ? Event::kQuiet : Event::kRows;
  }
  [[nodiscard]] std::string description() const override { return where_; }
  [[nodiscard]] std::map<std::string, std::size_t> bad_lines() const override { return bad_.kinds(); }

 private:
  std::string where_;
  ByteSource source_;
  io::LineCutter cutter_;
  io::LiveReader reader_;
  Session& session_;
  BadLines bad_;
  std::size_t lines_ = 0;
  bool is_over_ = false;
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

std::unique_ptr<RowSource> open_line_source(const std::string& where, NameTable names,
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

std::unique_ptr<RowSource> replay_source(MeasurementLog run, double speed) {
  return std::make_unique<ReplaySource>(std::move(run), speed);
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/live_target.h"

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "io/live/live_fixes.h"
#include "io/live/live_rows.h"
#include "models/live/follower.h"
#include "models/simulator/synthetic.h"
#include "tests/fuzz/must.h"
#include "tests/support/worlds.h"

namespace octant::fuzz {
namespace {

/// The tests' hall with a second vehicle, of one receiver.
const Deployment& live_hall() {
  static const Deployment hall = [] {
    Scenario scenario = test::hall_scenario();
    test::add_receivers(scenario.site, {{0.1, 0.0, 0.3}}, 0.0, "cart");
    scenario.path.epochs = scenario.heldout_path.epochs = 2;
    return test::must(simulate(scenario, 1)).truth;
  }();
  return hall;
}

/// A line that a listener gets.
void must_be_line(const std::string& text) {
  if (text.empty()) return;
  must(text.back() == '\n', "lines have an end");
  if (text.front() == '$') {
    must(text.find("nan") == std::string::npos && text.find("inf") == std::string::npos,
         "numbers are finite");
    must(text[text.size() - 2] == '\r' && text.find('*') != std::string::npos, "sentences have their sum");
  } else {
    must(nlohmann::json::accept(text), "a line is JSON");
  }
}

struct Followed {
  std::string out;
  FollowCounts counts;
};

Followed follow_in_pieces(std::string_view stream, const FollowOptions& options, std::size_t piece) {
  const NameTable names = names_of(live_hall());
  const io::LiveReader reader(names);
  Follower follower(live_hall(), options);
  io::LineCutter cutter(400);
  Followed all;
  follower.on_fix = [&](const Fix& fix) {
    for (const std::string& text : {io::fix_as_json(fix, names), io::fix_as_ros(fix, names),
                                    io::fix_as_nmea(fix, {48.1, 17.1, 150, 1.2})}) {
      must_be_line(text);
      all.out += text;
    }
    if (fix.ok())
      must(fix.T_map_vehicle.translation_m.allFinite() && fix.covariance.allFinite(), "a fix is a place");
  };
  follower.on_alarm = [&](const WatchAlarm& alarm) {
    must_be_line(io::alarm_as_json(alarm, names));
    must_be_line(io::alarm_as_nmea(alarm, names));
  };
  const auto line = [&](std::string_view text) {
    const auto row = reader.row(text);
    must_explain(row);
    if (!row) return;
    if (const auto* arrival = std::get_if<Arrival>(&*row)) follower.hear(*arrival);
    if (const auto* step = std::get_if<OdometryStep>(&*row)) follower.move(*step);
    if (std::holds_alternative<io::LiveFlush>(*row)) follower.flush();
  };
  const auto too_long = [] {};
  for (; !stream.empty(); stream.remove_prefix(std::min(piece, stream.size())))
    cutter.feed(stream.substr(0, piece), line, too_long);
  cutter.end(line, too_long);
  follower.flush();
  all.counts = follower.counts();
  must(all.counts.used + all.counts.rejected + all.counts.dropped <= all.counts.arrivals,
       "no arrival counts twice");
  return all;
}

}  // namespace

void take_live(std::string_view input) {
  if (input.empty()) return;
  const auto choice = static_cast<unsigned char>(input.front());
  FollowOptions options;
  options.most_waiting = 16;
  options.watch = choice % 2 == 1;
  static constexpr std::array kMethods = {Method::kAuto, Method::kLeastSquares, Method::kTracker,
                                          Method::kKleeman};
  options.method = kMethods[choice / 2 % kMethods.size()];
  if (!follow_fits(live_hall(), options.method)) options.method = Method::kAuto;
  input.remove_prefix(1);
  const Followed whole = follow_in_pieces(input, options, input.size() + 1);
  must(whole.out == follow_in_pieces(input, options, 7).out, "pieces make no difference");
}

}  // namespace octant::fuzz

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Requests of the page.
#include <algorithm>
#include <cmath>

#include "apps/octant/cockpit/commissioning.h"
#include "apps/octant/cockpit/page.h"
#include "io/site/site_yaml.h"
#include "models/support/largest.h"

namespace octant::app {
namespace {

constexpr std::size_t kLongestWord = 64;
constexpr double kDefaultPointSigma_m = 0.005;

tl::unexpected<Error> not_obeyed(std::string found, std::string expected) {
  return fail({.code = Errc::kUsage, .found = std::move(found), .expected = std::move(expected)});
}

/// Short text of a key; empty if it is missing or something else.
std::string word_of(const Json& command, const char* key) {
  const auto at = command.find(key);
  if (at == command.end() || !at->is_string()) return "";
  const std::string text = at->get<std::string>();
  return text.size() <= kLongestWord ? text : "";
}

double number_of(const Json& command, const char* key, double otherwise) {
  const auto at = command.find(key);
  if (at == command.end()) return otherwise;
  return at->is_number() ? at->get<double>() : std::nan("");
}

bool is_length(double value_m) { return std::isfinite(value_m) && std::abs(value_m) <= kLargestLength_m; }

}  // namespace

HttpResponse Commissioning::answer(const HttpRequest& request) {
  if (request.method == "POST") {
    if (request.path != "/api/command" && request.path != "/api/floor")
      return http_error(404, "There is no such command.");
    const Json command = Json::parse(request.body, nullptr, false);
    if (!command.is_object()) return http_error(400, "The body is not a JSON object.");
    return request.path == "/api/floor" ? floor_if(command) : obey(command);
  }
  if (request.path == "/") return {.type = "text/html", .body = std::string(cockpit_html())};
  if (request.path == "/cockpit.js") return {.type = "text/javascript", .body = std::string(cockpit_js())};
  if (request.path == "/plan.js") return {.type = "text/javascript", .body = std::string(cockpit_plan_js())};
  if (request.path == "/cockpit.css") return {.type = "text/css", .body = std::string(cockpit_css())};
  if (request.path == "/api/state") return {.body = dump(state())};
  if (request.path == "/api/events")
    return {.type = "text/event-stream",
            .body = "retry: 1000\n\nevent: state\ndata: " + dump(state()) + "\n\n",
            .is_stream = true};
  if (request.path == "/api/floor") {
    const std::lock_guard lock(mutex_);
    return {.body = view_.floor.empty() ? "null" : view_.floor};
  }
  return http_error(404, "There is no such page.");
}

HttpResponse Commissioning::floor_if(const Json& question) const {
  std::unique_lock lock(mutex_);
  if (!view_.model) return http_error(422, "There is no geometry yet: too few beacons have a position.");
  survey::SurveyModel model = *view_.model;
  const Scene scene = view_.scene;
  lock.unlock();
  const auto moves = question.find("moves");
  if (moves == question.end() || !moves->is_array()) return http_error(400, "The key 'moves' is a list.");
  for (const Json& move : *moves) {
    if (!move.is_object()) return http_error(400, "A move has the keys id, x_m and y_m.");
    const double x_m = number_of(move, "x_m", std::nan("")), y_m = number_of(move, "y_m", std::nan(""));
    const auto beacon = std::ranges::find(model.beacons, word_of(move, "id"), &survey::SurveyBeacon::name);
    if (beacon == model.beacons.end() || !is_length(x_m) || !is_length(y_m))
      return http_error(422, "A move has the id of a beacon with a position, x_m and y_m in metres.");
    beacon->p_map_m.head<2>() << x_m, y_m;
  }
  const std::string floor = floor_json(std::move(model), scene, nullptr, 1);
  return {.body = floor.empty() ? "null" : floor};
}

HttpResponse Commissioning::obey(const Json& command) {
  const std::string client = word_of(command, "client"), what = word_of(command, "do");
  if (client.empty() || what.empty())
    return http_error(400, "A command has the keys 'do' and 'client', texts of at most 64 bytes.");
  const std::lock_guard lock(mutex_);
  if (operator_.empty() || what == "take_over") operator_ = client;
  if (operator_ != client) return http_error(409, "Another page operates this cockpit. Take over first.");
  const auto done = what == "take_over" ? Result<void>() : carry_out(what, command);
  ++version_;
  wake_.notify_all();
  if (!done) return http_error(422, done.error().message());
  return {.body = dump(Json{{"ok", true}})};
}

Result<void> Commissioning::carry_out(const std::string& what, const Json& command) {
  if (input_.deployment || !recorder_)
    return not_obeyed("a deployment is monitored", "commands belong to a commissioning");
  if (what == "set_site") return set_site(command);
  if (!finished_.is_null() || finish_order_) return not_obeyed("the run is finished", "a run in progress");
  if (what == "begin_stop") {
    const auto begun = recorder_->begin_stop();
    return begun ? Result<void>() : fail(begun.error());
  }
  if (what == "end_stop") return recorder_->end_stop();
  if (what == "delete_stop") {
    const auto epoch = command.find("epoch");
    if (epoch == command.end() || !epoch->is_number_integer())
      return not_obeyed("epoch is missing or no integer", "the epoch of a stop");
    is_site_changed_ = true;
    return recorder_->delete_stop(epoch->get<std::int64_t>());
  }
  if (what == "control_point") return set_point(command);
  if (!input_.site) return not_obeyed("the site is not described yet", "the command set_site first");
  if (what == "exchange") return reread(site_edit_.exchange(word_of(command, "a"), word_of(command, "b")));
  if (what == "undo") return reread(site_edit_.undo());
  if (what == "finish") {
    const auto accept = command.find("accept");
    finish_order_ = accept != command.end() && accept->is_boolean() && accept->get<bool>();
    return {};
  }
  return not_obeyed(
      "an unknown command",
      "begin_stop, end_stop, delete_stop, control_point, exchange, undo, set_site, finish or take_over");
}

Result<void> Commissioning::reread(Result<void> changed) {
  if (!changed) return changed;
  auto site = io::read_site(input_.path);
  if (!site) return fail(site.error());
  input_.site = std::move(*site);
  is_site_changed_ = true;
  return {};
}

Result<void> Commissioning::set_point(const Json& command) {
  const ControlPoint point{number_of(command, "x_m", std::nan("")), number_of(command, "y_m", std::nan("")),
                           number_of(command, "sigma_m", kDefaultPointSigma_m), word_of(command, "name")};
  if (!is_length(point.x_m) || !is_length(point.y_m) || !is_length(point.sigma_m) || !(point.sigma_m > 0))
    return not_obeyed("x_m, y_m or sigma_m is missing or no length", "metres, and a sigma_m above 0");
  const auto& stops = recorder_->stops();
  const auto epoch = command.find("epoch");
  if (epoch != command.end() && !epoch->is_number_integer())
    return not_obeyed("epoch is no integer", "the epoch of a stop");
  if (epoch == command.end() && stops.empty() && !recorder_->open_stop())
    return not_obeyed("there is no stop yet", "a stop at the control point");
  is_site_changed_ = true;
  return recorder_->set_point(epoch != command.end()   ? epoch->get<std::int64_t>()
                              : recorder_->open_stop() ? *recorder_->open_stop()
                                                       : stops.rbegin()->first,
                              point);
}

}  // namespace octant::app

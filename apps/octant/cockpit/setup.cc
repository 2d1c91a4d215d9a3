// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A site file from the names that are received and a few answers of the operator.
#include <algorithm>
#include <cmath>

#include "apps/octant/cockpit/commissioning.h"
#include "apps/octant/help/site_template.h"
#include "io/run/run_ids.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "models/support/largest.h"

namespace octant::app {
namespace {

tl::unexpected<Error> bad_answer(const std::string& found, const std::string& expected) {
  return fail({.code = Errc::kUsage, .found = found, .expected = expected});
}

/// Text of a key; empty if it is missing or no text.
std::string answer_text(const Json& answers, const char* key) {
  const auto at = answers.find(key);
  return at != answers.end() && at->is_string() ? at->get<std::string>() : "";
}

/// A length; the fallback if it is missing or null, NaN if it is no length.
double answer_length_m(const Json& answers, const char* key, double otherwise_m) {
  const auto at = answers.find(key);
  if (at == answers.end() || at->is_null()) return otherwise_m;
  const double value_m = at->is_number() ? at->get<double>() : std::nan("");
  return std::abs(value_m) <= kLargestLength_m ? value_m : std::nan("");
}

void append_missing(const std::string& name, std::vector<std::string>& names) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

/// Names of the recording in their natural order (r2 before r10), then those that have no valid row yet.
Result<io::RunIds> ids_of(const std::string& run, const NameTable& names) {
  auto ids = io::read_run_ids(run);
  if (!ids) return ids;
  for (const std::string& beacon : names.beacons) append_missing(beacon, ids->beacons);
  for (io::RunIds::Vehicle& vehicle : ids->vehicles)
    for (const auto& receiver : names.receivers)
      if (names.vehicles[receiver.vehicle.index()] == vehicle.name)
        append_missing(receiver.name, vehicle.receivers);
  return ids;
}

/// Positions that the operator has given; the others remain unknown.
Result<void> place_beacons(const Json& beacons, Site& site) {
  for (const Json& given : beacons) {
    const std::string id = given.is_object() ? answer_text(given, "id") : "";
    const auto beacon = std::ranges::find(site.beacons, id, &SiteBeacon::name);
    const double x_m = given.is_object() ? answer_length_m(given, "x_m", std::nan("")) : std::nan(""),
                 y_m = given.is_object() ? answer_length_m(given, "y_m", std::nan("")) : std::nan("");
    if (beacon == site.beacons.end() || !std::isfinite(x_m) || !std::isfinite(y_m))
      return bad_answer("a beacon without a received id, x_m and y_m", "lengths in metres");
    const double sigma_m = answer_length_m(given, "sigma_m", 0.5),
                 z_m = answer_length_m(given, "z_m", std::nan(""));
    if (!(sigma_m >= 0)) return bad_answer("sigma_m is no standard deviation", "0 or more, in metres");
    beacon->position_m = {x_m, y_m, std::nullopt};
    beacon->sigma_m = {sigma_m, sigma_m, std::nullopt};
    if (std::isfinite(z_m)) beacon->position_m[2] = z_m, beacon->sigma_m[2] = sigma_m;
  }
  return {};
}

/// Receivers evenly on a ring around the origin, the first one ahead; a single one at the origin.
void place_receivers(double radius_m, double height_m, Site& site) {
  for (SiteVehicle& vehicle : site.vehicles)
    for (std::size_t i = 0; i < vehicle.receiver_count; ++i) {
      const double turn = 2 * M_PI * static_cast<double>(i) / static_cast<double>(vehicle.receiver_count),
                   r = vehicle.receiver_count > 1 ? radius_m : 0.0;
      site.receivers[vehicle.first_receiver + i].position_m = {r * std::cos(turn), r * std::sin(turn),
                                                               height_m};
    }
}

}  // namespace

Result<void> Commissioning::set_site(const Json& answers) {
  if (input_.site) return bad_answer("there is a site file", "a cockpit that began without one");
  if (names_.beacons.empty()) return bad_answer("no beacon is received yet", "a stream of arrivals");
  const std::string kind = answers.contains("kind") ? answer_text(answers, "kind") : "ultrasound";
  if (kind != "ultrasound" && kind != "uwb" && kind != "underwater")
    return bad_answer("an unknown kind", "ultrasound, uwb or underwater");
  const auto medium = kind == "uwb"          ? SiteKind::kUwb
                      : kind == "underwater" ? SiteKind::kUnderwater
                                             : SiteKind::kUltrasound;
  const double radius_m = answer_length_m(answers, "ring_radius_m", 0.1),
               height_m = answer_length_m(answers, "height_m", 0.3),
               beacon_m = answer_length_m(answers, "beacon_m", 0.03),
               fix_m = answer_length_m(answers, "fix_m", 0.05);
  if (!(radius_m > 0) || !std::isfinite(height_m) || !(beacon_m > 0) || !(fix_m > 0))
    return bad_answer("ring_radius_m, height_m, beacon_m or fix_m is no length", "metres");
  if (auto flushed = recorder_->flush(true); !flushed) return flushed;
  const auto ids = ids_of(input_.run, names_);
  if (!ids) return fail(ids.error());
  const std::string path = input_.run + "/site.yaml";
  auto site = read_text_as_site(path, site_template(medium, "site", *ids));
  if (!site) return fail(site.error());
  const auto temperature = answers.find("temperature_degC");
  if (temperature != answers.end() && temperature->is_number())
    site->medium.temperature_degC = temperature->get<double>();
  place_receivers(radius_m, height_m, *site);
  site->tolerance = {beacon_m, fix_m};
  if (const auto beacons = answers.find("beacons"); beacons != answers.end() && beacons->is_array())
    if (auto placed = place_beacons(*beacons, *site); !placed) return placed;
  const std::string text = io::site_to_yaml(*site);
  if (const auto read = read_text_as_site(path, text); !read) return fail(read.error());
  if (auto written = io::write_file(path, text); !written) return written;
  known_receivers_ = names_.receivers.size();
  input_.path = path;
  site_edit_ = SiteEdit(path);
  return reread({});
}

}  // namespace octant::app

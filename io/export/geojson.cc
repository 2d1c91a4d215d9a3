// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "io/export/exported.h"

namespace octant::io {
namespace {

using GeoJson = nlohmann::ordered_json;

/// Longitude, latitude (to 1e-9 degrees, a tenth of a millimetre), height.
GeoJson coordinates(const Eigen::Vector3d& p_map_m, const EarthOrigin& origin) {
  const EarthPlace place = place_on_earth(p_map_m, origin);
  const auto rounded = [](double value, double digits) { return std::round(value * digits) / digits; };
  return GeoJson::array(
      {rounded(place.longitude_deg, 1e9), rounded(place.latitude_deg, 1e9), rounded(place.altitude_m, 1e4)});
}

GeoJson geo_feature(const char* kind, GeoJson where, GeoJson properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", kind}, {"coordinates", std::move(where)}}},
          {"properties", std::move(properties)}};
}

GeoJson of_fix(const Fix& fix, const NameTable& names, const EarthOrigin& origin) {
  const Pose& T = fix.T_map_vehicle;
  GeoJson about = {{"kind", "fix"}, {"time_s", fix.time_s}};
  if (fix.vehicle.valid() && fix.vehicle.index() < names.vehicles.size())
    about["vehicle"] = names.vehicles[fix.vehicle.index()];
  about["x_m"] = T.translation_m.x();
  about["y_m"] = T.translation_m.y();
  about["z_m"] = T.translation_m.z();
  about["heading_rad"] = T.heading_rad();
  if (fix.covariance.rows() >= 3) {
    about["sigma_x_m"] = std::sqrt(std::max(fix.covariance(0, 0), 0.0));
    about["sigma_y_m"] = std::sqrt(std::max(fix.covariance(1, 1), 0.0));
  }
  if (fix.protection_level_m > 0) about["protection_level_m"] = fix.protection_level_m;
  return geo_feature("Point", coordinates(T.translation_m, origin), std::move(about));
}

void add_line(GeoJson& features, GeoJson line, GeoJson about) {
  if (line.size() > 1) features.push_back(geo_feature("LineString", std::move(line), std::move(about)));
}

}  // namespace

std::string to_geojson(const ExportedContent& content, const EarthOrigin& origin) {
  GeoJson features = GeoJson::array();
  for (const ExportedBeacon& b : content.beacons) {
    GeoJson about = {{"kind", "beacon"},
                     {"id", b.id},
                     {"x_m", b.position_m.x()},
                     {"y_m", b.position_m.y()},
                     {"z_m", b.position_m.z()}};
    if (b.sigma_m > 0) about["sigma_m"] = b.sigma_m;
    features.push_back(geo_feature("Point", coordinates(b.position_m, origin), std::move(about)));
  }
  for (const ExportedFixes& track : content.tracks) {
    std::vector<GeoJson> lines(track.names.vehicles.size() + 1, GeoJson::array());
    for (const Fix& fix : track.fixes) {
      if (!fix.ok()) continue;
      const std::size_t vehicle = fix.vehicle.valid()
                                      ? std::min(fix.vehicle.index(), track.names.vehicles.size())
                                      : track.names.vehicles.size();
      lines[vehicle].push_back(coordinates(fix.T_map_vehicle.translation_m, origin));
      features.push_back(of_fix(fix, track.names, origin));
    }
    for (std::size_t v = 0; v < lines.size(); ++v) {
      GeoJson about = {{"kind", "track"}};
      if (v < track.names.vehicles.size()) about["vehicle"] = track.names.vehicles[v];
      add_line(features, std::move(lines[v]), std::move(about));
    }
  }
  for (const ExportedRun& run : content.runs) {
    const std::pair<const std::vector<TimedPose>*, const char*> tracks[] = {{&run.log.poses, "poses"},
                                                                            {&run.log.truth, "truth"}};
    for (const auto& [poses, kind] : tracks) {
      GeoJson line = GeoJson::array();
      for (const TimedPose& pose : *poses)
        line.push_back(coordinates(pose.T_map_vehicle.translation_m, origin));
      add_line(features, std::move(line), {{"kind", kind}});
    }
  }
  const GeoJson all = {{"type", "FeatureCollection"},
                       {"octant",
                        {{"site", content.site},
                         {"datum", "WGS 84"},
                         {"origin",
                          {{"latitude_deg", origin.latitude_deg},
                           {"longitude_deg", origin.longitude_deg},
                           {"altitude_m", origin.altitude_m},
                           {"north_rad", origin.north_rad}}}}},
                       {"features", std::move(features)}};
  return all.dump(1, ' ', false, GeoJson::error_handler_t::replace) + "\n";
}

}  // namespace octant::io

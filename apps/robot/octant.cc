// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/robot/octant/octant.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "apps/robot/octant/positioner.h"

struct octant_positioner {
  octant::Positioner positioner;
  octant_options options;
  double temperature_degC;
  std::vector<octant::Heard> heard;  ///< reused by octant_locate
};

namespace {

using octant::Heard;
using octant::Place;

/// Holds the text in a fixed size, so that a failure of the memory can be described too.
thread_local char last_error[1024] = "";

octant_result fail(octant_result result, const char* text) noexcept {
  const std::size_t size = std::min(std::char_traits<char>::length(text), sizeof last_error - 1);
  std::copy_n(text, size, last_error);
  last_error[size] = '\0';
  return result;
}

/// Calls a function and converts exceptions into results.
template <class Function>
octant_result guarded(Function&& function) noexcept {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return fail(OCTANT_OUT_OF_MEMORY, "There is not enough memory.");
  } catch (const std::exception& error) {
    return fail(OCTANT_FAULT, error.what());
  } catch (...) {
    return fail(OCTANT_FAULT, "A callback threw an exception.");
  }
}

std::string_view text_of(const char* text) { return text == nullptr ? std::string_view() : text; }

octant_fix fix_of(const Place& place) {
  octant_fix fix = {};
  fix.ok = place.ok ? 1 : 0;
  fix.status = place.status;
  fix.integrity = place.integrity;
  fix.integrity_reason = place.integrity_reason;
  fix.time_s = place.time_s;
  fix.x_m = place.x_m, fix.y_m = place.y_m, fix.z_m = place.z_m;
  fix.heading_rad = place.heading_rad;
  fix.qx = place.qx, fix.qy = place.qy, fix.qz = place.qz, fix.qw = place.qw;
  fix.sigma_x_m = place.sigma_x_m, fix.sigma_y_m = place.sigma_y_m, fix.sigma_z_m = place.sigma_z_m;
  fix.sigma_heading_rad = place.sigma_heading_rad;
  std::copy_n(&place.covariance[0][0], 36, &fix.covariance[0][0]);
  fix.has_velocity = place.has_velocity ? 1 : 0;
  std::copy_n(place.velocity_mps, 3, fix.velocity_mps);
  std::copy_n(place.turn_rate_radps, 3, fix.turn_rate_radps);
  std::copy_n(place.sigma_velocity_mps, 3, fix.sigma_velocity_mps);
  std::copy_n(place.sigma_turn_rate_radps, 3, fix.sigma_turn_rate_radps);
  fix.protection_level_m = place.protection_level_m;
  fix.arrivals_used = place.arrivals_used;
  fix.arrivals_rejected = place.arrivals_rejected;
  fix.vehicle = place.vehicle;
  return fix;
}

Heard heard_of(const octant_positioner& p, const octant_arrival& a) {
  return {.beacon = text_of(a.beacon),
          .tof_s = a.tof_s,
          .receiver = text_of(a.receiver),
          .time_s = a.time_s,
          .vehicle = text_of(a.vehicle),
          .epoch = a.epoch,
          .amplitude_v = a.amplitude_v,
          .temperature_degC = std::isnan(a.temperature_degC) ? p.temperature_degC : a.temperature_degC};
}

octant_result refused_unless(bool done) {
  return done ? OCTANT_DONE
              : fail(OCTANT_REFUSED,
                     "The row was refused: a name is not in the deployment, the row is too late or repeated, "
                     "its rotation is not valid, or the call came from within a callback.");
}

octant_result null_argument() { return fail(OCTANT_BAD_ARGUMENT, "An argument is a null pointer."); }

void set_callbacks(octant_positioner& opened) {
  // The address of `opened` does not change while it is open.
  if (opened.options.on_fix != nullptr)
    opened.positioner.on_place([&options = opened.options](const Place& place) {
      const octant_fix fix = fix_of(place);
      options.on_fix(&fix, options.user);
    });
  if (opened.options.on_alarm != nullptr)
    opened.positioner.on_alarm([&options = opened.options](const octant::Alarm& found) {
      const std::string name(found.name), vehicle(found.vehicle);
      octant_alarm alarm = {found.kind,   name.c_str(),  vehicle.c_str(), {},
                            found.size_m, found.sigma_m, found.since_s,   found.time_s};
      std::copy_n(found.shift_m, 3, alarm.shift_m);
      options.on_alarm(&alarm, options.user);
    });
}

/// @param make  creates the positioner from the noise of the odometry, the lateness and the watch
template <class Make>
octant_result open(const octant_options* options, octant_positioner** out, Make&& make) noexcept {
  if (out == nullptr) return null_argument();
  *out = nullptr;
  if (options == nullptr) return null_argument();
  if (options->api_version != OCTANT_API_VERSION)
    return fail(OCTANT_BAD_ARGUMENT,
                "The program was compiled for another version of octant.h than the library has: compile it "
                "with the installed header.");
  return guarded([&] {
    const octant_options& o = *options;
    octant::Positioner positioner =
        make(octant::OdometryNoise{o.distance_sigma_m_per_sqrt_m, o.heading_sigma_rad_per_sqrt_m,
                                   o.heading_sigma_per_rad, o.floor_m, o.floor_rad},
             o.lateness_s, o.watch != 0);
    if (!positioner) return fail(OCTANT_BAD_DEPLOYMENT, positioner.error().c_str());
    auto opened =
        std::make_unique<octant_positioner>(octant_positioner{std::move(positioner), o, std::nan(""), {}});
    set_callbacks(*opened);
    *out = opened.release();
    return OCTANT_DONE;
  });
}

}  // namespace

extern "C" {

int octant_api_version(void) { return OCTANT_API_VERSION; }
const char* octant_version(void) { return OCTANT_VERSION; }
const char* octant_last_error(void) { return last_error; }

octant_result octant_open(const char* path, const octant_options* options, octant_positioner** positioner) {
  return open(options, positioner, [path](const auto& noise, double lateness_s, bool watch) {
    return octant::Positioner(std::string(text_of(path)), noise, lateness_s, watch);
  });
}

octant_result octant_open_memory(const char* text, size_t size, const octant_options* options,
                                 octant_positioner** positioner) {
  return open(options, positioner, [text, size](const auto& noise, double lateness_s, bool watch) {
    return octant::Positioner::from_text(text == nullptr ? std::string_view() : std::string_view(text, size),
                                         noise, lateness_s, watch);
  });
}

void octant_close(octant_positioner* positioner) { delete positioner; }

octant_result octant_locate(octant_positioner* p, const octant_arrival* arrivals, size_t count,
                            octant_fix* fix) {
  if (p == nullptr || fix == nullptr || (arrivals == nullptr && count > 0)) return null_argument();
  return guarded([&] {
    p->heard.clear();
    for (size_t i = 0; i < count; ++i) p->heard.push_back(heard_of(*p, arrivals[i]));
    *fix = fix_of(p->positioner.locate(p->heard));
    return OCTANT_DONE;
  });
}

octant_result octant_add_arrival(octant_positioner* p, const octant_arrival* arrival) {
  if (p == nullptr || arrival == nullptr) return null_argument();
  return guarded([&] { return refused_unless(p->positioner.hear(heard_of(*p, *arrival))); });
}

octant_result octant_add_step(octant_positioner* p, const octant_odometry_step* s) {
  if (p == nullptr || s == nullptr) return null_argument();
  return guarded([&] {
    return refused_unless(p->positioner.move({s->time_s, s->dx_m, s->dy_m, s->dheading_rad,
                                              text_of(s->vehicle), s->dz_m, s->qx, s->qy, s->qz, s->qw}));
  });
}

octant_result octant_add_pose(octant_positioner* p, const octant_odometry_pose* s) {
  if (p == nullptr || s == nullptr) return null_argument();
  return guarded([&] {
    return refused_unless(p->positioner.move_to({s->time_s, s->x_m, s->y_m, s->heading_rad,
                                                 text_of(s->vehicle), s->z_m, s->qx, s->qy, s->qz, s->qw}));
  });
}

octant_result octant_set_temperature(octant_positioner* p, double temperature_degC) {
  if (p == nullptr) return null_argument();
  if (std::isinf(temperature_degC)) return fail(OCTANT_BAD_ARGUMENT, "The temperature is infinite.");
  p->temperature_degC = temperature_degC;
  return OCTANT_DONE;
}

octant_result octant_flush(octant_positioner* p) {
  if (p == nullptr) return null_argument();
  return guarded([p] {
    p->positioner.flush();
    return OCTANT_DONE;
  });
}

octant_result octant_predict(octant_positioner* p, double time_s, const char* vehicle, octant_fix* fix) {
  if (p == nullptr || fix == nullptr) return null_argument();
  return guarded([&] {
    *fix = fix_of(p->positioner.predict(time_s, text_of(vehicle)));
    return OCTANT_DONE;
  });
}

}  // extern "C"

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 *
 * C interface of liboctant.so (C11, also C++): given a deployment file and arrivals, it determines where a
 * vehicle is. It gives the same fixes as octant/positioner.h, number by number.
 *
 *   octant_options options = octant_default_options();
 *   octant_positioner *robot = NULL;
 *   if (octant_open("deployment.json", &options, &robot) != OCTANT_DONE) return puts(octant_last_error()), 3;
 *   octant_arrival arrivals[] = {octant_arrival_of("B0", "r0", 0.0314, 0.0), ...};
 *   octant_fix fix;
 *   octant_locate(robot, arrivals, 5, &fix);
 *   octant_close(robot);
 *
 * Units and frames: SI, radians. Map with z up; vehicle with x forward, y left, z up.
 *
 * Threads: one thread at a time may use a positioner. Different threads may use different positioners at the
 * same time. octant_last_error() is separate for each thread.
 *
 * Errors: if a function does not return OCTANT_DONE, it changes no pose, and octant_last_error() gives the
 * reason. No C++ exception leaves these functions. Strings end with a
 * zero and are read during the call only.
 *
 * Versions: structures and functions of one OCTANT_API_VERSION do not change. octant_open refuses options of
 * another version, so a program cannot run with a library that lays out these structures differently. */
#pragma once

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define OCTANT_API_VERSION 1

#if defined(__GNUC__)
#define OCTANT_API __attribute__((visibility("default")))
#else
#define OCTANT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Follows the vehicles of one deployment. */
typedef struct octant_positioner octant_positioner;

typedef enum octant_result {
  OCTANT_DONE = 0,
  OCTANT_BAD_ARGUMENT = 1,   /**< a null pointer, a number outside its range, or another API version */
  OCTANT_BAD_DEPLOYMENT = 2, /**< the deployment cannot be read, or is not valid */
  OCTANT_REFUSED = 3,        /**< unknown name, too late, repeated, no rotation, or called from a callback */
  OCTANT_OUT_OF_MEMORY = 4,
  OCTANT_FAULT = 5 /**< a fault of the library */
} octant_result;

/** Epoch of an arrival at a vehicle that may be moving. */
#define OCTANT_NO_EPOCH INT64_MIN

/** One time of flight between a beacon and a receiver. Begin with octant_arrival_of(). */
typedef struct octant_arrival {
  const char* beacon;      /**< name in the deployment */
  const char* receiver;    /**< name; NULL: the only receiver of the vehicle */
  const char* vehicle;     /**< name; NULL: the only vehicle of the deployment, or `robot` */
  double tof_s;            /**< any value; one that is no time of flight counts as rejected */
  double time_s;           /**< time of transmission or reception at the vehicle; finite */
  int64_t epoch;           /**< equal for the arrivals of one stop; OCTANT_NO_EPOCH: it may be moving */
  double amplitude_v;      /**< NaN: not measured */
  double temperature_degC; /**< NaN: that of octant_set_temperature(), else the deployment's */
} octant_arrival;

/** Odometry since the last row: the vehicle's pose in its frame at that time. The first row is the anchor. In
 * the plane uses dx_m, dy_m, dheading_rad; in space dx_m, dy_m, dz_m and a quaternion of any length. Begin
 * with octant_step_at(). */
typedef struct octant_odometry_step {
  double time_s, dx_m, dy_m, dz_m, dheading_rad;
  double qx, qy, qz, qw; /**< 0, 0, 0, 1 if dheading_rad is used */
  const char* vehicle;   /**< as in octant_arrival */
} octant_odometry_step;

/** Pose in the frame of the odometry, which drifts over the map. Unlike a step, a lost pose loses no motion.
 * Begin with octant_pose_at(). */
typedef struct octant_odometry_pose {
  double time_s, x_m, y_m, z_m, heading_rad;
  double qx, qy, qz, qw; /**< 0, 0, 0, 1 if heading_rad is used */
  const char* vehicle;   /**< as in octant_arrival */
} octant_odometry_pose;

/** Pose of a vehicle, or the reason why it is unknown. Strings are constants of the library. */
typedef struct octant_fix {
  int ok;                /**< 1: there is a pose; 0: only status, integrity, time_s and counts are valid */
  const char* status;    /**< "ok", "too_few_arrivals", "poor_geometry", "ambiguous", "no_consensus",
                              "not_converged" */
  const char* integrity; /**< "ok": protection_level_m bounds the error; "degraded"; "no_fix" */
  const char* integrity_reason; /**< empty for "ok" */
  double time_s;
  double x_m, y_m, z_m, heading_rad;
  double qx, qy, qz, qw; /**< rotation from the vehicle to the map, unit length */
  /** Standard deviations, including the calibration; pi: the heading is unknown. */
  double sigma_x_m, sigma_y_m, sigma_z_m, sigma_heading_rad;
  /** Covariance of x, y, z [m] and of small rotations about x, y, z of the map [rad]; zero out of the plane
   * for planar motion. */
  double covariance[6][6];
  int has_velocity; /**< 1 for vehicles with odometry */
  /** In the vehicle's frame, along and about x, y, z, with standard deviations. */
  double velocity_mps[3], turn_rate_radps[3], sigma_velocity_mps[3], sigma_turn_rate_radps[3];
  double protection_level_m; /**< bound of the horizontal error under one faulty beacon; 0: none */
  int arrivals_used, arrivals_rejected;
  int vehicle; /**< index in the deployment; -1: unknown */
} octant_fix;

/** A beacon or receiver that no longer agrees with the deployment. Its arrivals are ignored from then on.
 * Strings are valid during the callback. */
typedef struct octant_alarm {
  const char* kind; /**< "beacon_late", "beacon_moved", "beacon_silent", "receiver_late", "receiver_moved" */
  const char* name; /**< of the beacon, or of the receiver */
  const char* vehicle;    /**< of the receiver; empty for a beacon */
  double shift_m[3];      /**< displacement in the map (beacon) or in the vehicle's frame (receiver) */
  double size_m, sigma_m; /**< of the largest displacement, or of the delay as a length */
  double since_s, time_s; /**< first data that show it; time of the alarm */
} octant_alarm;

/** Called from within the functions that add data, in the same thread. Data added from within a callback are
 * refused. A callback must not throw, and must not close the positioner. */
typedef void (*octant_fix_callback)(const octant_fix* fix, void* user);
typedef void (*octant_alarm_callback)(const octant_alarm* alarm, void* user);

/** Begin with octant_default_options(). */
typedef struct octant_options {
  int api_version; /**< OCTANT_API_VERSION */
  /** Noise of the odometry over a step of length d and turn a, each from 0 on:
   *    sigma_xy^2 = distance^2 d + floor_m^2,  sigma_heading^2 = heading^2 d + (per_rad a)^2 + floor_rad^2 */
  double distance_sigma_m_per_sqrt_m, heading_sigma_rad_per_sqrt_m, heading_sigma_per_rad, floor_m, floor_rad;
  double lateness_s;              /**< from 0 on: data may arrive in any order within this time */
  int watch;                      /**< 1: also monitors beacons and receivers, and calls on_alarm */
  octant_fix_callback on_fix;     /**< fixes of the data that are added; may be NULL */
  octant_alarm_callback on_alarm; /**< may be NULL */
  void* user;                     /**< argument of the callbacks */
} octant_options;

/** Version of the interface that the library has, and version of Octant ("0.2.0"). */
OCTANT_API int octant_api_version(void);
OCTANT_API const char* octant_version(void);

/** Reason of the last failure in this thread, a complete sentence; valid until the next failure. */
OCTANT_API const char* octant_last_error(void);

/** Reads a deployment from a file, or from memory (its JSON text). @param positioner  set to NULL on failure
 */
OCTANT_API octant_result octant_open(const char* path, const octant_options* options,
                                     octant_positioner** positioner);
OCTANT_API octant_result octant_open_memory(const char* text, size_t size, const octant_options* options,
                                            octant_positioner** positioner);
/** Frees a positioner; NULL is allowed. */
OCTANT_API void octant_close(octant_positioner* positioner);

/** Locates a stationary vehicle from its arrivals alone, independently of other calls. Arrivals with unknown
 * names count as rejected. No fix is OCTANT_DONE with fix->ok 0. */
OCTANT_API octant_result octant_locate(octant_positioner* positioner, const octant_arrival* arrivals,
                                       size_t count, octant_fix* fix);

/** Add live data, in any order within the lateness. Arrivals of a pose are used as soon as all have come, and
 * with odometry the vehicle is tracked. Fixes go to options.on_fix. */
OCTANT_API octant_result octant_add_arrival(octant_positioner* positioner, const octant_arrival* arrival);
OCTANT_API octant_result octant_add_step(octant_positioner* positioner, const octant_odometry_step* step);
OCTANT_API octant_result octant_add_pose(octant_positioner* positioner, const octant_odometry_pose* pose);
/** Temperature of the air for arrivals that carry none, from now on; NaN: that of the deployment. */
OCTANT_API octant_result octant_set_temperature(octant_positioner* positioner, double temperature_degC);
/** Fixes the waiting arrivals, because no more will come for this pose. */
OCTANT_API octant_result octant_flush(octant_positioner* positioner);
/** Predicts the pose of a tracked vehicle, such as to the present time. The state does not change.
 * @param vehicle  as in octant_arrival */
OCTANT_API octant_result octant_predict(octant_positioner* positioner, double time_s, const char* vehicle,
                                        octant_fix* fix);

static inline octant_options octant_default_options(void) {
  octant_options o = {OCTANT_API_VERSION, 0.02, 0.02, 0.0, 1.0e-4, 1.0e-4, 0.2, 0, NULL, NULL, NULL};
  return o;
}
static inline octant_arrival octant_arrival_of(const char* beacon, const char* receiver, double tof_s,
                                               double time_s) {
  octant_arrival a = {beacon, receiver, NULL, tof_s, time_s, OCTANT_NO_EPOCH, (double)NAN, (double)NAN};
  return a;
}
static inline octant_odometry_step octant_step_at(double time_s) {
  octant_odometry_step s = {time_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, NULL};
  return s;
}
static inline octant_odometry_pose octant_pose_at(double time_s) {
  octant_odometry_pose p = {time_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, NULL};
  return p;
}

#ifdef __cplusplus
} /* extern "C" */
#endif

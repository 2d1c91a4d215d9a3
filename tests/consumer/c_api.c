/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * The C interface in a program of its own: the stop of guide page 9, at once and as live data, with the
 * deployment from a file and from memory. */
#include <octant/octant.h>

#include <stdio.h>
#include <string.h>

static char text[1 << 20];

static void keep(const octant_fix* fix, void* user) { *(octant_fix*)user = *fix; }

static int failed(const char* where) {
  printf("%s: %s\n", where, octant_last_error());
  return 1;
}

int main(int count, char** words) {
  static const struct {
    const char *beacon, *receiver;
    double tof_s;
  } heard[] = {{"B0", "r0", 0.03140152},
               {"B4", "r0", 0.03455385},
               {"B5", "r0", 0.01203101},
               {"B6", "r4", 0.01443498},
               {"B7", "r5", 0.02471653}};
  octant_fix live, fix;
  octant_arrival arrivals[5];
  octant_positioner *robot = NULL, *copy = NULL;
  octant_options options = octant_default_options();
  FILE* file;
  size_t size, i;
  if (count < 2 || octant_api_version() != OCTANT_API_VERSION) return 2;

  if (octant_open("no/such.json", &options, &copy) != OCTANT_BAD_DEPLOYMENT || copy != NULL)
    return failed("no file");
  if (strstr(octant_last_error(), "no/such.json") == NULL) return failed("no path in the message");
  options.api_version = 0;
  if (octant_open(words[1], &options, &copy) != OCTANT_BAD_ARGUMENT) return failed("another version");

  options = octant_default_options();
  options.on_fix = keep;
  options.user = &live;
  if (octant_open(words[1], &options, &robot) != OCTANT_DONE) return failed("octant_open");
  file = fopen(words[1], "rb");
  if (file == NULL) return 2;
  size = fread(text, 1, sizeof text, file);
  fclose(file);
  if (octant_open_memory(text, size, &options, &copy) != OCTANT_DONE) return failed("octant_open_memory");

  for (i = 0; i < 5; ++i)
    arrivals[i] = octant_arrival_of(heard[i].beacon, heard[i].receiver, heard[i].tof_s, 0.0);
  if (octant_locate(robot, arrivals, 5, &fix) != OCTANT_DONE || !fix.ok) return failed("octant_locate");
  memset(&live, 0, sizeof live);
  for (i = 0; i < 5; ++i) {
    arrivals[i].epoch = 0;
    if (octant_add_arrival(copy, &arrivals[i]) != OCTANT_DONE) return failed("octant_add_arrival");
  }
  if (octant_flush(copy) != OCTANT_DONE) return failed("octant_flush");
  if (live.x_m != fix.x_m || live.y_m != fix.y_m || live.covariance[0][1] != fix.covariance[0][1])
    return puts("live data give another fix"), 1;
  octant_close(copy);
  octant_close(robot);
  printf("x %.3f m, y %.3f m, sigma %.3f m\n", fix.x_m, fix.y_m, fix.sigma_x_m);
  return 0;
}

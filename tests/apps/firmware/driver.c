/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Runs the firmware edition on a list of commands, on this machine or in an emulator:
 *   E count temperature, then count lines "beacon receiver tof"   fix of a stop
 *   S                                                             start of the filter from the last fix
 *   M span x y z qx qy qz qw                                      step of the odometry
 *   A beacon receiver tof                                         arrival for the filter
 *   V span                                                        pose after a time
 * Each command gives one line. The last line has the largest stack and the number of instructions of a fix,
 * where they can be measured. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "octant_fix.h"

enum { MOST = 3 * OCTF_ARRIVALS };
static octf_arrival arrivals[MOST];
static octf_work work;
static octf_fix fix;
static octf_filter filter;

#ifdef __arm__
/* Unused stack below the caller is painted before a fix and searched after it. */
enum { PAINTED = 8192 };
static unsigned measure(void (*call)(octf_real), octf_real speed) __attribute__((noinline));
static unsigned measure(void (*call)(octf_real), octf_real speed) {
  unsigned char* top = __builtin_frame_address(0);
  volatile unsigned char* bottom = top - PAINTED;
  unsigned i;
  for (i = 0; i + 256 < PAINTED; ++i) bottom[i] = 0xA5;
  call(speed);
  for (i = 0; i + 256 < PAINTED && bottom[i] == 0xA5; ++i) continue;
  return PAINTED - i;
}
/* SysTick counts cycles of the emulated clock downwards, 24 bits. */
static volatile unsigned* const systick = (volatile unsigned*)0xE000E010;
static unsigned long long ticks_since_start;
void SysTick_Handler(void);
void SysTick_Handler(void) { ticks_since_start += 0x1000000; }
static void start_clock(void) {
  systick[1] = 0xFFFFFF;
  systick[2] = 0;
  systick[0] = 7;
}
static unsigned long long now(void) {
  unsigned long long before, count;
  do {
    before = ticks_since_start;
    count = before + 0xFFFFFF - systick[2];
  } while (before != ticks_since_start);
  return count;
}
#else
static unsigned measure(void (*call)(octf_real), octf_real speed) {
  call(speed);
  return 0;
}
static void start_clock(void) {}
static unsigned long long now(void) { return 0; }
#endif

static int count;
static void locate(octf_real speed) { octf_locate(&octf_site_table, arrivals, count, speed, &work, &fix); }

static void print_pose(const octf_pose* T) {
  int i;
  for (i = 0; i < 3; ++i) printf(" %.9g", (double)T->p_m[i]);
  for (i = 0; i < 4; ++i) printf(" %.9g", (double)T->q[i]);
}

static int read_arrival(FILE* file, octf_arrival* a) {
  unsigned beacon, receiver;
  char text[40];
  if (fscanf(file, "%u %u %39s", &beacon, &receiver, text) != 3) return 0;
  a->beacon = (uint8_t)beacon;
  a->receiver = (uint8_t)receiver;
  a->tof_s = (octf_real)strtod(text, NULL);
  return 1;
}

static void print_fix(void) {
  int i, j;
  printf("%d", (int)fix.status);
  print_pose(&fix.pose);
  printf(" %.9g %d %d", (double)fix.protection_level_m, fix.used, fix.rejected);
  for (i = 0; i < OCTF_DOF; ++i)
    for (j = 0; j < OCTF_DOF; ++j) printf(" %.9g", (double)fix.covariance[i][j]);
  printf("\n");
}

static void print_filter(int used) {
  int i, j;
  printf("%d", used);
  print_pose(&filter.pose);
  for (i = 0; i < OCTF_DOF; ++i)
    for (j = 0; j < OCTF_DOF; ++j) printf(" %.9g", (double)filter.covariance[i][j]);
  printf("\n");
}

int main(int words, char** word) {
  const octf_odometry noise = {(octf_real)0.02, (octf_real)0.02, 0, (octf_real)1e-4, (octf_real)1e-4};
  FILE* file = fopen(words > 1 ? word[1] : "commands.txt", "r");
  unsigned stack = 0;
  unsigned long long most_ticks = 0, sum_ticks = 0, fixes = 0;
  char command[2];
  int i;
  if (file == NULL) return 2;
  start_clock();
  while (fscanf(file, "%1s", command) == 1) {
    octf_arrival a;
    octf_pose step;
    double x[8];
    char text[40];
    memset(x, 0, sizeof x);
    switch (command[0]) {
      case 'E': {
        unsigned used;
        unsigned long long begin;
        octf_real speed;
        if (fscanf(file, "%d %39s", &count, text) != 2 || count > MOST) return 3;
        for (i = 0; i < count; ++i)
          if (!read_arrival(file, &arrivals[i])) return 3;
        speed = octf_speed_mps(&octf_site_table, (octf_real)strtod(text, NULL));
        begin = now();
        used = measure(locate, speed);
        begin = now() - begin;
        if (used > stack) stack = used;
        if (begin > most_ticks) most_ticks = begin;
        sum_ticks += begin;
        ++fixes;
        print_fix();
        break;
      }
      case 'S': print_filter(octf_filter_start(&filter, &fix)); break;
      case 'M':
        for (i = 0; i < 8; ++i)
          if (fscanf(file, "%lf", &x[i]) != 1) return 3;
        for (i = 0; i < 3; ++i) step.p_m[i] = (octf_real)x[1 + i];
        for (i = 0; i < 4; ++i) step.q[i] = (octf_real)x[4 + i];
        octf_filter_move(&filter, &step, (octf_real)x[0], &noise);
        print_filter(1);
        break;
      case 'A':
        if (!read_arrival(file, &a)) return 3;
        print_filter(octf_filter_update(&filter, &octf_site_table, &a,
                                        octf_speed_mps(&octf_site_table, (octf_real)strtod("nan", NULL))));
        break;
      case 'V':
        if (fscanf(file, "%lf", &x[0]) != 1) return 3;
        step = octf_filter_predict(&filter, (octf_real)x[0]);
        printf("%d", octf_filter_is_lost(&filter));
        print_pose(&step);
        printf("\n");
        break;
      default: return 3;
    }
  }
  printf("memory %u stack %u ticks %llu mean %llu\n",
         (unsigned)(sizeof work + sizeof fix + sizeof arrivals / 3), stack, most_ticks,
         fixes > 0 ? sum_ticks / fixes : 0);
  return 0;
}

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * A program with the firmware edition alone, for its size: fix and filter without input and output. */
#include "octant_fix.h"

static octf_work work;
static octf_arrival arrivals[OCTF_ARRIVALS];
static octf_fix fix;
static octf_filter filter;
volatile int count;

void reset(void);
void SysTick_Handler(void);
void SysTick_Handler(void) {}
int main(void);
int main(void) {
  const octf_odometry noise = {(octf_real)0.02, (octf_real)0.02, 0, (octf_real)1e-4, (octf_real)1e-4};
  const octf_real speed = octf_speed_mps(&octf_site_table, 20);
  octf_locate(&octf_site_table, arrivals, count, speed, &work, &fix);
  octf_filter_start(&filter, &fix);
  octf_filter_move(&filter, &fix.pose, 1, &noise);
  octf_filter_update(&filter, &octf_site_table, arrivals, speed);
  fix.pose = octf_filter_predict(&filter, 1);
  return octf_filter_is_lost(&filter);
}
void reset(void) {
  for (;;) count = main();
}
__attribute__((section(".vectors"), used)) static void (*const vectors[2])(void) = {0, reset};

/* SPDX-FileCopyrightText: 2026 Octant developers
 * SPDX-License-Identifier: Apache-2.0
 * Start of a Cortex-M4F in QEMU (mps2-an386), with files and output by semihosting. */
#include <stdlib.h>
#include <string.h>

extern unsigned char data_load[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
extern void initialise_monitor_handles(void);
extern void SysTick_Handler(void);
int main(int words, char** word);

void reset(void);
void reset(void) {
  *(volatile unsigned*)0xE000ED88 |= 0xFU << 20; /* CPACR: the floating-point unit */
  __asm volatile("dsb\n isb");
  memcpy(data_begin, data_load, (size_t)(data_end - data_begin));
  memset(bss_begin, 0, (size_t)(bss_end - bss_begin));
  initialise_monitor_handles();
  exit(main(0, NULL));
}
static void stop(void) { abort(); }
void _init(void);
void _init(void) {}
void _fini(void);
void _fini(void) {}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top,
    reset,
    stop,
    stop,
    stop,
    stop,
    stop,
    0,
    0,
    0,
    0,
    stop,
    stop,
    0,
    stop,
    SysTick_Handler};

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/interrupt.h"

#include <atomic>
#include <csignal>
#include <cstring>
#include <initializer_list>

#include <unistd.h>

namespace octant::app {
namespace {

volatile std::sig_atomic_t signalled = 0;
// Lock-free, which a handler needs: several threads compute at a time.
std::atomic<int> may_exit_at_once{0}, must_not_exit{0};
static_assert(std::atomic<int>::is_always_lock_free);
// A handler may not allocate: the text is laid down beforehand.
char last_words[512];
std::size_t last_words_size = 0;

extern "C" void on_signal(int) {
  signalled = 1;
  if (may_exit_at_once == 0 || must_not_exit != 0) return;
  constexpr char talk[] = "\noctant: interrupted, nothing was written\n";
  // Nothing can be done about a failed write here.
  if (write(STDERR_FILENO, talk, sizeof talk - 1) < 0 ||
      write(STDOUT_FILENO, last_words, last_words_size) < 0)
    _exit(130);
  _exit(130);
}

}  // namespace

void install_interrupt_handlers(const std::string& words) {
  last_words_size = words.size() < sizeof last_words ? words.size() : 0;
  std::memcpy(last_words, words.data(), last_words_size);
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction before = {};
    sigaction(number, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);
  }
}

bool interrupted() { return signalled != 0; }

ExitAtOnce::ExitAtOnce() {
  ++may_exit_at_once;
  // A signal that came before is not forgotten.
  if (interrupted()) on_signal(SIGINT);
}
ExitAtOnce::~ExitAtOnce() { --may_exit_at_once; }

NoExitAtOnce::NoExitAtOnce() { ++must_not_exit; }
NoExitAtOnce::~NoExitAtOnce() { --must_not_exit; }

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/interrupt.h"

#include <atomic>
#include <csignal>
#include <cstring>
#include <initializer_list>
#include <mutex>

#include <unistd.h>

namespace octant::app {
namespace {

// Lock-free as required in handlers; several computing threads read them at the same time.
std::atomic<int> signalled{0}, may_exit_at_once{0}, must_not_exit{0};
static_assert(std::atomic<int>::is_always_lock_free);
// Handlers must not allocate, so the text is prepared beforehand.
struct LastOutput {
  char text[512];
  std::size_t size = 0;
  void keep(const std::string& words) {
    size = words.size() < sizeof text ? words.size() : 0;
    std::memcpy(text, words.data(), size);
  }
  /// A failed write cannot be handled here.
  void say() const {
    if (write(STDOUT_FILENO, text, size) < 0) return;
  }
};
LastOutput if_interrupted, if_lost, lost_talk;

extern "C" void on_signal(int) {
  signalled = 1;
  if (may_exit_at_once == 0 || must_not_exit != 0) return;
  constexpr char talk[] = "\noctant: interrupted, nothing was written\n";
  if (write(STDERR_FILENO, talk, sizeof talk - 1) > 0) if_interrupted.say();
  _exit(130);
}

std::mutex hosts_mutex;
int polite_calls = 0;
struct sigaction hosts_action = {};

extern "C" void on_hosts_signal(int number, siginfo_t* info, void* context) {
  signalled = 1;
  if ((hosts_action.sa_flags & SA_SIGINFO) != 0) {
    hosts_action.sa_sigaction(number, info, context);
  } else if (hosts_action.sa_handler != SIG_IGN && hosts_action.sa_handler != SIG_DFL) {
    hosts_action.sa_handler(number);
  }
}

extern "C" void on_lost_input(int number, siginfo_t* info, void*) {
  constexpr int kBadInputExit = 3;
  if (info->si_code == BUS_ADRERR) {  // access to a mapped file; other bus errors are bugs
    if (write(STDERR_FILENO, lost_talk.text, lost_talk.size) > 0) if_lost.say();
    _exit(kBadInputExit);
  }
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

void install_interrupt_handlers(const std::string& words) {
  if_interrupted.keep(words);
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

void install_lost_input_handler(const std::string& words) {
  if_lost.keep(words);
  lost_talk.keep(std::string("\nerror: ").append(kLostInput).append("\n"));
  struct sigaction action = {};
  action.sa_sigaction = on_lost_input;
  action.sa_flags = SA_SIGINFO;
  sigemptyset(&action.sa_mask);
  sigaction(SIGBUS, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // write() then reports a file that exceeds the size limit
}

bool interrupted() { return signalled != 0; }

PoliteInterrupts::PoliteInterrupts() {
  const std::lock_guard lock(hosts_mutex);
  if (polite_calls++ > 0) return;
  ++must_not_exit;  // the host program handles the signal
  sigaction(SIGINT, nullptr, &hosts_action);
  struct sigaction action = {};
  action.sa_sigaction = on_hosts_signal;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
}

PoliteInterrupts::~PoliteInterrupts() {
  const std::lock_guard lock(hosts_mutex);
  if (--polite_calls > 0) return;
  sigaction(SIGINT, &hosts_action, nullptr);
  --must_not_exit;
  // The host had no handler, so the default action is to terminate.
  if (interrupted() && (hosts_action.sa_flags & SA_SIGINFO) == 0 && hosts_action.sa_handler == SIG_DFL)
    std::raise(SIGINT);
  signalled = 0;
}

ExitAtOnce::ExitAtOnce() {
  ++may_exit_at_once;
  // A signal that arrived before is not lost.
  if (interrupted()) on_signal(SIGINT);
}
ExitAtOnce::~ExitAtOnce() { --may_exit_at_once; }

NoExitAtOnce::NoExitAtOnce() { ++must_not_exit; }
NoExitAtOnce::~NoExitAtOnce() { --must_not_exit; }

}  // namespace octant::app

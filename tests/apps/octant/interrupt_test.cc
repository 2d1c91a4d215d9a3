// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Each in a process of its own, as signals are a process's.
#include "apps/octant/interrupt.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace octant::app {
namespace interrupt_test {

struct Ended {
  int code = -1;    ///< exit code; -1: by a signal
  int signal = 0;   ///< signal that ended it
  std::string out;  ///< its standard output
};

/// Outcome of a process that calls this function and then exits with 0 (or 1 if it returns false).
Ended run(const std::function<bool()>& work) {
  int out[2];
  EXPECT_EQ(::pipe(out), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    for (const int number : {SIGINT, SIGTERM}) std::signal(number, SIG_DFL);
    ::dup2(out[1], STDOUT_FILENO);
    ::close(STDERR_FILENO);
    ::_exit(work() ? 0 : 1);
  }
  ::close(out[1]);
  Ended ended;
  char text[256];
  for (ssize_t n = 0; (n = ::read(out[0], text, sizeof text)) > 0;)
    ended.out.append(text, static_cast<std::size_t>(n));
  ::close(out[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) ended.signal = WTERMSIG(status);
  return ended;
}

TEST(Interrupt, TheFirstSignalAsksAndTheSecondKills) {
  for (const int number : {SIGINT, SIGTERM}) {
    EXPECT_EQ(run([&] {
                install_interrupt_handlers("");
                if (interrupted()) return false;
                std::raise(number);
                return interrupted();
              }).code,
              0);
    EXPECT_EQ(run([&] {
                install_interrupt_handlers("");
                std::raise(number);
                std::raise(number);
                return true;
              }).signal,
              number);
  }
}

TEST(Interrupt, AJobInTheBackgroundIsLeftAlone) {
  EXPECT_EQ(run([] {
              std::signal(SIGINT, SIG_IGN);
              install_interrupt_handlers("");
              std::raise(SIGINT);
              return !interrupted();
            }).code,
            0);
}

TEST(Interrupt, WhereNothingIsHalfWrittenItEndsAtOnceWithItsLastWords) {
  if (::fcntl(STDERR_FILENO, F_GETFD) == -1) GTEST_SKIP() << "no standard error here";
  const Ended ended = run([] {
    ::dup2(STDOUT_FILENO, STDERR_FILENO);
    install_interrupt_handlers("{\"status\": \"interrupted\"}\n");
    const ExitAtOnce may;
    std::raise(SIGINT);
    return false;
  });
  EXPECT_EQ(ended.code, 130);
  EXPECT_EQ(ended.out, "\noctant: interrupted, nothing was written\n{\"status\": \"interrupted\"}\n");
}

TEST(Interrupt, ASignalThatCameBeforeIsNotForgotten) {
  EXPECT_EQ(run([] {
              install_interrupt_handlers("");
              std::raise(SIGINT);
              const ExitAtOnce may;
              return false;
            }).code,
            130);
}

TEST(Interrupt, WhileSomebodyWritesNothingEndsAtOnce) {
  EXPECT_EQ(run([] {
              install_interrupt_handlers("");
              const ExitAtOnce may;
              { const ExitAtOnce nested; }
              const NoExitAtOnce writing;
              std::raise(SIGINT);
              return interrupted();
            }).code,
            0);
}

volatile std::sig_atomic_t hosts_calls = 0;

/// Another program's SIGINT is asked politely, goes where it went, and is as before afterwards.
TEST(PoliteInterrupts, LeaveTheHostItsHandler) {
  EXPECT_EQ(run([] {
              std::signal(SIGINT, [](int) { hosts_calls = hosts_calls + 1; });
              {
                const PoliteInterrupts polite;
                const PoliteInterrupts nested;
                std::raise(SIGINT);
                if (!interrupted() || hosts_calls != 1) return false;
              }
              if (interrupted()) return false;  // forgotten
              std::raise(SIGINT);
              return hosts_calls == 2 && !interrupted();
            }).code,
            0);
}

TEST(PoliteInterrupts, AHostWithoutAHandlerIsEndedAfterwards) {
  EXPECT_EQ(run([] {
              {
                const PoliteInterrupts polite;
                std::raise(SIGINT);
                if (!interrupted()) return true;  // it lives on until here
              }
              return false;
            }).signal,
            SIGINT);
}

}  // namespace interrupt_test
}  // namespace octant::app

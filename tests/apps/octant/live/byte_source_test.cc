// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/live/byte_source.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <pty.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/text/open_file.h"

namespace octant::app {
namespace byte_source_test {

using Event = ByteSource::Event;
using io::Descriptor;
using ::testing::HasSubstr;

constexpr int kSoon_ms = 2000;  ///< an event that must come

int port_of(const ByteSource& source) {
  const std::size_t colon = source.listens().rfind(':');
  return std::atoi(source.listens().c_str() + colon + 1);
}

Descriptor sender_to(int port, int type) {
  Descriptor fd(::socket(AF_INET, type | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

void send_text(const Descriptor& fd, const std::string& text) {
  ASSERT_EQ(::write(fd.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

/// The next event that is not a mere pause.
Event next(ByteSource& source) {
  Event event = Event::kQuiet;
  for (int i = 0; i < 10 && event == Event::kQuiet; ++i) event = source.wait(kSoon_ms / 10);
  return event;
}

std::string error_of(const std::string& where) {
  const auto source = ByteSource::open(where);
  return source ? "" : source.error().message();
}

TEST(ByteSource, WhatIsNoSourceIsNamed) {
  EXPECT_THAT(error_of("ttyUSB0"), HasSubstr("no source of lines"));
  EXPECT_THAT(error_of("/dev/none"), HasSubstr("No such file or directory"));
  EXPECT_THAT(error_of("/dev/null:115201"), HasSubstr("no speed of a serial line"));
  EXPECT_THAT(error_of("/dev/null:fast"), HasSubstr("no speed of a serial line"));
  for (const char* port : {"tcp:", "tcp:x", "udp:65536", "udp:-1", "tcp:70x", "tcp:7 0"})
    EXPECT_THAT(error_of(port), HasSubstr("no port")) << port;
  EXPECT_EQ(ByteSource::open("tcp:x").error().code, Errc::kUsage);
}

TEST(ByteSource, AFileIsItsBytesAndThenTheEnd) {
  char name[] = "/tmp/octant_bytes.XXXXXX";
  const Descriptor file(::mkstemp(name));
  send_text(file, "one\ntwo\n");
  auto source = ByteSource::open(name);
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ(source->listens(), "");
  EXPECT_EQ(source->wait(kSoon_ms), Event::kBytes);
  EXPECT_EQ(source->bytes(), "one\ntwo\n");
  EXPECT_EQ(source->wait(kSoon_ms), Event::kEnd);
  EXPECT_EQ(source->bytes(), "") << "nothing is given twice";
  ::unlink(name);
}

TEST(ByteSource, APipeIsQuietUntilSomethingComes) {
  char folder[] = "/tmp/octant_pipe.XXXXXX";
  ASSERT_NE(::mkdtemp(folder), nullptr);
  const std::string path = std::string(folder) + "/pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  auto source = ByteSource::open(path);
  ASSERT_TRUE(source);
  {
    const Descriptor writer(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    EXPECT_EQ(source->wait(1), Event::kQuiet);
    send_text(writer, "abc");
    EXPECT_EQ(source->wait(kSoon_ms), Event::kBytes);
    EXPECT_EQ(source->bytes(), "abc");
  }
  EXPECT_EQ(source->wait(kSoon_ms), Event::kEnd) << "the writer is gone";
  std::filesystem::remove_all(folder);
}

TEST(ByteSource, SendersOverTcpComeAndGo) {
  auto source = ByteSource::open("tcp:0");
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_THAT(source->listens(), HasSubstr("listening on 127.0.0.1:"));
  EXPECT_EQ(source->wait(1), Event::kQuiet);
  for (const char* text : {"first", "second"}) {
    {
      const Descriptor sender = sender_to(port_of(*source), SOCK_STREAM);
      send_text(sender, text);
      EXPECT_EQ(next(*source), Event::kBytes);
      EXPECT_EQ(source->bytes(), text);
    }
    EXPECT_EQ(next(*source), Event::kBreak) << "a line that was begun is over";
  }
}

TEST(ByteSource, TheSecondSenderWaitsForTheFirst) {
  auto source = ByteSource::open("tcp:0");
  ASSERT_TRUE(source);
  Descriptor first = sender_to(port_of(*source), SOCK_STREAM);
  send_text(first, "a");
  EXPECT_EQ(next(*source), Event::kBytes);
  const Descriptor second = sender_to(port_of(*source), SOCK_STREAM);
  send_text(second, "b");
  EXPECT_EQ(source->wait(10), Event::kQuiet) << "lines of two would mix";
  EXPECT_TRUE(first.close_now());
  EXPECT_EQ(next(*source), Event::kBreak);
  EXPECT_EQ(next(*source), Event::kBytes);
  EXPECT_EQ(source->bytes(), "b");
}

TEST(ByteSource, EachDatagramEndsItsLine) {
  auto source = ByteSource::open("udp:0");
  ASSERT_TRUE(source) << source.error().message();
  const Descriptor sender = sender_to(port_of(*source), SOCK_DGRAM);
  send_text(sender, "one");
  send_text(sender, "two");
  EXPECT_EQ(next(*source), Event::kBytes);
  EXPECT_EQ(source->bytes(), "one");
  EXPECT_EQ(next(*source), Event::kBreak);
  EXPECT_EQ(next(*source), Event::kBytes);
  EXPECT_EQ(source->bytes(), "two");
  EXPECT_EQ(next(*source), Event::kBreak);
  EXPECT_EQ(source->wait(1), Event::kQuiet);
}

TEST(ByteSource, ASerialLineIsRawAndAtItsSpeed) {
  int master = -1, slave = -1;
  char name[256];
  if (::openpty(&master, &slave, name, nullptr, nullptr) != 0) GTEST_SKIP() << "no pseudo terminals here";
  const Descriptor device(master), keep(slave);
  auto source = ByteSource::open(std::string(name) + ":57600");
  ASSERT_TRUE(source) << source.error().message();
  termios settings{};
  ASSERT_EQ(::tcgetattr(slave, &settings), 0);
  EXPECT_EQ(::cfgetispeed(&settings), static_cast<speed_t>(B57600));
  EXPECT_EQ(settings.c_lflag & static_cast<tcflag_t>(ICANON | ECHO), 0U) << "bytes come as they come";
  send_text(device, "a\x03\r");  // neither an interrupt nor a line
  EXPECT_EQ(next(*source), Event::kBytes);
  EXPECT_EQ(source->bytes(), "a\x03\r");
}

TEST(ByteSource, AMovedOneListensOn) {
  auto opened = ByteSource::open("udp:0");
  ASSERT_TRUE(opened);
  ByteSource source(std::move(*opened));
  const Descriptor sender = sender_to(port_of(source), SOCK_DGRAM);
  send_text(sender, "x");
  EXPECT_EQ(next(source), Event::kBytes);
}

TEST(ByteSource, APortThatSomebodyHasIsSaidToBe) {
  auto first = ByteSource::open("tcp:0");
  ASSERT_TRUE(first);
  EXPECT_THAT(error_of("tcp:" + std::to_string(port_of(*first))), HasSubstr("Address already in use"));
}

}  // namespace byte_source_test
}  // namespace octant::app

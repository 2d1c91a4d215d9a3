// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/live/byte_source.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

namespace octant::app {
namespace {

tl::unexpected<Error> no_source(const std::string& where, std::string found, std::string expected) {
  return fail(
      {.code = Errc::kUsage, .file = where, .found = std::move(found), .expected = std::move(expected)});
}

std::string errno_words() { return std::strerror(errno); }

constexpr std::array<std::pair<int, speed_t>, 10> kSpeeds = {{{4800, B4800},
                                                              {9600, B9600},
                                                              {19200, B19200},
                                                              {38400, B38400},
                                                              {57600, B57600},
                                                              {115200, B115200},
                                                              {230400, B230400},
                                                              {460800, B460800},
                                                              {921600, B921600},
                                                              {1000000, B1000000}}};

/// Configures raw bytes at this speed (0: speed of the device).
bool make_raw(int fd, int baud) {
  termios settings{};
  if (tcgetattr(fd, &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  for (const auto& [number, speed] : kSpeeds) {
    if (number != baud) continue;
    cfsetispeed(&settings, speed);
    cfsetospeed(&settings, speed);
  }
  return tcsetattr(fd, TCSANOW, &settings) == 0;
}

bool whole_number(std::string_view text, int& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

Result<ByteSource> ByteSource::open(const std::string& where) {
  if (where == "-" || where.empty()) return ByteSource(Kind::kFile, STDIN_FILENO);
  if (where.starts_with("tcp:") || where.starts_with("udp:")) return open_port(where);
  if (where.starts_with("/") || where.starts_with(".")) return open_file(where);
  return no_source(where, "no source of lines", "-, /dev/ttyUSB0[:115200], tcp:PORT or udp:PORT");
}

Result<ByteSource> ByteSource::open_file(const std::string& where) {
  std::string path = where;
  int baud = 0;
  if (const auto colon = where.rfind(':'); colon != std::string::npos && access(where.c_str(), F_OK) != 0) {
    path = where.substr(0, colon);
    bool known = false;
    if (whole_number(std::string_view(where).substr(colon + 1), baud))
      for (const auto& speed : kSpeeds) known = known || speed.first == baud;
    if (!known) return no_source(where, "no speed of a serial line", "one of 4800 to 1000000, as 115200");
  }
  // Without waiting for a carrier; reads go through poll.
  const int fd = ::open(path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return fail({.code = Errc::kBadInput, .file = path, .found = errno_words()});
  const bool terminal = isatty(fd) == 1;
  ByteSource source(terminal ? Kind::kTerminal : Kind::kFile, fd);
  if (terminal && !make_raw(fd, baud))
    return fail({.code = Errc::kBadInput, .file = path, .found = errno_words()});
  return source;
}

Result<ByteSource> ByteSource::open_port(const std::string& where) {
  const bool tcp = where.starts_with("tcp:");
  int port = -1;
  if (!whole_number(std::string_view(where).substr(4), port) || port < 0 || port > 65535)
    return no_source(where, "no port", "a number from 0 (any that is free) to 65535");
  const int fd = socket(AF_INET, (tcp ? SOCK_STREAM : SOCK_DGRAM) | SOCK_CLOEXEC, 0);
  if (fd < 0) return fail({.code = Errc::kBadInput, .file = where, .found = errno_words()});
  ByteSource source(tcp ? Kind::kTcp : Kind::kUdp, fd);
  const int yes = 1;
  (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);  // only this machine
  socklen_t size = sizeof address;
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), size) != 0 || (tcp && listen(fd, 1) != 0) ||
      getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return fail({.code = Errc::kBadInput, .file = where, .found = errno_words()});
  source.listens_ =
      fmt::format("listening on 127.0.0.1:{} ({})", ntohs(address.sin_port), tcp ? "TCP" : "UDP");
  return source;
}

ByteSource::ByteSource(ByteSource&& other) noexcept
    : kind_(other.kind_),
      fd_(std::exchange(other.fd_, -1)),
      sender_(std::exchange(other.sender_, -1)),
      buffer_(std::move(other.buffer_)),
      listens_(std::move(other.listens_)) {}

ByteSource::~ByteSource() {
  if (sender_ >= 0) close(sender_);
  if (fd_ > STDIN_FILENO) close(fd_);
}

ByteSource::Event ByteSource::wait(int timeout_ms) {
  size_ = 0;
  if (datagram_ended_) {
    datagram_ended_ = false;
    return Event::kBreak;
  }
  pollfd what{kind_ == Kind::kTcp && sender_ >= 0 ? sender_ : fd_, POLLIN, 0};
  const int ready = poll(&what, 1, timeout_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return Event::kQuiet;
  if (ready < 0) {
    why_ = errno_words();
    return Event::kFailed;
  }
  return kind_ == Kind::kTcp && sender_ < 0 ? accept_sender() : read_bytes();
}

ByteSource::Event ByteSource::accept_sender() {
  sender_ = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC);
  return Event::kQuiet;
}

ByteSource::Event ByteSource::read_bytes() {
  const int from = kind_ == Kind::kTcp ? sender_ : fd_;
  const ssize_t got = read(from, buffer_.data(), buffer_.size());
  if (got > 0) {
    size_ = static_cast<std::size_t>(got);
    datagram_ended_ = kind_ == Kind::kUdp;
    return Event::kBytes;
  }
  if (got < 0 && (errno == EINTR || errno == EAGAIN)) return Event::kQuiet;
  if (kind_ == Kind::kUdp) return Event::kBreak;  // an empty datagram, or one that was refused
  if (kind_ == Kind::kTcp) {
    close(std::exchange(sender_, -1));
    return Event::kBreak;
  }
  if (got == 0) return Event::kEnd;
  why_ = errno_words();
  return Event::kFailed;
}

}  // namespace octant::app

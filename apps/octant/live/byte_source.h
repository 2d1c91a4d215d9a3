// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

namespace octant::app {

/// Where the lines of `octant localize --follow` come from: standard input, a serial device (or a pipe) by
/// its path, or this machine's own TCP or UDP port. Whoever sends over TCP may go and come again, one at a
/// time. Nobody is read ahead of what is worked on, so that a fast sender waits.
class ByteSource {
 public:
  /// @param where  "-", "/dev/ttyUSB0" or "/dev/ttyUSB0:115200", "tcp:7070", "udp:7070" (127.0.0.1)
  [[nodiscard]] static Result<ByteSource> open(const std::string& where);
  ~ByteSource();
  ByteSource(ByteSource&& other) noexcept;
  ByteSource& operator=(ByteSource&&) = delete;

  enum class Event {
    kBytes,   ///< in bytes()
    kQuiet,   ///< nothing came within the time
    kBreak,   ///< a sender is gone, or a datagram has ended: a line that was begun is over
    kEnd,     ///< nothing will come any more
    kFailed,  ///< the same, with errno's reason in why()
  };
  [[nodiscard]] Event wait(int timeout_ms);
  [[nodiscard]] std::string_view bytes() const { return {buffer_.data(), size_}; }
  [[nodiscard]] const std::string& why() const { return why_; }
  /// "listening on 127.0.0.1:7070", for people; empty for files.
  [[nodiscard]] const std::string& listens() const { return listens_; }

 private:
  enum class Kind { kFile, kTerminal, kTcp, kUdp };
  ByteSource(Kind kind, int fd) : kind_(kind), fd_(fd), buffer_(65536) {}
  [[nodiscard]] static Result<ByteSource> open_file(const std::string& path);
  [[nodiscard]] static Result<ByteSource> open_port(const std::string& where);
  [[nodiscard]] Event accept_sender();
  [[nodiscard]] Event read_bytes();

  Kind kind_;
  int fd_;           ///< what is read, or listened to
  int sender_ = -1;  ///< of TCP: the connection
  bool datagram_ended_ = false;
  std::size_t size_ = 0;
  std::vector<char> buffer_;
  std::string why_, listens_;
};

}  // namespace octant::app

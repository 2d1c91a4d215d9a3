// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

namespace octant::app {

/// Source of the lines for `octant localize --follow`: standard input, a serial device or a pipe by its path,
/// or a TCP or UDP port of this machine. TCP senders may disconnect and reconnect, one at a time. Input is
/// read only as it is processed, so that a fast sender waits.
class ByteSource {
 public:
  /// @param where  "-", "/dev/ttyUSB0" or "/dev/ttyUSB0:115200", "tcp:7070", "udp:7070" (127.0.0.1)
  [[nodiscard]] static Result<ByteSource> open(const std::string& where);
  ~ByteSource();
  ByteSource(ByteSource&& other) noexcept;
  ByteSource& operator=(ByteSource&&) = delete;

  enum class Event {
    kBytes,   ///< data are in bytes()
    kQuiet,   ///< no input within the time
    kBreak,   ///< a sender disconnected, or a datagram ended: an incomplete line is over
    kEnd,     ///< end of the input
    kFailed,  ///< end by an error; why() has the reason from errno
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
  int fd_;           ///< file or socket that is read or listened to
  int sender_ = -1;  ///< TCP connection
  bool datagram_ended_ = false;
  std::size_t size_ = 0;
  std::vector<char> buffer_;
  std::string why_, listens_;
};

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/web_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <list>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace octant::app {
namespace {

using WebClock = std::chrono::steady_clock;

constexpr std::size_t kMostConnections = 64, kMostOfOneAddress = 8;
constexpr std::ptrdiff_t kMostStreams = 16;
constexpr std::chrono::seconds kHeaderTime{2};
constexpr std::size_t kMostUnsentBytes = std::size_t{4} << 20;  ///< of a viewer that reads slowly
constexpr std::chrono::seconds kRequestTime{10};                ///< for a request, and for its answer
constexpr std::chrono::milliseconds kEventPeriod{500};
constexpr std::chrono::seconds kKeepAlive{10};  ///< a comment shows viewers that the server is there

tl::unexpected<Error> no_server(const std::string& address, std::string found, std::string expected) {
  return fail(
      {.code = Errc::kUsage, .file = address, .found = std::move(found), .expected = std::move(expected)});
}

bool is_loopback_address(const sockaddr* address) {
  if (address->sa_family == AF_INET)
    return (ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr) >> 24U) == 127;
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr);
}

/// An address without its port; [ADDRESS] for IPv6.
std::string host_of(const sockaddr* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address->sa_family == AF_INET) {
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text.data(), text.size());
    return text.data();
  }
  inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr, text.data(), text.size());
  return fmt::format("[{}]", text.data());
}

/// The address that a socket is bound to or, if that is all of them, those of the network interfaces.
/// Addresses that are valid on one link only need the name of the other machine's interface, and are left
/// out.
std::vector<std::string> hosts_of(const sockaddr* bound) {
  const std::string host = host_of(bound);
  std::vector<std::string> hosts;
  ifaddrs* interfaces = nullptr;
  if ((host == "0.0.0.0" || host == "[::]") && getifaddrs(&interfaces) == 0) {
    for (const ifaddrs* i = interfaces; i != nullptr; i = i->ifa_next) {
      if (i->ifa_addr == nullptr || (i->ifa_flags & IFF_UP) == 0U) continue;
      const bool is_v6 = i->ifa_addr->sa_family == AF_INET6;
      if (i->ifa_addr->sa_family != AF_INET && !(is_v6 && bound->sa_family == AF_INET6)) continue;
      if (is_v6 && IN6_IS_ADDR_LINKLOCAL(&reinterpret_cast<const sockaddr_in6*>(i->ifa_addr)->sin6_addr))
        continue;
      hosts.push_back(host_of(i->ifa_addr));
    }
    freeifaddrs(interfaces);
  }
  if (hosts.empty()) hosts.push_back(host);
  return hosts;
}

}  // namespace

Result<WebServer> WebServer::listen(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (colon == std::string::npos || colon + 1 == address.size())
    return no_server(address, "no port", "ADDRESS:PORT, for example 127.0.0.1:8740 or [::1]:0");
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  addrinfo hints{}, *found = nullptr;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  if (host == "localhost") host = "127.0.0.1";
  if (getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &hints, &found) != 0 || found == nullptr)
    return no_server(address, "no numeric address and port", "ADDRESS:PORT, for example 0.0.0.0:8740");
  WebServer server;
  server.is_loopback_ = is_loopback_address(found->ai_addr);
  server.fd_ = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  if (server.fd_ >= 0) setsockopt(server.fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const bool listens = server.fd_ >= 0 && bind(server.fd_, found->ai_addr, found->ai_addrlen) == 0 &&
                       ::listen(server.fd_, 64) == 0;
  const std::string why = std::strerror(errno);
  freeaddrinfo(found);
  if (!listens) return no_server(address, why, "a free port of this machine; port 0 selects one");
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(server.fd_, reinterpret_cast<sockaddr*>(&bound), &size);
  server.port_ = ntohs(bound.ss_family == AF_INET ? reinterpret_cast<sockaddr_in*>(&bound)->sin_port
                                                  : reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port);
  for (const std::string& name : hosts_of(reinterpret_cast<const sockaddr*>(&bound)))
    server.urls_.push_back(fmt::format("http://{}:{}/", name, server.port_));
  return server;
}

WebServer::WebServer(WebServer&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      port_(other.port_),
      is_loopback_(other.is_loopback_),
      urls_(std::move(other.urls_)) {}

WebServer::~WebServer() {
  is_stopping_ = true;
  if (thread_.joinable()) thread_.join();
  if (fd_ >= 0) close(fd_);
}

struct WebServer::Connection {
  int fd = -1;
  HttpReader reader;
  std::string address, out;
  bool is_answered = false, is_stream = false;
  WebClock::time_point began = WebClock::now();
};

struct WebServer::Loop {
  WebServer& server;
  HttpGuard guard;
  Handler handler;
  NextEvent next_event;
  std::list<Connection> connections{};
  WebClock::time_point next_due = WebClock::now(), last_sent = next_due;

  ~Loop() {
    for (const Connection& c : connections) close(c.fd);
  }

  void run() {
    std::vector<pollfd> waiting;
    while (!server.is_stopping_) {
      waiting.assign(1, {server.fd_, POLLIN, 0});
      for (const Connection& c : connections)
        waiting.push_back({c.fd, static_cast<short>(POLLIN | (c.out.empty() ? 0 : POLLOUT)), 0});
      poll(waiting.data(), waiting.size(), 100);
      std::size_t i = 0;
      for (auto c = connections.begin(); c != connections.end();)
        c = serve(*c, waiting[++i].revents) ? std::next(c) : remove(c);
      if ((waiting[0].revents & POLLIN) != 0) accept_one();
      if (WebClock::now() >= next_due) send_event();
    }
  }

  std::list<Connection>::iterator remove(std::list<Connection>::iterator c) {
    close(c->fd);
    return connections.erase(c);
  }

  /// Where there are too many connections, a new one replaces the oldest that has no answer yet.
  void accept_one() {
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    auto* const peer = reinterpret_cast<sockaddr*>(&from);
    const int fd = accept4(server.fd_, peer, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    const std::string address = host_of(peer);
    const auto of_address = std::ranges::count(connections, address, &Connection::address);
    const bool is_crowd = static_cast<std::size_t>(of_address) >= kMostOfOneAddress;
    if (is_crowd || connections.size() >= kMostConnections) {
      const auto oldest = std::ranges::find_if(connections, [&](const Connection& c) {
        return !c.is_answered && (!is_crowd || c.address == address);
      });
      if (oldest == connections.end()) {
        close(fd);
        return;
      }
      remove(oldest);
    }
    connections.emplace_back();
    connections.back().fd = fd;
    connections.back().address = address;
  }

  /// @return false if the connection is over
  bool serve(Connection& c, short events) {
    if ((events & (POLLIN | POLLHUP | POLLERR)) != 0 && !receive(c)) return false;
    if (!c.out.empty() && !transmit(c)) return false;
    if (c.is_stream) return true;
    if (c.is_answered && c.out.empty()) return false;
    return WebClock::now() - c.began < (c.is_answered || c.reader.has_header() ? kRequestTime : kHeaderTime);
  }

  bool receive(Connection& c) {
    std::array<char, 16384> bytes;
    const ssize_t size = recv(c.fd, bytes.data(), bytes.size(), 0);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    if (size == 0) return c.is_answered && !c.is_stream && !c.out.empty();
    if (c.is_answered) return true;  // further bytes are of no use
    const auto invalid = c.reader.feed({bytes.data(), static_cast<std::size_t>(size)});
    if (invalid) {
      answer(c, http_error(*invalid, "The request is malformed or too long."));
    } else if (c.reader.is_complete()) {
      const HttpRequest request = c.reader.request();
      auto refused = guard.refusal(request);
      auto response = refused ? std::move(*refused) : handled(request);
      if (response.is_stream && std::ranges::count(connections, true, &Connection::is_stream) >= kMostStreams)
        response = http_error(503, "Too many pages are open.");
      answer(c, response);
    }
    return true;
  }

  /// Answer of the handler. A fault of it concerns one request, and never the recording.
  [[nodiscard]] HttpResponse handled(const HttpRequest& request) const {
    try {
      return handler(request);
    } catch (const std::exception& fault) {
      return http_error(500, std::string("A fault of octant, please report it: ") + fault.what());
    }
  }

  static void answer(Connection& c, const HttpResponse& response) {
    c.is_answered = true;
    c.is_stream = response.is_stream;
    c.began = WebClock::now();
    c.out = http_text(response);
  }

  static bool transmit(Connection& c) {
    const ssize_t sent = send(c.fd, c.out.data(), c.out.size(), MSG_NOSIGNAL);
    if (sent < 0) return errno == EAGAIN || errno == EINTR;
    c.out.erase(0, static_cast<std::size_t>(sent));
    return true;
  }

  void send_event() {
    const auto now = WebClock::now();
    next_due = now + kEventPeriod;
    std::string event = next_event();
    if (event.empty() && now - last_sent > kKeepAlive) event = ": the server is there\n\n";
    if (event.empty()) return;
    last_sent = now;
    for (Connection& c : connections)
      if (c.is_stream && c.out.size() + event.size() < kMostUnsentBytes) c.out += event;
  }
};

void WebServer::start(HttpGuard guard, Handler handler, NextEvent next_event) {
  thread_ = std::thread(
      [this, guard = std::move(guard), handler = std::move(handler), next_event = std::move(next_event)] {
        Loop{*this, guard, handler, next_event}.run();
      });
}

}  // namespace octant::app

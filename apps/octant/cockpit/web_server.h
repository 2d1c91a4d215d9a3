// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "apps/octant/cockpit/http.h"
#include "models/support/result.h"

namespace octant::app {

/// Serves pages, commands and server-sent events on one thread. Connections and their memory are bounded: a
/// viewer that reads too slowly misses states, and one that sends no request in time is disconnected.
class WebServer {
 public:
  using Handler = std::function<HttpResponse(const HttpRequest&)>;
  /// Next event for all viewers; empty if there is nothing new.
  using NextEvent = std::function<std::string()>;

  /// @param address  ADDRESS:PORT or [ADDRESS]:PORT; port 0 is any free port
  [[nodiscard]] static Result<WebServer> listen(const std::string& address);
  WebServer(WebServer&& other) noexcept;
  WebServer& operator=(WebServer&&) = delete;
  WebServer(const WebServer&) = delete;
  ~WebServer();

  /// Begins to serve. Call it once.
  void start(HttpGuard guard, Handler handler, NextEvent next_event);
  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] bool is_loopback() const { return is_loopback_; }
  /// Addresses for browsers: one, or those of all network interfaces.
  [[nodiscard]] const std::vector<std::string>& urls() const { return urls_; }

 private:
  struct Connection;
  struct Loop;
  WebServer() = default;
  int fd_ = -1, port_ = 0;
  bool is_loopback_ = true;
  std::vector<std::string> urls_;
  std::atomic<bool> is_stopping_ = false;
  std::thread thread_;
};

}  // namespace octant::app

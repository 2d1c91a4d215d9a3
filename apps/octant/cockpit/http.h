// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace octant::app {

/// A request of HTTP/1.1, as far as the cockpit needs it. Header fields that are missing are empty.
struct HttpRequest {
  std::string method, path, query, body;
  std::string host, origin, fetch_site, content_type, cookie, authorization;
};

struct HttpResponse {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::string location = {};    ///< of a redirection
  std::string set_cookie = {};  ///< cookie of the answer
  bool is_stream = false;       ///< the connection remains open for server-sent events
};
/// Answer {"error": ...} with this status.
[[nodiscard]] HttpResponse http_error(int status, const std::string& message);
/// Text of an answer. It carries a content security policy that forbids everything from outside.
[[nodiscard]] std::string http_text(const HttpResponse& response);

/// Reads one request from the bytes of a connection. Memory is bounded: 8 kB of header, 64 kB of body.
class HttpReader {
 public:
  HttpReader();
  ~HttpReader();
  HttpReader(HttpReader&&) noexcept;
  HttpReader& operator=(HttpReader&&) noexcept;

  /// Takes the next bytes. @return status of the answer if the request is invalid (400, 413, 431)
  [[nodiscard]] std::optional<int> feed(std::string_view bytes);
  [[nodiscard]] bool is_complete() const;
  [[nodiscard]] bool has_header() const;
  [[nodiscard]] HttpRequest request() const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

/// Decides who may use the cockpit.
class HttpGuard {
 public:
  /// @param token  secret that every request has to show; empty: none, for the loopback address only
  /// @param port  port of the server
  HttpGuard(std::string token, int port) : token_(std::move(token)), port_(port) {}

  /// Answer for a request that may not be served; no value for one that may. Refused are requests without
  /// the token, of pages from another origin, under a foreign host name without a token (DNS rebinding), and
  /// commands that are not JSON (a form of another page could send them).
  [[nodiscard]] std::optional<HttpResponse> refusal(const HttpRequest& request) const;

 private:
  [[nodiscard]] bool has_token(const HttpRequest& request) const;
  [[nodiscard]] std::string cookie_name() const;
  std::string token_;
  int port_;
};

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/http.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/http/string_body.hpp>

#include "apps/octant/session.h"

namespace octant::app {
namespace {

namespace http = boost::beast::http;

constexpr std::uint32_t kMostHeaderBytes = 8192;
constexpr std::uint64_t kMostBodyBytes = 65536;

std::string field_of(const http::request<http::string_body>& message, http::field name) {
  const auto at = message.find(name);
  return at == message.end() ? std::string() : std::string(at->value());
}

/// Compares in a time that does not depend on the content.
bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned>(a[i] ^ b[i]);
  return difference == 0;
}

/// Value of NAME=value in a list of pairs.
std::string_view pair_of(std::string_view list, std::string_view name, char separator) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(separator), list.size());
    std::string_view pair = list.substr(0, end);
    list.remove_prefix(std::min(end + 1, list.size()));
    while (!pair.empty() && pair.front() == ' ') pair.remove_prefix(1);
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=')
      return pair.substr(name.size() + 1);
  }
  return {};
}

}  // namespace

struct HttpReader::Parser {
  http::request_parser<http::string_body> of;
  std::string rest;  ///< bytes that the parser waits to have complete
};

HttpReader::HttpReader() : parser_(std::make_unique<Parser>()) {
  parser_->of.header_limit(kMostHeaderBytes);
  parser_->of.body_limit(kMostBodyBytes);
  parser_->of.eager(true);
}
HttpReader::~HttpReader() = default;
HttpReader::HttpReader(HttpReader&&) noexcept = default;
HttpReader& HttpReader::operator=(HttpReader&&) noexcept = default;

std::optional<int> HttpReader::feed(std::string_view bytes) {
  std::string& rest = parser_->rest;
  rest.append(bytes);
  boost::beast::error_code error;
  while (!rest.empty() && !parser_->of.is_done()) {
    const std::size_t used = parser_->of.put(boost::asio::buffer(rest.data(), rest.size()), error);
    rest.erase(0, used);
    if (error == http::error::need_more)
      return rest.size() > kMostHeaderBytes ? std::optional(431) : std::nullopt;
    if (error == http::error::header_limit) return 431;
    if (error == http::error::body_limit) return 413;
    if (error) return 400;
    if (used == 0) break;
  }
  return std::nullopt;
}

bool HttpReader::is_complete() const { return parser_->of.is_done(); }
bool HttpReader::has_header() const { return parser_->of.is_header_done(); }

HttpRequest HttpReader::request() const {
  const auto& message = parser_->of.get();
  const std::string target(message.target());
  const std::size_t query = std::min(target.find('?'), target.size());
  return {.method = std::string(message.method_string()),
          .path = target.substr(0, query),
          .query = target.substr(std::min(query + 1, target.size())),
          .body = message.body(),
          .host = field_of(message, http::field::host),
          .origin = field_of(message, http::field::origin),
          .fetch_site = std::string(message["Sec-Fetch-Site"]),
          .content_type = field_of(message, http::field::content_type),
          .cookie = field_of(message, http::field::cookie),
          .authorization = field_of(message, http::field::authorization)};
}

HttpResponse http_error(int status, const std::string& message) {
  return {.status = status, .body = dump(Json{{"error", message}})};
}

std::string http_text(const HttpResponse& r) {
  const auto reason = http::obsolete_reason(static_cast<http::status>(r.status));
  std::string text = fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}; charset=utf-8\r\nCache-Control: no-store\r\nConnection: close\r\n"
      "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n"
      "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
      "img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n",
      r.status, std::string_view(reason.data(), reason.size()), r.type);
  if (!r.location.empty()) text += fmt::format("Location: {}\r\n", r.location);
  if (!r.set_cookie.empty()) text += fmt::format("Set-Cookie: {}\r\n", r.set_cookie);
  if (!r.is_stream) text += fmt::format("Content-Length: {}\r\n", r.body.size());
  return text + "\r\n" + r.body;
}

std::string HttpGuard::cookie_name() const { return fmt::format("octant_{}", port_); }

bool HttpGuard::has_token(const HttpRequest& r) const {
  constexpr std::string_view kBearer = "Bearer ";
  return is_same_secret(pair_of(r.cookie, cookie_name(), ';'), token_) ||
         (r.authorization.starts_with(kBearer) &&
          is_same_secret(std::string_view(r.authorization).substr(kBearer.size()), token_));
}

std::optional<HttpResponse> HttpGuard::refusal(const HttpRequest& r) const {
  if (r.method != "GET" && r.method != "POST") return http_error(405, "Only GET and POST are served.");
  const bool is_foreign = (!r.origin.empty() && r.origin != "http://" + r.host) ||
                          (r.path != "/" && (r.fetch_site == "cross-site" || r.fetch_site == "same-site"));
  if (is_foreign) return http_error(403, "Requests of pages from another origin are refused.");
  if (token_.empty()) {
    const std::string port = fmt::format(":{}", port_);
    if (r.host != "127.0.0.1" + port && r.host != "localhost" + port && r.host != "[::1]" + port)
      return http_error(403, "The host name is not that of this machine's loopback address.");
  } else if (!has_token(r)) {
    if (r.method != "GET" || r.path != "/" || !is_same_secret(pair_of(r.query, "token", '&'), token_))
      return http_error(401, "The token is missing or wrong. Open the address that octant cockpit printed.");
    return HttpResponse{
        .status = 303,
        .type = "text/plain",
        .body = "",
        .location = "/",
        .set_cookie = fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict", cookie_name(), token_)};
  }
  if (r.method == "POST" && !r.content_type.starts_with("application/json"))
    return http_error(415, "Commands are JSON: Content-Type: application/json.");
  return std::nullopt;
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <string_view>

#include "io/network/gama_parts.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::io {
namespace {

bool begins_as_xml(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return without_blanks(text.substr(0, text.find('<') + 1)) == "<";
}

}  // namespace

bool is_gama(const std::string& path) {
  std::string head(4096, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return begins_as_xml(head) &&
         (head.find("<gama-local") != std::string::npos || head.find("<gama-xml") != std::string::npos);
}

Result<NetworkFile> read_network(const std::string& path) {
  const Result<std::string> bytes = read_file(path, kLargestYaml);
  if (!bytes) return fail(bytes.error());
  return begins_as_xml(*bytes) ? parse_gama(*bytes, path) : parse_survey(*bytes, path);
}

}  // namespace octant::io

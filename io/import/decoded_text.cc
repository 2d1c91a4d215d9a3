// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/decoded_text.h"

#include <algorithm>
#include <array>
#include <memory>

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include "io/text/bounds.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kDecodedBlock = std::size_t{1} << 16;
constexpr std::size_t kProbed = 1024;  // bytes in which UTF-16 without a byte-order mark is recognised

tl::unexpected<Error> damaged(const std::string& path, const char* kind) {
  return fail({.file = path,
               .found = fmt::format("{} data that are damaged or incomplete", kind),
               .expected = "a whole compressed file",
               .advice = "copy the file again"});
}

tl::unexpected<Error> too_large(const std::string& path) {
  return fail(
      {.file = path,
       .found = fmt::format("more than {} MB of text when decompressed", DecodedText::kLargestDecoded >> 20U),
       .expected = "a recording of a few hours",
       .advice = "split the file"});
}

Result<std::string> gunzipped(std::string_view data, const std::string& path) {
  z_stream stream{};
  constexpr int kWindowWithHeader = 15 + 16;  // largest window of zlib; 16: with the header of gzip
  if (inflateInit2(&stream, kWindowWithHeader) != Z_OK) return damaged(path, "gzip");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  std::string text;
  std::array<char, kDecodedBlock> block;
  while (true) {
    const std::string_view input = data.substr(0, std::size_t{1} << 30);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(input.data()));
    stream.avail_in = static_cast<uInt>(input.size());
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    const int status = inflate(&stream, Z_NO_FLUSH);
    text.append(block.data(), block.size() - stream.avail_out);
    data.remove_prefix(input.size() - stream.avail_in);
    if (text.size() > DecodedText::kLargestDecoded) return too_large(path);
    if (status == Z_STREAM_END) {
      if (!data.starts_with("\x1F\x8B")) return text;  // padding may follow the last member
      inflateReset(&stream);
    } else if (status != Z_OK || (data.empty() && stream.avail_out > 0)) {
      return damaged(path, "gzip");
    }
  }
}

Result<std::string> unpacked_zstd(std::string_view data, const std::string& path) {
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                             ZSTD_freeDStream);
  if (stream == nullptr) return damaged(path, "Zstandard");
  std::string text, block(ZSTD_DStreamOutSize(), '\0');
  ZSTD_inBuffer input{data.data(), data.size(), 0};
  std::size_t left = 1;
  while (input.pos < input.size || left > 0) {
    ZSTD_outBuffer output{block.data(), block.size(), 0};
    const std::size_t before = input.pos;
    left = ZSTD_decompressStream(stream.get(), &output, &input);
    if (ZSTD_isError(left) != 0U || (output.pos == 0 && input.pos == before))
      return damaged(path, "Zstandard");
    text.append(block.data(), output.pos);
    if (text.size() > DecodedText::kLargestDecoded) return too_large(path);
  }
  return text;
}

void append_utf8(std::string& text, unsigned code) {
  const auto byte = [&text](unsigned value) { text += static_cast<char>(value); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) {
    byte(0xC0 | code >> 6);
  } else if (code < 0x10000) {
    byte(0xE0 | code >> 12);
    byte(0x80 | (code >> 6 & 0x3F));
  } else {
    byte(0xF0 | code >> 18);
    byte(0x80 | (code >> 12 & 0x3F));
    byte(0x80 | (code >> 6 & 0x3F));
  }
  byte(0x80 | (code & 0x3F));
}

/// 0: the text is not UTF-16; otherwise the position of the low byte in each pair, plus 1.
int utf16_order(std::string_view data) {
  if (data.starts_with("\xFF\xFE")) return 1;
  if (data.starts_with("\xFE\xFF")) return 2;
  const std::string_view head = data.substr(0, kProbed);
  std::array<std::size_t, 2> zeros{};
  for (std::size_t i = 0; i < head.size(); ++i) zeros[i % 2] += static_cast<std::size_t>(head[i] == '\0');
  if (zeros[1] > head.size() / 4 && zeros[0] < zeros[1] / 2) return 1;
  return zeros[0] > head.size() / 4 && zeros[1] < zeros[0] / 2 ? 2 : 0;
}

std::string from_utf16(std::string_view data, int order) {
  const auto unit = [&](std::size_t i) {
    const auto a = static_cast<unsigned char>(data[i]), b = static_cast<unsigned char>(data[i + 1]);
    return order == 1 ? a | static_cast<unsigned>(b) << 8 : b | static_cast<unsigned>(a) << 8;
  };
  std::string text;
  text.reserve(data.size() / 2);
  for (std::size_t i = 0; i + 1 < data.size(); i += 2) {
    unsigned code = unit(i);
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < data.size() && unit(i + 2) >= 0xDC00 &&
        unit(i + 2) < 0xE000) {
      code = 0x10000 + ((code - 0xD800) << 10) + (unit(i + 2) - 0xDC00);
      i += 2;
    } else if (code >= 0xD800 && code < 0xE000) {
      code = 0xFFFD;  // half of a pair
    }
    append_utf8(text, code);
  }
  return text;
}

/// Latin-1 as spreadsheets write it. Control characters and 0xFF are absent from it, but not from binary
/// files.
bool is_latin1(std::string_view data) {
  return std::ranges::all_of(data, [](unsigned char c) {
    return c == '\t' || c == '\n' || c == '\r' || (c >= 0x20 && c < 0x7F) || (c >= 0xA0 && c < 0xFF);
  });
}

std::string from_latin1(std::string_view data) {
  std::string text;
  text.reserve(data.size());
  for (const unsigned char c : data) append_utf8(text, c);
  return text;
}

}  // namespace

std::string_view DecodedText::text() const {
  return without_bom(is_converted_ ? std::string_view(converted_) : map_.text());
}

Result<DecodedText> DecodedText::open(const std::string& path) {
  auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  DecodedText decoded(std::move(*map));
  const auto replace = [&](std::string text, const char* note) {
    decoded.converted_ = std::move(text);
    decoded.is_converted_ = true;
    if (note != nullptr) decoded.notes_.push_back(fmt::format("{}: {}", path, note));
  };
  const std::string_view data = decoded.map_.text();
  if (data.starts_with("PK\x03\x04"))
    return fail({.file = path,
                 .found = "a zip archive, such as a workbook (.xlsx)",
                 .expected = "a text file",
                 .advice = "export the sheet as CSV, or extract the archive"});
  if (data.starts_with("\x1F\x8B") || data.starts_with("\x28\xB5\x2F\xFD")) {
    auto text = data.front() == '\x1F' ? gunzipped(data, path) : unpacked_zstd(data, path);
    if (!text) return fail(text.error());
    replace(std::move(*text), nullptr);
  }
  if (const int order = utf16_order(decoded.is_converted_ ? decoded.converted_ : data); order != 0)
    replace(from_utf16(decoded.is_converted_ ? decoded.converted_ : data, order), nullptr);
  if (const std::string_view text = decoded.text(); !is_utf8(text) && is_latin1(text))
    replace(from_latin1(text), "the text is not UTF-8; it is used as Latin-1");
  if (const std::string_view text = decoded.text();
      text.find('\r') != std::string_view::npos && text.find('\n') == std::string_view::npos) {
    std::string lines(text);
    std::ranges::replace(lines, '\r', '\n');
    replace(std::move(lines), nullptr);
  }
  if (auto checked = check_lines(decoded.text(), path); !checked) return fail(checked.error());
  return decoded;
}

}  // namespace octant::io

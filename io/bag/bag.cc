// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/bag.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "io/text/text.h"

namespace octant::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDatabaseMagic("SQLite format 3\0", 16);
constexpr std::size_t kMostBagFiles = 10'000;

std::string first_bytes(const fs::path& path) {
  std::string bytes(16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

/// bag_2.db3 before bag_10.db3.
bool earlier_file(const fs::path& a, const fs::path& b) {
  const std::string x = a.stem().string(), y = b.stem().string();
  return x.size() != y.size() ? x.size() < y.size() : x < y;
}

bool has_bag_ending(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.ends_with(".mcap") || name.ends_with(".db3") || name.ends_with(".mcap.zstd") ||
         name.ends_with(".db3.zstd");
}

std::vector<fs::path> bag_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
    if (has_bag_ending(at->path()) && files.size() < kMostBagFiles) files.push_back(at->path());
  std::ranges::sort(files, earlier_file);
  return files;
}

Result<void> read_bag_file(const std::string& path, const BagVisitor& visitor, BagSummary& summary) {
  if (path.ends_with(".zstd"))
    return fail({.file = path,
                 .found = "a bag that is compressed as a whole",
                 .expected = "an .mcap or .db3 file",
                 .advice = "decompress it first: zstd -d " + path});
  const std::string begin = first_bytes(path);
  if (begin == kDatabaseMagic) return read_bag_database(path, visitor, summary);
  return read_mcap(path, visitor, summary);
}

}  // namespace

bool is_bag(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return !bag_files(path).empty();
  const std::string begin = fs::is_regular_file(path, ignored) ? first_bytes(path) : std::string();
  return begin.starts_with(kMcapMagic) || begin == kDatabaseMagic || has_bag_ending(path);
}

Result<BagSummary> read_bag(const std::string& path, const BagVisitor& visitor) {
  BagSummary summary;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    if (auto read = read_bag_file(path, visitor, summary); !read) return fail(read.error());
    return summary;
  }
  const auto files = bag_files(path);
  if (files.empty())
    return fail({.file = path,
                 .found = "a folder without .mcap and .db3 files",
                 .expected = "a bag as rosbag2 records it"});
  for (const fs::path& file : files)
    if (auto read = read_bag_file(file.string(), visitor, summary); !read) return fail(read.error());
  return summary;
}

}  // namespace octant::io

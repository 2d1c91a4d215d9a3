// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace octant::test {

/// Memory limit of a process, adjusted for sanitizers. The address sanitizer adds its shadow and freed
/// memory; the thread sanitizer needs four times the used memory.
constexpr double with_sanitizer_mb(double mb) {
#ifdef __SANITIZE_THREAD__
  return 5.0 * mb + 300.0;
#elif defined(OCTANT_SANITIZED)
  return mb + 300.0;
#else
  return mb;
#endif
}

/// Outcome of a process.
struct Outcome {
  int exit = -1;  ///< 128 + signal where one ended it
  std::string out, err;
  double largest_mb = 0.0;  ///< maximum of its resident set
  /// Standard output as the one JSON object that it must be: one line, no NaN; null otherwise.
  [[nodiscard]] nlohmann::json json() const;
};

struct RunOptions {
  std::vector<std::string> environment;                 ///< KEY=value, in addition to the tests' own
  std::string folder;                                   ///< to run in
  bool on_terminal = false;                             ///< standard error is a terminal
  int interrupt_signal = 0;                             ///< sent after the first output on standard error
  std::string out_file;                                 ///< standard output goes there
  std::vector<std::pair<int, std::uint64_t>> limits{};  ///< limits of its resources: RLIMIT_AS, bytes
};

/// Runs the octant binary with these words.
[[nodiscard]] Outcome octant(const std::vector<std::string>& words, const RunOptions& options = {});

/// Runs it, and ends it by SIGKILL after some time. @return whether it had done its work by then
[[nodiscard]] bool octant_killed(const std::vector<std::string>& words, double after_s);

/// Returns true if this machine has pseudo-terminals; some containers mount no /dev/pts.
[[nodiscard]] bool has_terminals();

/// A folder of its own for a test, removed afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Names of what lies in it, hidden files included.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

[[nodiscard]] std::string slurp(const std::string& path);
void spit(const std::string& path, const std::string& content);
/// The hall of the demo as text, with one replacement, so that tests can ask for other worlds.
[[nodiscard]] std::string hall_scenario_text(const std::string& what = "", const std::string& by = "");

}  // namespace octant::test

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "io/atomic_file.h"
#include "io/run_parts.h"
#include "io/tum.h"

namespace octant::io {
namespace {

/// The files of one folder, read on demand; each one's digest goes into the log.
class RunReader {
 public:
  RunReader(const std::string& folder, const NameTable& names, const Timing& timing, const ReadRunOptions& options)
      : lookup_(names), clock_(timing.clock), options_(options) {
    log_.path = folder;
  }

  Result<MeasurementLog> read() {
    if (auto ok = check_folder(); !ok) return fail(ok.error());
    // run.yaml first: it names the vehicle that the rows of the others leave out.
    if (auto ok = read_header(); !ok) return fail(ok.error());
    const auto parts = {&RunReader::read_tof, &RunReader::read_bearings, &RunReader::read_scans, &RunReader::read_odometry,
                        &RunReader::read_tracks};
    for (const auto part : parts) {
      if (auto ok = (this->*part)(); !ok) return fail(ok.error());
    }
    if (auto ok = check_content(); !ok) return fail(ok.error());
    return std::move(log_);
  }

 private:
  [[nodiscard]] std::string path(const char* name) const {
    return log_.path.ends_with('/') ? log_.path + name : log_.path + "/" + name;
  }

  Result<void> check_folder() const {
    struct stat status {};
    if (::stat(log_.path.c_str(), &status) != 0) {
      return fail({.file = log_.path,
                   .found = fmt::format("the run folder cannot be read: {}", std::strerror(errno)),
                   .expected = "a folder with tof.csv, bearings.csv or scans.csv",
                   .advice = "check the path"});
    }
    if (S_ISDIR(status.st_mode)) return {};
    return fail({.file = log_.path,
                 .found = "this is a file",
                 .expected = "a run folder with tof.csv, bearings.csv or scans.csv",
                 .advice = "name the folder, not a file within it"});
  }

  /// Content of a file of the folder; nothing if there is no such name. A link that leads nowhere is an error, not an absence.
  Result<std::optional<std::string>> load(const char* name) {
    const std::string file = path(name);
    struct stat status {};
    if (::lstat(file.c_str(), &status) != 0 && errno == ENOENT) return std::nullopt;
    Result<std::string> text = read_file(file);
    if (!text) return fail(text.error());
    log_.sha256[file] = sha256_hex(*text);
    return std::optional<std::string>(std::move(*text));
  }

  Result<void> read_header() {
    const auto text = load("run.yaml");
    if (!text) return fail(text.error());
    if (lookup_.names().vehicles.empty()) {
      return fail({.file = log_.path, .found = "the site has no vehicle", .expected = "at least one"});
    }
    log_.vehicle = lookup_.default_vehicle;
    if (!*text) return {};
    const auto header = parse_run_yaml(**text, path("run.yaml"), log_);
    if (!header) return fail(header.error());
    range_max_m_ = header->range_max_m;
    if (header->vehicle.empty()) return {};
    log_.vehicle = lookup_.default_vehicle = lookup_.vehicle(header->vehicle);
    if (log_.vehicle.valid()) return {};
    return fail({.file = path("run.yaml"),
                 .found = fmt::format("vehicle {} is not in the site", in_quotes(header->vehicle)),
                 .expected = "a vehicle's id",
                 .advice = suggestion(header->vehicle, lookup_.names().vehicles)});
  }

  Result<void> read_tof() {
    const auto text = load("tof.csv");
    if (!text) return fail(text.error());
    return *text ? parse_tof(**text, path("tof.csv"), lookup_, clock_, log_) : Result<void>{};
  }

  Result<void> read_bearings() {
    const auto text = load("bearings.csv");
    if (!text) return fail(text.error());
    return *text ? parse_bearings(**text, path("bearings.csv"), lookup_, log_) : Result<void>{};
  }

  Result<void> read_scans() {
    const auto text = load("scans.csv");
    if (!text) return fail(text.error());
    return *text ? parse_scans(**text, path("scans.csv"), range_max_m_, log_) : Result<void>{};
  }

  Result<void> read_odometry() {
    const auto text = load("odometry.csv");
    if (!text) return fail(text.error());
    return *text ? parse_odometry(**text, path("odometry.csv"), lookup_, log_) : Result<void>{};
  }

  Result<void> read_tracks() {
    if (options_.read_poses) {
      if (auto ok = read_track("poses.tum", log_.poses); !ok) return ok;
    }
    return options_.read_truth ? read_track("truth.tum", log_.truth) : Result<void>{};
  }

  Result<void> read_track(const char* name, std::vector<TimedPose>& poses) {
    const auto text = load(name);
    if (!text) return fail(text.error());
    if (!*text) return {};
    auto track = tum_from_text(**text, path(name));
    if (!track) return fail(track.error());
    poses = std::move(*track);
    if (poses.empty() || log_.vehicle.valid()) return {};
    return fail(
        {.file = path(name),
         .found = fmt::format("it is open whose poses these are: the site has {} vehicles", lookup_.names().vehicles.size()),
         .expected = "'vehicle: ...' in run.yaml"});
  }

  Result<void> check_content() {
    if (!log_.vehicle.valid()) log_.vehicle = first_vehicle();
    if (!log_.arrivals.empty() || !log_.bearings.empty() || !log_.scans.empty()) return {};
    if (!log_.rejected.empty()) {
      return fail({.file = path("tof.csv"),
                   .line = log_.rejected.front().line,
                   .found = fmt::format("no arrival is left: all {} were rejected, here because {}", log_.rejected.size(),
                                        log_.rejected.front().reason),
                   .expected = "times of flight in seconds"});
    }
    const bool has_tof = log_.sha256.contains(path("tof.csv"));
    return fail({.file = has_tof ? path("tof.csv") : log_.path,
                 .found = has_tof ? "no arrivals: there are no rows under the header"
                                  : "the folder holds none of tof.csv, bearings.csv, scans.csv",
                 .expected = has_tof ? "at least one row here, in bearings.csv or in scans.csv" : "at least one of them",
                 .advice = has_tof ? "" : "is this the run folder?"});
  }

  [[nodiscard]] VehicleId first_vehicle() const {
    if (!log_.arrivals.empty()) return log_.arrivals.front().vehicle;
    return log_.bearings.empty() ? VehicleId(0) : log_.bearings.front().vehicle;
  }

  NameLookup lookup_;
  Clock clock_;
  ReadRunOptions options_;
  double range_max_m_ = std::numeric_limits<double>::infinity();
  MeasurementLog log_;
};

}  // namespace

Result<MeasurementLog> read_run(const std::string& folder, const NameTable& names, const Timing& timing,
                                const ReadRunOptions& options) {
  return RunReader(folder, names, timing, options).read();
}

Result<void> write_run(const std::string& folder, const MeasurementLog& log, const NameTable& names) {
  struct Part {
    const char* name;
    std::string text;  // empty: not part of this run
  };
  // run.yaml last: whoever watches the folder finds the rest complete.
  const Part parts[] = {{"tof.csv", log.arrivals.empty() ? "" : tof_to_csv(log, names)},
                        {"bearings.csv", log.bearings.empty() ? "" : bearings_to_csv(log, names)},
                        {"scans.csv", log.scans.empty() ? "" : scans_to_csv(log)},
                        {"odometry.csv", log.odometry.empty() ? "" : odometry_to_csv(log, names)},
                        {"poses.tum", log.poses.empty() ? "" : poses_to_tum(log.poses)},
                        {"truth.tum", log.truth.empty() ? "" : poses_to_tum(log.truth)},
                        {"run.yaml", run_to_yaml(log, names)}};
  const std::filesystem::path root(folder);
  std::error_code status;
  for (const Part& part : parts) {
    if (!part.text.empty() || !std::filesystem::exists(root / part.name, status)) continue;
    return fail({.code = Errc::kOutput,
                 .file = (root / part.name).string(),
                 .found = "the folder holds a file that is not part of this run, and would become part of it",
                 .advice = "remove it, or choose another folder"});
  }
  std::filesystem::create_directory(root, status);
  if (status) {
    return fail({.code = Errc::kOutput,
                 .file = folder,
                 .found = "the run folder cannot be made: " + status.message(),
                 .advice = "check that the folder above it exists and may be written"});
  }
  for (const Part& part : parts) {
    if (part.text.empty()) continue;
    if (auto ok = write_file((root / part.name).string(), part.text); !ok) return ok;
  }
  return {};
}

}  // namespace octant::io

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/progress.h"
#include "apps/octant/ranks.h"
#include "apps/octant/steps.h"
#include "apps/octant/stream_source.h"
#include "apps/octant/table.h"
#include "calib/streamed.h"
#include "io/atomic_file.h"
#include "io/site_yaml.h"
#include "survey/report.h"

namespace octant::app {
namespace {

std::string in_words(Rejection reason) {
  switch (reason) {
    case Rejection::kUsed: return "used";
    case Rejection::kLate: return "late (echo)";
    case Rejection::kEarly: return "early (spurious)";
    case Rejection::kBeaconUnusable: return "beacon undetermined";
    case Rejection::kNoPose: return "no vehicle pose at its time";
    case Rejection::kTriangle: return "breaks the triangle inequality";
    case Rejection::kOutOfRange: return "farther or nearer than is possible";
    case Rejection::kReflection: return "right behind another of its beacon";
    case Rejection::kOutvoted: return "outvoted";
    case Rejection::kNotNeeded: return "not needed";
  }
  return "other";
}

calib::Provenance provenance(const std::string& site_path, const std::string& site_sha256, const std::vector<const MeasurementLog*>& runs,
                             const Session& session) {
  calib::Provenance from;
  from.created = created_now();
  from.version = OCTANT_VERSION;
  from.command = session.command_line;
  from.inputs.push_back({site_path, site_sha256});
  for (const MeasurementLog* run : runs)
    for (const auto& [path, sha256] : run->sha256) from.inputs.push_back({path, sha256});
  return from;
}

/// Calls solve(options) with progress shown.
template <class Solve>
auto with_progress(bool strict, Session& session, Solve&& solve) {
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::SolveOptions options;
  options.threads = session.threads();
  options.ranks = session.job != nullptr ? session.job->ranks() : nullptr;
  options.strict = strict;
  options.on_progress = [&](const calib::Progress& p) {
    reporter.show(p.stage, p.iteration, p.cost, p.fraction);
    return !interrupted();
  };
  return solve(options);
}

/// Recordings that are to be streamed; none where they fit into memory or cannot be, which is said.
Result<std::unique_ptr<StreamSource>> too_long(const Site& site, const std::vector<std::string>& runs, std::size_t memory_mb, Session& session) {
  constexpr std::size_t kMega = std::size_t{1} << 20;
  if (fits_for_sure(runs, memory_mb * kMega)) return nullptr;
  const ExitAtOnce nothing_written_yet;
  auto source = StreamSource::open(runs, names_of(site), site.timing, session);
  if (!source) return fail(source.error());
  const std::size_t rows = (*source)->rows_estimate(), needed_mb = calib::memory_of_whole(rows) / kMega;
  if (needed_mb <= memory_mb) return nullptr;
  const std::string much = fmt::format("these recordings would take about {} MB of memory, more than --memory-mb {}", needed_mb, memory_mb);
  if (const auto why = calib::why_not_streamed(site, (*source)->logs())) {
    session.warn(fmt::format("{}, and cannot be streamed: {}", much, *why));
    return nullptr;
  }
  const std::size_t least_mb = calib::least_memory_streamed(rows) / kMega;
  session.note(fmt::format("{}: they are read in chunks, several times{}", much,
                           least_mb > memory_mb ? fmt::format("; about {} MB is the least that takes", least_mb) : ""));
  return source;
}

/// All of the recordings at once.
Result<void> read_problem(Site site, const std::vector<std::string>& run_paths, const std::string& site_sha256, Session& session, Calibration& result) {
  const ExitAtOnce nothing_written_yet;
  auto runs = read_runs(run_paths, names_of(site), site.timing, {}, session);
  if (!runs) return fail(runs.error());
  std::vector<const MeasurementLog*> logs;
  for (const MeasurementLog& run : *runs) logs.push_back(&run);
  result.provenance = provenance(site.path, site_sha256, logs, session);
  auto problem = calib::make_problem(std::move(site), std::move(*runs), session.threads());
  if (!problem) return fail(problem.error());
  result.problem = std::move(*problem);
  return {};
}

std::string beacon_table(const Deployment& deployment) {
  double largest_sigma_m = 0.0, largest_delay_s = 0.0;
  for (const auto& b : deployment.beacons) {
    if (b.status == BeaconStatus::kUndetermined) continue;
    largest_sigma_m = std::max(largest_sigma_m, std::sqrt(std::max(0.0, b.covariance_m2.diagonal().maxCoeff())));
    largest_delay_s = std::max({largest_delay_s, std::abs(b.delay_s), b.delay_sigma_s});
  }
  const Unit length = length_unit(largest_sigma_m), time = time_unit(largest_delay_s);
  const bool delays = largest_delay_s > 0.0;  // else none is asked for, and columns of zeros would only distract
  Table table{delays ? "lrrrrrrrrl" : "lrrrrrrl", {{"beacon", "x [m]", "y [m]", "z [m]", fmt::format("sx [{}]", length.name), "sy", "sz"}}};
  if (delays) table.rows[0].insert(table.rows[0].end(), {fmt::format("delay [{}]", time.name), "s"});
  for (const auto& b : deployment.beacons) {
    std::vector<std::string> row = {b.name};
    if (b.status == BeaconStatus::kUndetermined) {
      row.resize(table.rows[0].size(), "-");
      row.emplace_back("undetermined");
    } else {
      for (int i = 0; i < 3; ++i) row.push_back(fmt::format("{:.4f}", b.position_m[i]));
      for (int i = 0; i < 3; ++i) row.push_back(fmt::format("{:.2f}", length.per_si * std::sqrt(std::max(0.0, b.covariance_m2(i, i)))));
      if (delays) row.insert(row.end(), {fmt::format("{:.3f}", time.per_si * b.delay_s), fmt::format("{:.3f}", time.per_si * b.delay_sigma_s)});
      row.emplace_back(b.status == BeaconStatus::kControlPoint ? "control point" : "");
    }
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

}  // namespace

Result<Calibration> calibrate_files(const std::string& site_path, const std::vector<std::string>& run_paths, const CalibrateOptions& how,
                                    Session& session) {
  Calibration result;
  auto site = io::read_site(site_path);
  if (!site) return fail(site.error());
  const auto bytes = io::read_file(site_path);
  if (!bytes) return fail(bytes.error());
  const std::string sha256 = io::sha256_hex(*bytes);
  session.warn(site->warnings);
  auto source = too_long(*site, run_paths, how.memory_mb, session);
  if (!source) return fail(source.error());
  if (*source != nullptr) {
    auto streamed = with_progress(how.strict, session, [&](const calib::SolveOptions& options) {
      return calib::solve_streamed(*site, **source, options, how.memory_mb << 20U);
    });
    if (!streamed) return fail(streamed.error());
    result.provenance = provenance(site_path, sha256, (*source)->logs(), session);
    result.problem = std::move(streamed->problem);
    result.solution = std::move(streamed->solution);
  } else {
    if (auto ok = read_problem(std::move(*site), run_paths, sha256, session, result); !ok) return fail(ok.error());
    session.warn(result.problem.warnings);
    result.solution = with_progress(how.strict, session, [&](const calib::SolveOptions& options) { return calib::solve_in_place(result.problem, options); });
  }
  session.warn(result.solution.warnings);
  if (result.solution.status == calib::SolveStatus::kConverged) {
    result.deployment = calib::make_deployment(result.problem, result.solution, result.provenance);
  }
  return result;
}

std::map<std::string, std::size_t> left_out_by_reason(const Calibration& calibration) {
  std::map<std::string, std::size_t> counts;
  for (const auto& arrival : calibration.solution.left_out) ++counts[in_words(arrival.reason)];
  if (const auto& whole = calibration.solution.whole) {
    for (const auto& of_beacon : whole->of_beacon)
      for (std::size_t reason = 0; reason < of_beacon.size(); ++reason)
        if (const auto r = static_cast<Rejection>(reason); r != Rejection::kUsed && of_beacon[reason] > 0) counts[in_words(r)] += of_beacon[reason];
  }
  for (const auto& run : calibration.problem.runs)
    for (const auto& row : run.rejected) ++counts[row.reason];
  return counts;
}

Json left_out_json(const Calibration& calibration) {
  Json by_reason = Json::object(), by_beacon = Json::object();
  std::size_t total = 0;
  for (const auto& [reason, count] : left_out_by_reason(calibration)) {
    by_reason[reason] = count;
    total += count;
  }
  std::map<std::size_t, std::size_t> beacons;
  for (const auto& left : calibration.solution.left_out) {
    if (left.run >= calibration.problem.runs.size() || left.arrival >= calibration.problem.runs[left.run].arrivals.size()) continue;
    const BeaconId beacon = calibration.problem.runs[left.run].arrivals[left.arrival].beacon;
    if (beacon.valid() && beacon.index() < calibration.problem.site.beacons.size()) ++beacons[beacon.index()];
  }
  if (const auto& whole = calibration.solution.whole) {
    for (std::size_t b = 0; b < whole->of_beacon.size(); ++b) {
      const auto& counts = whole->of_beacon[b];
      const std::size_t out = std::accumulate(counts.begin() + 1, counts.end(), std::size_t{0});  // all but kUsed
      if (out > 0) beacons[b] = out;
    }
  }
  for (const auto& [index, count] : beacons) by_beacon[calibration.problem.site.beacons[index].name] = count;
  return {{"total", total}, {"by_reason", by_reason}, {"by_beacon", by_beacon}};
}

std::string calibration_text(const Calibration& calibration) {
  const Deployment& d = *calibration.deployment;
  const calib::Solution& s = calibration.solution;
  std::string text = fmt::format("{}: calibrated, {} iterations, {:.2f} s\n\n", d.site, s.iterations, s.seconds) + beacon_table(d) + "\n";
  const auto line = [&](const char* name, const std::string& what) { text += fmt::format("{:<17}{}\n", name, what); };
  line("speed", survey::speed_in_words(d));
  if (d.attenuation) {
    line("time-walk", fmt::format("{:.4g} V at 1 m, absorption {:.4g} Np/m, rise time constant {}", d.attenuation->amplitude_1m_v,
                                  d.attenuation->absorption_np_per_m, time_text(d.attenuation->rise_time_s)));
    if (d.attenuation->directional()) line("receivers", survey::directivity_in_words(d));
  }
  std::string reasons;
  for (const auto& [reason, count] : left_out_by_reason(calibration)) reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, reason);
  line("arrivals", fmt::format("{} used, {} left out{}", d.statistics.arrivals, d.statistics.rejected, reasons.empty() ? "" : ": " + reasons));
  line("unknowns", fmt::format("{}, redundancy {:.0f}", d.statistics.unknowns, d.statistics.redundancy));
  line("residuals", fmt::format("{} RMS; variance factor {:.3f}, p = {:.2g}", time_text(d.statistics.rms_s), d.statistics.variance_factor,
                                d.statistics.chi2_p));
  line("datum", d.datum.description);
  for (const auto& weak : s.weak) {
    const std::string known = weak.sigma_m > 0 ? fmt::format(" known to {}, {} at the robot", length_text(weak.sigma_m), length_text(weak.consequence_m)) : "";
    line("weak", fmt::format("{}{}{}", weak.description, known, weak.remedy.empty() ? "" : "; settled by: " + weak.remedy));
  }
  return text + reliability_text(calibration);
}

}  // namespace octant::app

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
#include "apps/octant/steps/steps.h"
#include "apps/octant/stream_source.h"
#include "apps/octant/text/layout.h"
#include "calib/streamed.h"
#include "io/clocks/clock_files.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "survey/report/report.h"

namespace octant::app {
namespace {

std::string reason_in_words(Rejection reason) {
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
    case Rejection::kUnknownId: return "unknown";
    case Rejection::kBeaconFault: return "its beacon contradicts the others";
  }
  return "other";
}

survey::LeftOutCause cause_of(Rejection reason) {
  switch (reason) {
    case Rejection::kLate: return survey::LeftOutCause::kLate;
    case Rejection::kEarly: return survey::LeftOutCause::kEarly;
    case Rejection::kNoPose: return survey::LeftOutCause::kNoPose;
    default: return survey::LeftOutCause::kOther;
  }
}

/// The calibration adds the digests of the recordings.
calib::Provenance provenance(const std::string& site_path, const std::string& site_sha256,
                             const Session& session) {
  calib::Provenance from;
  from.created = created_now();
  from.version = OCTANT_VERSION;
  from.command = session.command_line;
  from.inputs.push_back({site_path, site_sha256});
  return from;
}

/// Calibrates by `calibrate(options)`, with progress and findings, and reports the outcome.
template <class Calibrate>
Calibration calibrated(calib::Provenance from, const CalibrateOptions& how, Session& session,
                       Calibrate&& calibrate) {
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::CalibrationOptions options{
      .solve = solve_options(session, reporter),
      .provenance = std::move(from),
      .memory_bytes = how.memory_mb << 20U,
      .on_finding = [&session](const calib::Finding& f) { session.warn(f.text); }};
  options.solve.ranks = session.job != nullptr ? session.job->ranks() : nullptr;
  options.solve.strict = how.strict;
  Calibration result{need(calibrate(options)), how.accept};
  session.warn(result.problem.warnings);
  session.warn(result.solution.warnings);
  stop_if_interrupted(result.solution.status == calib::SolveStatus::kInterrupted);
  return result;
}

/// Source of recordings that have to be streamed; null if they fit into memory.
std::unique_ptr<StreamSource> too_long(const Site& site, const std::vector<std::string>& runs,
                                       std::size_t memory_mb, Session& session) {
  constexpr std::size_t kMega = std::size_t{1} << 20;
  if (fits_for_sure(runs, memory_mb * kMega)) return nullptr;
  const ExitAtOnce nothing_written_yet;
  auto source =
      need(StreamSource::open(runs, names_of(site), site.timing, session, constant_speed_mps(site.medium)));
  const std::size_t rows = source->rows_estimate(), steps = source->odometry_rows(),
                    needed_mb = calib::memory_of_held(rows, steps) / kMega;
  if (needed_mb <= memory_mb) return nullptr;
  const std::string much = fmt::format(
      "these recordings would take about {} MB of memory, more than --memory-mb {}", needed_mb, memory_mb);
  const std::size_t least_mb = calib::least_memory_streamed(site, source->logs(), rows, steps) / kMega;
  warn_of_repeated_runs(runs, session);
  session.note(fmt::format(
      "{}: they are read in chunks, several times{}", much,
      least_mb > memory_mb ? fmt::format("; about {} MB is the least that takes", least_mb) : ""));
  return source;
}

/// All of the recordings.
std::vector<MeasurementLog> read_runs_at_once(const std::vector<std::string>& paths, const Site& site,
                                              Session& session) {
  const ExitAtOnce nothing_written_yet;
  return read_runs(paths, site, {}, session);
}

std::string beacon_table(const Deployment& deployment) {
  double largest_sigma_m = 0.0, largest_delay_s = 0.0;
  for (const auto& b : deployment.beacons) {
    if (b.status == BeaconStatus::kUndetermined) continue;
    largest_sigma_m =
        std::max(largest_sigma_m, std::sqrt(std::max(0.0, b.covariance_m2.diagonal().maxCoeff())));
    largest_delay_s = std::max({largest_delay_s, std::abs(b.delay_s), b.delay_sigma_s});
  }
  const Unit length = length_unit(largest_sigma_m), time = time_unit(largest_delay_s);
  const bool delays =
      largest_delay_s > 0.0;  // otherwise no delay is estimated, and the columns would contain zeros
  Table table{delays ? "lrrrrrrrrl" : "lrrrrrrl",
              {{"beacon", "x [m]", "y [m]", "z [m]", fmt::format("sx [{}]", length.name), "sy", "sz"}}};
  if (delays) table.rows[0].insert(table.rows[0].end(), {"delay", fmt::format("s [{}]", time.name)});
  for (const auto& b : deployment.beacons) {
    std::vector<std::string> row = {b.name};
    if (b.status == BeaconStatus::kUndetermined) {
      row.resize(table.rows[0].size(), "-");
      row.emplace_back("undetermined");
    } else {
      for (int i = 0; i < 3; ++i) row.push_back(fmt::format("{:.4f}", b.position_m[i]));
      for (int i = 0; i < 3; ++i) {
        const double sigma_m = std::sqrt(std::max(0.0, b.covariance_m2(i, i)));
        row.push_back(sigma_m > 0 ? fmt::format("{:.2f}", length.per_si * sigma_m) : "fixed");
      }
      if (delays)
        row.insert(row.end(), {fmt::format("{:.2f}", time.per_si * b.delay_s),
                               fmt::format("{:.2f}", time.per_si * b.delay_sigma_s)});
      row.emplace_back(b.status == BeaconStatus::kControlPoint ? "control" : "");
    }
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

}  // namespace

calib::SolveOptions solve_options(const Session& session, ProgressReporter& reporter, double share) {
  calib::SolveOptions options;
  options.threads = session.threads();
  options.on_progress = [&reporter, share](const calib::Progress& p) {
    reporter.show(p.stage, p.iteration, p.cost, share * p.fraction);
    return !interrupted();
  };
  return options;
}

Json weak_json(const std::vector<calib::WeakDirection>& weak) {
  Json list = Json::array();
  for (const auto& w : weak)
    list.push_back({{"description", w.description},
                    {"parameters", w.parameters},
                    {"sigma_m", w.sigma_m},
                    {"consequence_m", w.consequence_m},
                    {"remedy", w.remedy},
                    {"blocking", w.blocking}});
  return list;
}

Calibration calibrate_runs(Site site, std::vector<MeasurementLog> runs, const std::string& site_sha256,
                           const CalibrateOptions& how, Session& session, BeaconFlights between_beacons) {
  calib::Provenance from = provenance(site.path, site_sha256, session);
  from.inputs.insert(from.inputs.end(), between_beacons.inputs.begin(), between_beacons.inputs.end());
  return calibrated(std::move(from), how, session, [&](calib::CalibrationOptions options) {
    options.beacon_flights = std::move(between_beacons.flights);
    return calib::calibrate(std::move(site), std::move(runs), options);
  });
}

namespace {

/// Calibrates recordings of devices with clocks of their own.
Calibration calibrate_clock_files(Site site, const std::string& site_sha256,
                                  const std::vector<std::string>& run_paths, const CalibrateOptions& how,
                                  Session& session) {
  calib::ClockInput clocks{{}, need(io::read_clock_model(site.path, site))};
  for (const std::string& path : run_paths)
    clocks.logs.push_back(need(io::read_clock_log(path, names_of(site))));
  std::vector<MeasurementLog> runs = read_runs_at_once(run_paths, site, session);
  calib::Provenance from = provenance(site.path, site_sha256, session);
  for (const MeasurementLog& run : runs)
    for (const auto& [path, sha256] : run.sha256) from.inputs.push_back({path, sha256});
  return calibrated(std::move(from), how, session, [&](calib::CalibrationOptions options) {
    options.clocks = std::move(clocks);
    return calib::calibrate(std::move(site), std::move(runs), options);
  });
}

}  // namespace

Calibration calibrate_files(const std::string& site_path, const std::vector<std::string>& run_paths,
                            const CalibrateOptions& how, Session& session) {
  Site site = need(io::read_site(site_path));
  const std::string sha256 = io::sha256_hex(need(io::read_document(site_path)));
  session.warn(site.warnings);
  if (std::ranges::any_of(run_paths, io::has_clock_log))
    return calibrate_clock_files(std::move(site), sha256, run_paths, how, session);
  BeaconFlights between_beacons = read_beacon_flights(run_paths, names_of(site), session);
  if (const auto source = too_long(site, run_paths, how.memory_mb, session)) {
    if (!between_beacons.flights.empty())
      session.warn("beacon_tof.csv is not used for recordings that are read in chunks: raise --memory-mb");
    return calibrated(
        provenance(site_path, sha256, session), how, session,
        [&](const calib::CalibrationOptions& options) { return calib::calibrate(site, *source, options); });
  }
  std::vector<MeasurementLog> runs = read_runs_at_once(run_paths, site, session);
  return calibrate_runs(std::move(site), std::move(runs), sha256, how, session, std::move(between_beacons));
}

std::vector<survey::LeftOutNote> left_out_by_reason(const Calibration& calibration) {
  std::map<std::string, survey::LeftOutNote> notes;
  const auto count = [&](Rejection reason, std::size_t more) {
    survey::LeftOutNote& note = notes[reason_in_words(reason)];
    note.count += more;
    note.cause = cause_of(reason);
  };
  for (const auto& arrival : calibration.solution.left_out) count(arrival.reason, 1);
  if (const auto& whole = calibration.solution.totals) {
    for (const auto& of_beacon : whole->of_beacon)
      for (std::size_t reason = 0; reason < of_beacon.size(); ++reason)
        if (const auto r = static_cast<Rejection>(reason); r != Rejection::kUsed && of_beacon[reason] > 0)
          count(r, of_beacon[reason]);
  }
  for (const auto& run : calibration.problem.runs)
    for (const auto& row : run.rejected) ++notes[row.reason].count;
  std::vector<survey::LeftOutNote> list;
  for (auto& [reason, note] : notes) {
    note.reason = reason;
    list.push_back(std::move(note));
  }
  return list;
}

void warn_if_contradicted(const Deployment& deployment, const std::string& path, Session& session) {
  for (const Contradiction& c : deployment.contradictions) {
    session.warn(fmt::format("{} was exported although its data contradict its site file: {}; {}", path,
                             in_words(c), c.remedy));
  }
}

namespace {

/// Counts of rejected observations of one kind, by reason and by beacon.
class LeftOutCounts {
 public:
  void add(const std::string& reason, std::size_t count = 1) {
    by_reason_[reason] += count;
    total_ += count;
  }
  void add_of(const std::string& subject, std::size_t count = 1) { by_subject_[subject] += count; }
  [[nodiscard]] Json json(const char* subject) const {
    return {{"total", total_}, {"by_reason", by_reason_}, {subject, by_subject_}};
  }

 private:
  std::size_t total_ = 0;
  std::map<std::string, std::size_t> by_reason_, by_subject_;
};

Json arrivals_left_out(const Calibration& calibration) {
  const auto& beacons = calibration.problem.site.beacons;
  LeftOutCounts counts;
  for (const auto& note : left_out_by_reason(calibration)) counts.add(note.reason, note.count);
  for (const auto& left : calibration.solution.left_out) {
    if (left.run >= calibration.problem.runs.size() ||
        left.arrival >= calibration.problem.runs[left.run].arrivals.size())
      continue;
    const BeaconId beacon = calibration.problem.runs[left.run].arrivals[left.arrival].beacon;
    if (beacon.valid() && beacon.index() < beacons.size()) counts.add_of(beacons[beacon.index()].name);
  }
  if (const auto& whole = calibration.solution.totals) {
    for (std::size_t b = 0; b < whole->of_beacon.size(); ++b) {
      const auto& of_beacon = whole->of_beacon[b];
      const std::size_t out =
          std::accumulate(of_beacon.begin() + 1, of_beacon.end(), std::size_t{0});  // all except kUsed
      if (out > 0) counts.add_of(beacons[b].name, out);
    }
  }
  return counts.json("by_beacon");
}

Json bearings_left_out(const Calibration& calibration) {
  LeftOutCounts counts;
  for (const auto& left : calibration.solution.left_out_bearings) {
    const BeaconId reflector = calibration.problem.runs[left.run].bearings[left.bearing].reflector;
    const bool misfit = left.reason == Rejection::kLate || left.reason == Rejection::kEarly;
    counts.add(!reflector.valid() ? "unlabelled" : misfit ? "does not fit" : reason_in_words(left.reason));
    if (reflector.valid()) counts.add_of(calibration.problem.site.beacons[reflector.index()].name);
  }
  return counts.json("by_beacon");
}

Json poses_left_out(const Calibration& calibration) {
  LeftOutCounts counts;
  for (const auto& left : calibration.solution.left_out_poses) {
    counts.add(left.reason == Rejection::kNotNeeded ? "nothing was heard or seen at its time"
                                                    : reason_in_words(left.reason));
    counts.add_of(calibration.problem.runs[left.run].path);
  }
  return counts.json("by_run");
}

}  // namespace

Json left_out_json(const Calibration& calibration) {
  return {{"arrivals", arrivals_left_out(calibration)},
          {"bearings", bearings_left_out(calibration)},
          {"poses", poses_left_out(calibration)}};
}

std::string calibration_text(const Calibration& calibration) {
  const Deployment& d = *calibration.deployment;
  const calib::Solution& s = calibration.solution;
  std::string text = fmt::format("{}: calibrated, {} iterations, {:.2f} s\n\n",
                                 d.site.empty() ? "site without a name" : d.site, s.iterations, s.seconds) +
                     beacon_table(d) + "\n";
  const auto line = [&](const char* name, const std::string& what) { text += named_line(name, what); };
  line("speed", survey::speed_in_words(d));
  if (d.attenuation) {
    line("time-walk", fmt::format("{:.4g} V at 1 m, absorption {:.4g} Np/m, rise time constant {}",
                                  d.attenuation->amplitude_1m_v, d.attenuation->absorption_np_per_m,
                                  time_text(d.attenuation->rise_time_s)));
    if (d.attenuation->directional()) line("receivers", survey::directivity_in_words(d));
  }
  const std::string reasons = joined(left_out_by_reason(calibration), ", ", [](const auto& note) {
    return fmt::format("{} {}", note.count, note.reason);
  });
  line("arrivals", fmt::format("{} used, {} left out{}", d.statistics.arrivals, d.statistics.rejected,
                               reasons.empty() ? "" : ": " + reasons));
  line("unknowns", fmt::format("{}, redundancy {:.0f}", d.statistics.unknowns, d.statistics.redundancy));
  line("residuals", fmt::format("{} RMS; variance factor {:.3f}, p = {:.2g}", time_text(d.statistics.rms_s),
                                d.statistics.variance_factor, d.statistics.chi2_p));
  line("datum", d.datum.description);
  for (const auto& weak : s.weak) {
    const std::string known = weak.sigma_m > 0
                                  ? fmt::format(" known to {}, {} at the robot", length_text(weak.sigma_m),
                                                length_text(weak.consequence_m))
                                  : "";
    line("weak", fmt::format("{}{}{}", weak.description, known,
                             weak.remedy.empty() ? "" : "; remedy: " + weak.remedy));
  }
  return text + reliability_text(calibration);
}

}  // namespace octant::app

// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ctime>
#include <memory>
#include <set>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/commands/history_args.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"
#include "io/text/text.h"
#include "models/support/utc_time.h"

namespace octant::app {
namespace {

std::string day_of(std::int64_t seconds) { return utc_text(seconds).substr(0, 10); }

std::string temperature_text(const io::Visit& v) {
  if (!v.temperature_degC) return "";
  const auto [coldest, warmest] = *v.temperature_degC;
  return warmest - coldest < 0.05 ? fmt::format("{:.1f}", coldest)
                                  : fmt::format("{:.1f} to {:.1f}", coldest, warmest);
}

/// Grades a calibration like a report of its deployment.
io::Visit graded_visit(const std::string& path, const HistoryArgs& args, const Session& session) {
  io::Visit visit = need(io::read_visit(path));
  if (visit.kind == io::VisitKind::kCalibration) {
    const Deployment deployment = need(io::deployment_from_json(visit.document, path));
    visit.verdict = survey::to_string(survey::verdict(report_input(deployment, session)).grade);
  }
  visit.who = args.who;
  visit.note = args.note;
  visit.added_s = static_cast<std::int64_t>(std::time(nullptr));
  return visit;
}

int add(const HistoryArgs& args, Session& session) {
  check_no_overwriting({.inputs = args.files, .outputs = {args.database}});
  std::vector<io::Visit> visits;
  for (const std::string& path : args.files) visits.push_back(graded_visit(path, args, session));
  const std::vector<io::Addition> added = need(need(io::History::open(args.database, true)).add(visits));
  Json list = Json::array();
  std::size_t fresh = 0;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    const io::Addition& a = added[i];
    fresh += a.is_new;
    list.push_back({{"id", a.id},
                    {"new", a.is_new},
                    {"kind", to_string(visits[i].kind)},
                    {"site", visits[i].site},
                    {"date", utc_text(visits[i].happened_s)},
                    {"digest", visits[i].digest},
                    {"verdict", visits[i].verdict},
                    {"source", visits[i].source}});
    session.result(fmt::format("{:<17}{} {} of {}, {}: {}\n", a.is_new ? "added" : "there already",
                               to_string(visits[i].kind), a.id, visits[i].site, day_of(visits[i].happened_s),
                               visits[i].verdict));
  }
  return session.finish({{"database", args.database}, {"added", fresh}, {"visits", list}});
}

std::vector<io::Visit> chosen_visits(io::History& history, const HistoryArgs& args) {
  io::VisitFilter filter{.site = args.site, .kind = {}};
  for (const auto kind :
       {io::VisitKind::kCalibration, io::VisitKind::kMonitoring, io::VisitKind::kVerification})
    if (args.kind == to_string(kind)) filter.kind = kind;
  return need(history.list(filter));
}

int list(const HistoryArgs& args, Session& session) {
  io::History history = need(io::History::open(args.database, false));
  const std::vector<io::Visit> visits = chosen_visits(history, args);
  Json rows = Json::array();
  Table table{"rlllllrll",
              {{"id", "date", "kind", "site", "verdict", "air [degC]", "speed [m/s]", "operator", "note"}}};
  for (const io::Visit& v : visits) {
    if (session.options.json) {
      rows.push_back(visit_json(v));
      continue;
    }
    table.rows.push_back({fmt::format("{}", v.id), day_of(v.happened_s), to_string(v.kind), v.site, v.verdict,
                          temperature_text(v), v.speed ? fmt::format("{:.3f}", v.speed->speed_mps) : "",
                          v.who, v.note});
  }
  session.result(visits.empty() ? std::string("no visits\n") : table.text());
  Json object = {{"database", args.database}};
  object["visits"] = std::move(rows);  // an initialiser list would copy them
  return session.finish(object);
}

std::string beacons_text(const io::Visit& v) {
  if (v.beacons.empty()) return "";
  double time_s = 0.0;
  for (const auto& b : v.beacons) time_s = std::max({time_s, std::abs(b.delay_s), b.delay_sigma_s});
  const Unit time = time_unit(time_s);
  Table table{
      "lrrrrrrrrl",
      {{"beacon", "x [m]", "y [m]", "z [m]", "sx [mm]", "sy", "sz", "delay [" + time.name + "]", "s", ""}}};
  for (const auto& b : v.beacons) {
    std::vector<std::string> row = {b.name};
    for (int i = 0; i < 3; ++i) row.push_back(fmt::format("{:.4f}", b.position_m[i]));
    for (int i = 0; i < 3; ++i) row.push_back(fmt::format("{:.2f}", 1e3 * b.sigma_m[i]));
    row.insert(row.end(), {fmt::format("{:.3f}", time.per_si * b.delay_s),
                           fmt::format("{:.3f}", time.per_si * b.delay_sigma_s),
                           b.status == BeaconStatus::kCalibrated ? "" : to_string(b.status)});
    table.rows.push_back(std::move(row));
  }
  return "\n" + table.text();
}

int show(const HistoryArgs& args, Session& session) {
  const io::Visit visit = need(need(io::History::open(args.database, false)).get(args.id));
  std::string text;
  const auto line = [&text](const char* name, const std::string& what) {
    if (!what.empty()) text += fmt::format("{:<17}{}\n", name, what);
  };
  line(to_string(visit.kind), fmt::format("{} of {}", visit.id, visit.site));
  line("date", utc_text(visit.happened_s));
  line("added", utc_text(visit.added_s));
  line("verdict", visit.verdict);
  line("air [degC]", temperature_text(visit));
  if (visit.speed)
    line("speed", fmt::format("{:.5f} m/s, sigma {:.3f} m/s, at {:g} degC", visit.speed->speed_mps,
                              visit.speed->sigma_mps, visit.speed->temperature_degC));
  line("operator", visit.who);
  line("note", visit.note);
  line("source", visit.source);
  line("digest", visit.digest);
  line("deployment", visit.deployment_digest);
  session.result(text + beacons_text(visit));
  Json object = visit_json(visit);
  object["beacons"] = visit_beacons_json(visit);
  object["document"] = Json::parse(visit.document, nullptr, false);
  return session.finish({{"database", args.database}, {"visit", object}});
}

/// One row for each beacon of a calibration, and one for each other visit.
std::string export_csv(const std::vector<io::Visit>& visits) {
  std::string text =
      "id,date,kind,site,verdict,operator,note,digest,deployment_digest,coldest_degC,warmest_degC,speed_mps,"
      "speed_sigma_mps,"
      "beacon,status,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,delay_s,delay_sigma_s\n";
  for (const io::Visit& v : visits) {
    std::string head = fmt::format(
        "{},{},{},{},{},{},{},{},{}", v.id, utc_text(v.happened_s), to_string(v.kind), io::csv_field(v.site),
        io::csv_field(v.verdict), io::csv_field(v.who), io::csv_field(v.note), v.digest, v.deployment_digest);
    head +=
        v.temperature_degC ? fmt::format(",{},{}", (*v.temperature_degC)[0], (*v.temperature_degC)[1]) : ",,";
    head += v.speed ? fmt::format(",{},{}", v.speed->speed_mps, v.speed->sigma_mps) : ",,";
    if (v.beacons.empty()) text += head + ",,,,,,,,,,\n";
    for (const io::VisitBeacon& b : v.beacons)
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", head, io::csv_field(b.name),
                          to_string(b.status), b.position_m.x(), b.position_m.y(), b.position_m.z(),
                          b.sigma_m.x(), b.sigma_m.y(), b.sigma_m.z(), b.delay_s, b.delay_sigma_s);
  }
  return text;
}

std::string export_json(const std::vector<io::Visit>& visits) {
  Json list = Json::array();
  for (const io::Visit& v : visits) {
    Json object = visit_json(v);
    object["beacons"] = visit_beacons_json(v);
    object["document"] = Json::parse(v.document, nullptr, false);
    list.push_back(std::move(object));
  }
  return dump({{"type", "octant_history"}, {"version", 1}, {"visits", list}}) + "\n";
}

int write_export(const HistoryArgs& args, Session& session) {
  const bool as_json = args.output.ends_with(".json");
  if (!as_json && !args.output.ends_with(".csv") && args.output != "-")
    fail_usage(
        fmt::format("-o {}: expected a name in .csv or .json, or - for CSV on standard output", args.output));
  check_outputs({args.database, args.database + "-wal", args.database + "-shm"}, {{"-o", args.output}},
                session);
  io::History history = need(io::History::open(args.database, false));
  std::vector<io::Visit> visits;
  for (const io::Visit& v : chosen_visits(history, args)) visits.push_back(need(history.get(v.id)));
  need(io::write_file(args.output, as_json ? export_json(visits) : export_csv(visits)));
  session.result(fmt::format("{:<17}{} visits, {}\n", "exported", visits.size(),
                             args.output == "-" ? "standard output" : args.output));
  return session.finish({{"database", args.database}, {"visits", visits.size()}, {"written", args.output}});
}

using HistoryCommand = int (*)(const HistoryArgs&, Session&);

}  // namespace

Json visit_json(const io::Visit& v) {
  // Assigned key by key, because nested initialiser lists copy their elements, which is slow for ten thousand
  // visits.
  Json object;
  object["id"] = v.id;
  object["kind"] = to_string(v.kind);
  object["site"] = v.site;
  object["date"] = utc_text(v.happened_s);
  object["added"] = utc_text(v.added_s);
  object["verdict"] = v.verdict;
  object["operator"] = v.who;
  object["note"] = v.note;
  object["digest"] = v.digest;
  object["deployment_digest"] = v.deployment_digest;
  object["temperature_degC"] = nullptr;
  if (v.temperature_degC) object["temperature_degC"] = *v.temperature_degC;
  object["speed_mps"] = v.speed ? Json(v.speed->speed_mps) : Json();
  object["speed_sigma_mps"] = v.speed ? Json(v.speed->sigma_mps) : Json();
  object["speed_offset_mps"] = v.speed ? Json(v.speed->offset_mps) : Json();
  object["reference_temperature_degC"] = v.speed ? Json(v.speed->temperature_degC) : Json();
  object["source"] = v.source;
  object["program_version"] = v.program;
  return object;
}

Json visit_beacons_json(const io::Visit& visit) {
  Json list = Json::array();
  for (const io::VisitBeacon& b : visit.beacons)
    list.push_back({{"id", b.name},
                    {"position_m", b.position_m},
                    {"sigma_m", b.sigma_m},
                    {"delay_s", b.delay_s},
                    {"delay_sigma_s", b.delay_sigma_s},
                    {"status", to_string(b.status)}});
  return list;
}

std::string chosen_site(io::History& history, const HistoryArgs& args) {
  std::set<std::string> sites;
  for (const io::Visit& v : need(history.list())) sites.insert(v.site);
  if (args.site.empty() && sites.size() == 1) return *sites.begin();
  if (sites.contains(args.site)) return args.site;
  const std::string known = joined(sites, ", ", [](const auto& site) { return site.empty() ? "''" : site; });
  fail_with({.code = args.site.empty() ? Errc::kUsage : Errc::kBadInput,
             .file = args.database,
             .found = args.site.empty() ? fmt::format("{} sites: {}", sites.size(), known)
                                        : fmt::format("no site '{}', but {}", args.site, known),
             .expected = "one of them by --site"});
}

void add_history(CLI::App& app, CommonOptions& common, Action& action) {
  auto args = std::make_shared<HistoryArgs>();
  CLI::App* history = add_command(
      app, common, "history", "The site's calibrations, verifications and monitorings over time, in one file",
      "octant history add hall/deployment.json --operator Ada\n  octant history list\n  octant history trend "
      "B3");
  history->require_subcommand(1);
  const auto command = [&](const char* name, const char* purpose, const char* example, HistoryCommand run) {
    CLI::App* sub = add_command(*history, common, name, purpose, example);
    add_option(*sub, "--db", args->database, "FILE", "The history's file");
    set_action(*sub, args, action, run);
    return sub;
  };
  const auto choose = [&](CLI::App* sub, bool kind) {
    add_option(*sub, "--site", args->site, "SITE", "Of this site alone");
    if (kind)
      add_option(*sub, "--kind", args->kind, "KIND",
                 "Of this kind alone: calibration, monitoring or verification")
          ->check(CLI::IsMember({"calibration", "monitoring", "verification"}));
  };
  CLI::App* sub = command(
      "add", "Put down deployments and results",
      "octant history add hall/deployment.json verified.json --operator Ada --note 'new bracket on B3'", add);
  add_required_option(*sub, "file", args->files, "DEPLOYMENT|RESULT.json",
                      "Deployments, and what verify --json or monitor --json printed");
  add_option(*sub, "--operator", args->who, "NAME", "Who did it")->envname("USER");
  add_option(*sub, "--note", args->note, "TEXT", "A remark");
  choose(command("list", "List the visits by date", "octant history list --kind calibration", list), true);
  sub =
      command("show", "One visit with its beacons; with --json its document", "octant history show 3", show);
  add_required_option(*sub, "id", args->id, "ID", "As list shows it")->check(CLI::PositiveNumber);
  sub = command("trend", "Control charts, alarms, drifts, and when the next recalibration is due",
                "octant history trend B3", history_trend);
  add_option(*sub, "beacon", args->beacon, "BEACON", "This beacon's charts, visit by visit");
  add_option(*sub, "--limit", args->limit_m, "METRES",
             "How far off a drift may put a range; else the site's tolerance.beacon_m, else 0.05")
      ->check(CLI::PositiveNumber);
  choose(sub, false);
  sub = command("export", "All visits as CSV or JSON", "octant history export -o history.csv", write_export);
  add_required_option(*sub, "-o,--output", args->output, "FILE.csv|json",
                      "File to write; .json has the documents too; - is CSV on standard output");
  choose(sub, true);
}

}  // namespace octant::app

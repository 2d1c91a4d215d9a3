// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/history.h"

#include <map>

#include <fmt/format.h>

#include "io/history/sql.h"

namespace octant::io {
namespace {

constexpr VisitKind kVisitKinds[] = {VisitKind::kCalibration, VisitKind::kMonitoring,
                                     VisitKind::kVerification};

VisitKind visit_kind_of(const std::string& word) {
  for (const VisitKind kind : kVisitKinds)
    if (word == to_string(kind)) return kind;
  return VisitKind::kCalibration;  // the table holds no other words
}

BeaconStatus beacon_status_of(const std::string& word) {
  for (const BeaconStatus status : {BeaconStatus::kControlPoint, BeaconStatus::kUndetermined})
    if (word == to_string(status)) return status;
  return BeaconStatus::kCalibrated;
}

constexpr const char* kVisitColumns =
    "kind, site, happened_s, added_s, digest, deployment_digest, coldest_degC, warmest_degC, speed_mps, "
    "speed_sigma_mps, speed_offset_mps, speed_temperature_degC, verdict, who, note, source, program";

Visit visit_in(const SqlStatement& row) {
  Visit v;
  v.kind = visit_kind_of(row.text(0));
  v.site = row.text(1);
  v.happened_s = row.integer(2);
  v.added_s = row.integer(3);
  v.digest = row.text(4);
  v.deployment_digest = row.text(5);
  if (const auto coldest = row.real_or_none(6), warmest = row.real_or_none(7); coldest && warmest)
    v.temperature_degC = {*coldest, *warmest};
  if (!row.is_null(8)) v.speed = VisitSpeed{row.real(8), row.real(9), row.real(10), row.real(11)};
  v.verdict = row.text(12);
  v.who = row.text(13);
  v.note = row.text(14);
  v.source = row.text(15);
  v.program = row.text(16);
  v.id = row.integer(17);
  return v;
}

VisitBeacon beacon_in(const SqlStatement& row) {
  VisitBeacon b;
  b.name = row.text(0);
  for (int i = 0; i < 3; ++i) {
    b.position_m[i] = row.real(1 + i);
    b.sigma_m[i] = row.real(4 + i);
  }
  b.delay_s = row.real(7);
  b.delay_sigma_s = row.real(8);
  b.status = beacon_status_of(row.text(9));
  return b;
}

constexpr const char* kBeaconColumns =
    "name, x_m, y_m, z_m, sigma_x_m, sigma_y_m, sigma_z_m, delay_s, delay_sigma_s, status";

Result<void> put(SqlStatement& statement) {
  const auto row = statement.next();
  statement.reset();
  if (!row) return fail(row.error());
  return {};
}

/// The statements of an addition, prepared once for all of it.
class VisitWriter {
 public:
  [[nodiscard]] static Result<VisitWriter> prepare(SqlStore& store) {
    VisitWriter writer;
    const std::pair<std::unique_ptr<SqlStatement>*, std::string> all[] = {
        {&writer.find_, "SELECT id FROM visit WHERE digest = ?1"},
        {&writer.document_, "INSERT INTO document (digest, content) VALUES (?1, ?2)"},
        {&writer.visit_,
         fmt::format("INSERT INTO visit ({}) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
                     "?11, ?12, ?13, ?14, ?15, ?16, ?17) RETURNING id",
                     kVisitColumns)},
        {&writer.beacon_, "INSERT INTO beacon VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)"}};
    for (const auto& [statement, sql] : all) {
      auto prepared = store.prepare(sql);
      if (!prepared) return fail(prepared.error());
      *statement = std::move(*prepared);
    }
    return writer;
  }

  [[nodiscard]] Result<Addition> add(const Visit& v) {
    const auto there = find_->bind(1, v.digest).next();
    const std::int64_t old = there && *there ? find_->integer(0) : 0;
    find_->reset();
    if (!there) return fail(there.error());
    if (old > 0) return Addition{old, false};
    document_->bind_all(v.digest, v.document);
    if (auto done = put(*document_); !done) return fail(done.error());
    const auto id = put_visit(v);
    if (!id) return fail(id.error());
    for (std::size_t i = 0; i < v.beacons.size(); ++i)
      if (auto done = put_beacon(*id, i, v.beacons[i]); !done) return fail(done.error());
    return Addition{*id, true};
  }

 private:
  /// @return  the number of the visit in the history
  [[nodiscard]] Result<std::int64_t> put_visit(const Visit& v) {
    const auto of_speed = [&v](double VisitSpeed::*member) {
      return v.speed ? std::optional<double>((*v.speed).*member) : std::nullopt;
    };
    const auto temperature = [&v](std::size_t end) {
      return v.temperature_degC ? std::optional<double>((*v.temperature_degC)[end]) : std::nullopt;
    };
    visit_->bind_all(to_string(v.kind), v.site, v.happened_s, v.added_s, v.digest, v.deployment_digest,
                     temperature(0), temperature(1), of_speed(&VisitSpeed::speed_mps),
                     of_speed(&VisitSpeed::sigma_mps), of_speed(&VisitSpeed::offset_mps),
                     of_speed(&VisitSpeed::temperature_degC), v.verdict, v.who, v.note, v.source, v.program);
    const auto row = visit_->next();
    const std::int64_t id = row && *row ? visit_->integer(0) : 0;
    visit_->reset();
    if (!row) return fail(row.error());
    return id;
  }

  [[nodiscard]] Result<void> put_beacon(std::int64_t visit, std::size_t place, const VisitBeacon& b) {
    beacon_->bind_all(visit, static_cast<std::int64_t>(place), b.name);
    for (int i = 0; i < 3; ++i) beacon_->bind(4 + i, b.position_m[i]).bind(7 + i, b.sigma_m[i]);
    beacon_->bind(10, b.delay_s).bind(11, b.delay_sigma_s).bind(12, to_string(b.status));
    return put(*beacon_);
  }

  std::unique_ptr<SqlStatement> find_, document_, visit_, beacon_;
};

}  // namespace

const char* to_string(VisitKind kind) {
  switch (kind) {
    case VisitKind::kCalibration: return "calibration";
    case VisitKind::kMonitoring: return "monitoring";
    case VisitKind::kVerification: return "verification";
  }
  return "calibration";
}

struct History::Content {
  std::unique_ptr<SqlStore> store;
  [[nodiscard]] Result<std::vector<Addition>> add(const std::vector<Visit>& visits);
};

History::History(std::unique_ptr<Content> content) : content_(std::move(content)) {}
History::History(History&&) noexcept = default;
History& History::operator=(History&&) noexcept = default;
History::~History() = default;

Result<History> History::open(const std::string& path, bool create) {
  auto store = SqlStore::open(path, create);
  if (!store) return fail(store.error());
  if (auto ready = migrate(**store); !ready) {
    (*store)->give_up();
    return fail(ready.error());
  }
  return History(std::make_unique<Content>(Content{std::move(*store)}));
}

Result<std::vector<Addition>> History::add(const std::vector<Visit>& visits) {
  auto additions = content_->add(visits);
  SqlStore& store = *content_->store;
  if (!additions) {
    store.give_up();
  } else if (auto kept = store.keep(); !kept) {
    return fail(kept.error());
  }
  return additions;
}

Result<std::vector<Addition>> History::Content::add(const std::vector<Visit>& visits) {
  std::vector<Addition> additions;
  auto transaction = SqlTransaction::begin(*store);
  if (!transaction) return fail(transaction.error());
  {
    auto writer = VisitWriter::prepare(*store);
    if (!writer) return fail(writer.error());
    for (const Visit& visit : visits) {
      const auto added = writer->add(visit);
      if (!added) return fail(added.error());
      additions.push_back(*added);
    }
  }
  if (auto done = transaction->commit(); !done) return fail(done.error());
  return additions;
}

Result<std::vector<Visit>> History::list(const VisitFilter& filter) {
  auto rows =
      content_->store->prepare(fmt::format("SELECT {}, id FROM visit WHERE (?1 = '' OR site = ?1) AND (?2 = "
                                           "'' OR kind = ?2) ORDER BY happened_s, id",
                                           kVisitColumns));
  if (!rows) return fail(rows.error());
  (*rows)->bind_all(filter.site, filter.kind ? to_string(*filter.kind) : "");
  std::vector<Visit> visits;
  const auto all = (*rows)->for_each([&] { visits.push_back(visit_in(**rows)); });
  if (!all) return fail(all.error());
  return visits;
}

Result<std::vector<Visit>> History::calibrations(const std::string& site) {
  auto visits = list({.site = site, .kind = VisitKind::kCalibration});
  if (!visits) return visits;
  std::map<std::int64_t, Visit*> by_id;
  for (Visit& v : *visits) by_id[v.id] = &v;
  auto rows = content_->store->prepare(
      fmt::format("SELECT {}, visit_id FROM beacon ORDER BY visit_id, place", kBeaconColumns));
  if (!rows) return fail(rows.error());
  const auto all = (*rows)->for_each([&] {
    if (const auto visit = by_id.find((*rows)->integer(10)); visit != by_id.end())
      visit->second->beacons.push_back(beacon_in(**rows));
  });
  if (!all) return fail(all.error());
  return visits;
}

Result<Visit> History::get(std::int64_t id) {
  auto head = content_->store->prepare(fmt::format("SELECT {}, id FROM visit WHERE id = ?1", kVisitColumns));
  if (!head) return fail(head.error());
  const auto there = (*head)->bind(1, id).next();
  if (!there) return fail(there.error());
  if (!*there)
    return fail({.file = content_->store->name(),
                 .found = fmt::format("no visit {}", id),
                 .expected = "a number that octant history list shows"});
  Visit visit = visit_in(**head);
  auto document = content_->store->prepare("SELECT content FROM document WHERE digest = ?1");
  if (!document) return fail(document.error());
  const auto found = (*document)->bind(1, visit.digest).next();
  if (!found) return fail(found.error());
  if (*found) visit.document = (*document)->text(0);
  auto beacons = content_->store->prepare(
      fmt::format("SELECT {} FROM beacon WHERE visit_id = ?1 ORDER BY place", kBeaconColumns));
  if (!beacons) return fail(beacons.error());
  const auto all = (*beacons)->bind(1, id).for_each([&] { visit.beacons.push_back(beacon_in(**beacons)); });
  if (!all) return fail(all.error());
  return visit;
}

}  // namespace octant::io

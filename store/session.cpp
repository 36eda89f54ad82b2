#include "store/session.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "store/clock.hpp"
#include "store/job_key.hpp"
#include "store/provenance.hpp"
#include "store/seal.hpp"
#include "store/stored_json.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

constexpr const char* kSessionRows =
    "SELECT session_id, campaign_id, name, compensation_job_id, compensation_name, plan_name, "
    "stage, tracker, settings_json, created_utc, n_points, n_asked, "
    "(SELECT count(*) FROM attempt JOIN point USING (point_id) "
    "  WHERE point.session_id = session.session_id AND status = 'ok'), "
    "(SELECT count(*) FROM reading WHERE reading.session_id = session.session_id), "
    "coalesce((SELECT kind FROM session_event WHERE session_event.session_id = session.session_id "
    "  AND kind IN ('started', 'paused', 'resumed', 'stopped', 'faulted', 'done') "
    "  ORDER BY event_id DESC LIMIT 1), '') "
    "FROM session ";

SessionRow session_at(const Statement& row) {
  return {.id = row.integer(0),
          .campaign_id = row.integer(1),
          .name = row.text(2),
          .compensation_job = row.optional_integer(3),
          .compensation_name = row.text(4),
          .plan_name = row.text(5),
          .stage = row.text(6),
          .tracker = row.text(7),
          .settings_json = stored_json(row, 8),
          .created_utc = row.text(9),
          .n_points = static_cast<int>(row.integer(10)),
          .n_asked = static_cast<int>(row.integer(11)),
          .n_ok = static_cast<int>(row.integer(12)),
          .n_readings = static_cast<int>(row.integer(13)),
          .last_event = row.text(14)};
}

void add_point(Connection& connection, Id session_id, int n_drives, const Point& p) {
  const auto there = [&](int i, auto value) {
    return i < n_drives ? std::optional(value) : std::nullopt;
  };
  Statement insert(
      connection,
      "INSERT INTO point (session_id, seq, reading_set, target_x_mm, target_y_mm, "
      "target_phi_rad, approach_1, approach_2, approach_3, repeat, is_reference, role, "
      "planned_l1_mm, planned_l2_mm, planned_l3_mm) "
      "VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  insert << session_id << p.seq << name_of(p.set) << p.target.x_mm << there(1, p.target.y_mm)
         << there(2, p.target.phi_rad) << p.approach[0] << there(1, p.approach[1])
         << there(2, p.approach[2]) << p.repeat << p.reference << p.role << p.planned_mm[0]
         << there(1, p.planned_mm[1]) << there(2, p.planned_mm[2]);
  insert.run();
}

std::vector<Point> points_where(Connection& connection, Id session_id, std::string_view condition) {
  std::vector<Point> all;
  Statement rows(connection,
                 "SELECT seq, reading_set, target_x_mm, target_y_mm, target_phi_rad, approach_1, "
                 "approach_2, approach_3, repeat, is_reference, role, planned_l1_mm, "
                 "planned_l2_mm, planned_l3_mm FROM point WHERE session_id = ? " +
                     std::string(condition) + " ORDER BY seq");
  rows << session_id;
  const auto integer = [&](int column) { return static_cast<int>(rows.integer(column)); };
  while (rows.step()) {
    all.push_back({.seq = integer(0),
                   .set = reading_set(rows.text(1)),
                   .target = {rows.real(2), rows.real(3), rows.real(4)},
                   .approach = {integer(5), integer(6), integer(7)},
                   .repeat = integer(8),
                   .reference = integer(9) != 0,
                   .role = rows.text(10),
                   .planned_mm = {rows.real(11), rows.real(12), rows.real(13)}});
  }
  return all;
}

void close_attempt(Connection& connection, Id attempt_id, const char* status,
                   std::size_t n_readings, std::string_view detail) {
  Statement update(connection,
                   "UPDATE attempt SET status = ?, n_readings = ?, detail = ?, closed_utc = ? "
                   "WHERE attempt_id = ?");
  update << status << static_cast<int>(n_readings) << detail.substr(0, 10'000) << utc_now()
         << attempt_id;
  update.run();
  seal(connection, "attempt", attempt_id);
}

Id session_of(Connection& connection, Id attempt_id) {
  Statement row(connection,
                "SELECT session_id FROM attempt JOIN epoch USING (epoch_id) WHERE attempt_id = ?");
  row << attempt_id;
  if (!row.step()) throw NotFoundError({.what = "no such attempt"});
  return row.integer(0);
}

}  // namespace

Id create_session(Connection& connection, const NewSession& s) {
  Transaction transaction(connection);
  if (const auto taken = find_session(connection, s.campaign_id, s.name)) {
    const bool finished = taken->n_ok >= taken->n_points;
    throw InputError(
        {.what = finished ? "the campaign has a finished session of this name"
                          : "the campaign has a session of this name already",
         .where = {.field = "session"},
         .got = s.name,
         .hint = finished ? "choose another name" : "resume it, or choose another name"});
  }
  Statement insert(connection,
                   "INSERT INTO session (campaign_id, name, compensation_job_id, "
                   "compensation_name, plan_name, n_points, n_imported, n_asked, stage, tracker, "
                   "settings_json, tool_version, created_utc) VALUES (?1, ?2, ?3, "
                   "coalesce(nullif(?4, ''), (SELECT stage FROM job WHERE job_id = ?3), ''), "
                   "?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)");
  insert << s.campaign_id << s.name << s.compensation_job << s.compensation_name << s.plan_name
         << static_cast<int>(s.points.size()) << s.n_imported << s.n_asked << s.stage << s.tracker
         << canonical_json(s.settings_json, "settings") << this_program().tool_version << utc_now();
  const Id id = insert.run();
  const int n_drives = s.points.empty() ? 0 : shape_of(connection, s.campaign_id).drives;
  for (const Point& point : s.points) add_point(connection, id, n_drives, point);
  seal(connection, "session", id);
  transaction.commit();
  return id;
}

std::vector<SessionRow> list_sessions(Connection& connection, Id campaign_id) {
  std::vector<SessionRow> all;
  Statement rows(connection,
                 std::string(kSessionRows) + "WHERE campaign_id = ? ORDER BY session_id");
  rows << campaign_id;
  while (rows.step()) all.push_back(session_at(rows));
  return all;
}

std::vector<SessionName> session_names(Connection& connection, Id campaign_id) {
  std::vector<SessionName> all;
  Statement rows(connection,
                 "SELECT session_id, name, compensation_name, plan_name FROM session "
                 "WHERE campaign_id = ?");
  rows << campaign_id;
  while (rows.step()) {
    all.push_back(
        {rows.integer(0), rows.text(1), !rows.text(2).empty(), rows.text(3) == kReferencePlan});
  }
  std::ranges::sort(all, {}, &SessionName::id);  // SQLite would make a sorter of its own
  return all;
}

std::optional<SessionRow> find_session(Connection& connection, Id campaign_id,
                                       std::string_view name) {
  Statement rows(connection, std::string(kSessionRows) + "WHERE campaign_id = ? AND name = ?");
  rows << campaign_id << name;
  return rows.step() ? std::optional(session_at(rows)) : std::nullopt;
}

SessionRow get_session(Connection& connection, Id session_id) {
  Statement rows(connection, std::string(kSessionRows) + "WHERE session_id = ?");
  rows << session_id;
  if (!rows.step()) throw NotFoundError({.what = "no such session"});
  return session_at(rows);
}

ImportedWalk imported_walk(const SessionRow& session) {
  ImportedWalk walk;
  const auto settings = nlohmann::json::parse(session.settings_json);
  const auto roles = settings.find("roles");
  if (session.n_points > 0 || roles == settings.end() || !roles->is_object()) return walk;
  for (const auto& [seq, role] : roles->items()) {
    int number = 0;
    const auto end = std::from_chars(seq.data(), seq.data() + seq.size(), number);
    if (end.ec == std::errc{} && role.is_string()) walk.roles[number] = role.get<std::string>();
  }
  return walk;
}

std::string with_roles(const std::string& settings_json, const std::map<int, std::string>& roles) {
  if (roles.empty()) return settings_json;
  auto settings = nlohmann::json::parse(settings_json);
  for (const auto& [seq, role] : roles) settings["roles"][std::to_string(seq)] = role;
  return settings.dump();
}

std::vector<Point> points(Connection& connection, Id session_id) {
  return points_where(connection, session_id, "");
}

std::vector<Point> open_points(Connection& connection, Id session_id) {
  return points_where(connection, session_id,
                      "AND NOT EXISTS (SELECT 1 FROM attempt WHERE attempt.point_id = "
                      "point.point_id AND status = 'ok')");
}

Id add_epoch(Connection& connection, Id session_id, int number, std::string_view reason) {
  Transaction transaction(connection);
  Statement insert(connection,
                   "INSERT INTO epoch (session_id, number, reason, opened_utc) VALUES (?,?,?,?)");
  insert << session_id << number << reason << utc_now();
  const Id id = insert.run();
  seal(connection, "epoch", id);
  transaction.commit();
  return id;
}

Epoch open_epoch(Connection& connection, Id session_id, SetUp set_up, std::string_view reason) {
  Transaction transaction(connection);
  Statement last(connection,
                 "SELECT coalesce(max(number), 0) FROM epoch JOIN session USING (session_id) WHERE "
                 "campaign_id = (SELECT campaign_id FROM session WHERE session_id = ?)");
  last << session_id;
  static_cast<void>(last.step());
  const auto before = static_cast<int>(last.integer(0));
  const int number = set_up == SetUp::as_before && before > 0 ? before : before + 1;
  const Id id = add_epoch(connection, session_id, number, reason);
  transaction.commit();
  return {id, number};
}

std::vector<Epoch> epochs(Connection& connection, Id session_id) {
  std::vector<Epoch> all;
  Statement rows(
      connection,
      "SELECT epoch_id, number, reason FROM epoch WHERE session_id = ? ORDER BY epoch_id");
  rows << session_id;
  while (rows.step())
    all.push_back(
        {rows.integer(0), static_cast<int>(rows.integer(1)), rows.text(2) == kReferencesHold});
  return all;
}

std::vector<std::pair<int, int>> held_epochs(Connection& connection, Id campaign_id) {
  std::vector<std::pair<int, int>> all;
  Statement rows(connection,
                 "SELECT before.number, epoch.number FROM epoch JOIN session USING (session_id) "
                 "JOIN epoch AS before ON before.session_id = epoch.session_id "
                 "AND before.number < epoch.number "
                 "WHERE campaign_id = ? AND epoch.reason = ? ORDER BY 1, 2");
  rows << campaign_id << kReferencesHold;
  while (rows.step()) {
    all.emplace_back(static_cast<int>(rows.integer(0)), static_cast<int>(rows.integer(1)));
  }
  return all;
}

Id begin_attempt(Connection& connection, Id session_id, int point_seq, Id epoch_id) {
  Statement insert(connection,
                   "INSERT INTO attempt (point_id, number, epoch_id, status, n_readings, detail, "
                   "opened_utc) SELECT point_id, 1 + (SELECT count(*) FROM attempt WHERE "
                   "attempt.point_id = point.point_id), ?, 'open', 0, '', ? FROM point WHERE "
                   "session_id = ? AND seq = ? RETURNING attempt_id");
  insert << epoch_id << utc_now() << session_id << point_seq;
  if (!insert.step()) {
    throw NotFoundError({.what = "the session's plan has no such point",
                         .where = {.point = "seq " + std::to_string(point_seq)}});
  }
  const Id id = insert.integer(0);
  while (insert.step()) {
  }
  return id;
}

std::vector<int> finish_attempt(Connection& connection, Id attempt_id,
                                const std::vector<NewReading>& readings, std::string_view walk) {
  if (readings.empty()) throw InputError({.what = "an attempt without a reading is not ok"});
  Transaction transaction(connection);
  Statement of(connection,
               "SELECT campaign_id, session.session_id, epoch.number FROM attempt JOIN epoch USING "
               "(epoch_id) JOIN session USING (session_id) WHERE attempt_id = ?");
  of << attempt_id;
  if (!of.step()) throw NotFoundError({.what = "no such attempt"});
  ReadingWriter writer(connection, of.integer(0));
  std::vector<int> seqs;
  for (NewReading reading : readings) {
    reading.reading.conditions.epoch = static_cast<int>(of.integer(2));
    seqs.push_back(writer.add(reading, of.integer(1), attempt_id));
  }
  const Id session_id = of.integer(1);
  of.reset();
  close_attempt(connection, attempt_id, "ok", readings.size(), "");
  if (!walk.empty()) add_event(connection, session_id, "walk", walk);
  transaction.commit();
  return seqs;
}

void fail_attempt(Connection& connection, Id attempt_id, std::string_view detail,
                  std::string_view walk) {
  Transaction transaction(connection);
  close_attempt(connection, attempt_id, "failed", 0, detail);
  if (!walk.empty()) add_event(connection, session_of(connection, attempt_id), "walk", walk);
  transaction.commit();
}

int interrupt_open_attempts(Connection& connection, Id session_id, std::string_view detail) {
  Transaction transaction(connection);
  int n = 0;
  for (const Attempt& attempt : attempts(connection, session_id)) {
    if (attempt.status != "open") continue;
    close_attempt(connection, attempt.id, "interrupted", 0, detail);
    ++n;
  }
  transaction.commit();
  return n;
}

std::vector<Attempt> attempts(Connection& connection, Id session_id) {
  std::vector<Attempt> all;
  Statement rows(connection,
                 "SELECT attempt_id, point.seq, attempt.number, epoch.number, status, n_readings, "
                 "detail, attempt.opened_utc, coalesce(closed_utc, '') FROM attempt JOIN point "
                 "USING (point_id) JOIN epoch "
                 "USING (epoch_id) WHERE point.session_id = ? ORDER BY attempt_id");
  rows << session_id;
  const auto integer = [&](int column) { return static_cast<int>(rows.integer(column)); };
  while (rows.step()) {
    all.push_back({rows.integer(0), integer(1), integer(2), integer(3), rows.text(4), integer(5),
                   rows.text(6), rows.text(7), rows.text(8)});
  }
  return all;
}

Id add_event(Connection& connection, Id session_id, std::string_view kind,
             std::string_view detail) {
  Transaction transaction(connection);
  Statement insert(connection,
                   "INSERT INTO session_event (session_id, number, kind, detail, at_utc) SELECT "
                   "?1, 1 + coalesce(max(number), 0), ?2, ?3, ?4 FROM session_event WHERE "
                   "session_id = ?1");
  insert << session_id << kind << detail.substr(0, 10'000) << utc_now();
  const Id id = insert.run();
  seal(connection, "session_event", id);
  transaction.commit();
  return id;
}

void hold_clock(Connection& connection, Id session_id) {
  Statement times(connection,
                  "SELECT created_utc FROM session WHERE session_id = ?1 "
                  "UNION ALL SELECT at_utc FROM session_event WHERE session_id = ?1 "
                  "UNION ALL SELECT opened_utc FROM epoch WHERE session_id = ?1 "
                  "UNION ALL SELECT coalesce(closed_utc, attempt.opened_utc) FROM attempt "
                  "JOIN point USING (point_id) WHERE session_id = ?1");
  times << session_id;
  while (times.step()) not_before(times.text(0));
}

std::vector<Event> events(Connection& connection, Id session_id, Id after) {
  std::vector<Event> all;
  Statement rows(connection,
                 "SELECT event_id, kind, detail, at_utc FROM session_event WHERE session_id = ? "
                 "AND event_id > ? ORDER BY event_id");
  rows << session_id << after;
  while (rows.step()) {
    all.push_back({rows.integer(0), rows.text(1), rows.text(2), rows.text(3)});
  }
  return all;
}

}  // namespace trammel::store

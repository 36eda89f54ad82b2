#include "app/session/status.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/files/numbers.hpp"
#include "app/session/settings.hpp"
#include "app/terminal/text.hpp"
#include "core/units.hpp"
#include "store/clock.hpp"
#include "store/machine.hpp"
#include "store/session.hpp"

namespace trammel::session {

namespace {

constexpr double kLeastStallS = 60;
constexpr double kStallPoints = 5;  // of the usual time per point

/// Between two times as the store writes them; nothing where one is none. A stranger's row may hold
/// any text: what is no time is left out.
std::optional<double> seconds_between(const std::string& from_utc, const std::string& to_utc) {
  const auto from = store::utc_ms(from_utc), to = store::utc_ms(to_utc);
  if (!from || !to) return std::nullopt;
  return static_cast<double>(*to - *from) / 1000;
}

void take_time(std::string& last_utc, const std::string& utc) {
  if (store::utc_ms(utc)) last_utc = std::max(last_utc, utc);
}

std::string class_of(const std::string& detail) {
  for (const device::Status status :
       {device::Status::beam_broken, device::Status::timeout, device::Status::unstable,
        device::Status::limit, device::Status::following_error, device::Status::fault}) {
    if (detail.starts_with(device::name_of(status))) return device::name_of(status);
  }
  return "other";
}

/// The time a point takes: median of the last ones, by when they were closed.
std::optional<double> time_per_point(const std::vector<store::Attempt>& attempts) {
  std::vector<double> gaps;
  std::string before;
  for (const store::Attempt& a : attempts) {
    if (a.status != "ok") continue;
    if (const auto gap = seconds_between(before, a.closed_utc)) gaps.push_back(*gap);
    before = a.closed_utc;
  }
  if (gaps.empty()) return std::nullopt;
  if (gaps.size() > SessionStatus::kLast)
    gaps.erase(gaps.begin(), gaps.end() - SessionStatus::kLast);
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

void take_attempts(const std::vector<store::Attempt>& attempts, SessionStatus& status) {
  for (const store::Attempt& a : attempts) {
    status.epoch = std::max(status.epoch, a.epoch);
    take_time(status.last_utc, a.opened_utc);
    take_time(status.last_utc, a.closed_utc);
    if (a.status == "failed") ++status.retries[class_of(a.detail)];
    if (a.status == "interrupted") ++status.n_interrupted;
  }
  status.seconds_per_point = time_per_point(attempts);
}

void take_events(const std::vector<store::Event>& events, const store::SessionRow& row,
                 SessionStatus& status) {
  for (const store::Event& event : events) {
    if (status.started_utc.empty()) take_time(status.started_utc, event.at_utc);
    take_time(status.last_utc, event.at_utc);
    if (event.kind == row.last_event) status.detail = event.detail;
    if (event.kind != kBaseEvent) continue;
    if (const auto check = read_base_check(event.detail)) {
      status.base.push_back({event.at_utc, *check});
    }
  }
}

Eigen::Vector3d off(const Pose& pose, const Pose& from, const Coordinates& measured) {
  Eigen::Vector3d d = pose.vector() - from.vector();
  for (int c = 0; c < 3; ++c) {
    if (!measured[static_cast<std::size_t>(c)]) d[c] = 0;
  }
  return d;
}

/// Attempts that are ok, to the point they measured.
std::map<store::Id, int> points_of(const std::vector<store::Attempt>& attempts) {
  std::map<store::Id, int> seq_of;
  for (const store::Attempt& a : attempts) {
    if (a.status == "ok") seq_of[a.id] = a.point_seq;
  }
  return seq_of;
}

using First = std::map<int, Pose>;  // of each point

First take_deviations(store::Connection& connection, store::Id campaign, store::Id session,
                      const std::vector<store::Attempt>& attempts, SessionStatus& status) {
  First first;
  const auto seq_of = points_of(attempts);
  for (const store::StoredReading& r : store::readings(connection, campaign, {session})) {
    const Reading& reading = r.data.reading;
    if (!r.attempt_id || !seq_of.contains(*r.attempt_id) || !reading.measured) continue;
    const int point = seq_of.at(*r.attempt_id);
    first.emplace(point, *reading.measured);
    status.last.push_back({point, off(*reading.measured, reading.target, status.measured)});
  }
  if (status.last.size() > SessionStatus::kLast) {
    status.last.erase(status.last.begin(), status.last.end() - SessionStatus::kLast);
  }
  return first;
}

void take_drift(store::Connection& connection, const store::SessionRow& visit, const First& first,
                SessionStatus& status) {
  constexpr std::string_view kRole = "reference to point ";
  std::map<int, int> to;  // seq of the visit's point -> of the session's
  for (const store::Point& p : store::points(connection, visit.id)) {
    if (!p.role.starts_with(kRole)) continue;
    if (const auto seq = parse_integer(std::string_view(p.role).substr(kRole.size())))
      to[p.seq] = *seq;
  }
  const auto attempts = store::attempts(connection, visit.id);
  std::map<store::Id, const store::Attempt*> by_id;
  for (const store::Attempt& a : attempts) by_id[a.id] = &a;
  for (const store::StoredReading& r : store::readings(connection, visit.campaign_id, {visit.id})) {
    if (!r.attempt_id || !r.data.reading.measured) continue;
    const auto attempt = by_id.find(*r.attempt_id);
    if (attempt == by_id.end()) continue;
    const store::Attempt& a = *attempt->second;
    take_time(status.last_utc, a.closed_utc);
    if (!to.contains(a.point_seq) || !first.contains(to[a.point_seq])) continue;
    const int point = to[a.point_seq];
    status.drift.push_back({point, a.epoch, a.closed_utc,
                            off(*r.data.reading.measured, first.at(point), status.measured)});
  }
}

nlohmann::ordered_json with_off(nlohmann::ordered_json row, const Eigen::Vector3d& off,
                                const Coordinates& measured) {
  if (measured[0]) row["x_mm"] = off[0];
  if (measured[1]) row["y_mm"] = off[1];
  if (measured[2]) row["phi_deg"] = deg_from_rad(off[2]);
  row["position_mm"] = off.head<2>().norm();
  return row;
}

std::string state_of(const store::SessionRow& row, bool running) {
  if (row.last_event == "done" || row.last_event == "stopped" || row.last_event == "faulted") {
    return row.last_event;
  }
  if (!running) return "interrupted";
  return row.last_event == "paused" ? "paused" : "running";
}

void judge_time(SessionStatus& status) {
  const auto silent_s = seconds_between(status.last_utc, status.now_utc);
  if (!silent_s) return;
  status.silent_s = std::max(0.0, *silent_s);
  const double usual_s = status.seconds_per_point.value_or(0);
  status.stall_after_s = std::max(kLeastStallS, kStallPoints * usual_s);
  status.stalled = status.state == "running" && status.silent_s > status.stall_after_s;
  const bool goes_on = status.state == "running" || status.state == "paused";
  if (goes_on && status.seconds_per_point) {
    status.left_s = usual_s * (status.n_points - status.n_ok);
  }
}

}  // namespace

SessionStatus status_of(store::Connection& connection, const store::CampaignRow& campaign,
                        const std::string& session, std::optional<int> process,
                        const std::string& now_utc) {
  const auto row = store::find_session(connection, campaign.id, session);
  if (!row) {
    throw NotFoundError(
        {.what = "the campaign has no such session",
         .where = {.field = "session"},
         .got = session,
         .hint = "see `trammel session status " + terminal::shell_word(campaign.name) + "`"});
  }
  SessionStatus status;
  status.campaign = campaign.name;
  status.simulated = campaign.simulated;
  status.measured = store::load_machine(connection, campaign.id).measured;
  status.session = row->name;
  status.plan = row->plan_name;
  status.compensated = row->compensated();
  status.n_points = row->n_points;
  status.n_ok = row->n_ok;
  const bool current = process && current_session(connection, campaign) == session;
  if (current) status.process = process;
  status.state = state_of(*row, current);
  const bool says_why =
      status.state == "paused" || status.state == "stopped" || status.state == "faulted";
  status.now_utc = now_utc.empty() ? store::utc_now() : now_utc;
  const auto attempts = store::attempts(connection, row->id);
  take_attempts(attempts, status);
  take_events(store::events(connection, row->id), *row, status);
  if (!says_why) status.detail.clear();
  const First first = take_deviations(connection, campaign.id, row->id, attempts, status);
  for (const store::SessionRow& visit : store::list_sessions(connection, campaign.id)) {
    if (visit.plan_name != store::kReferencePlan) continue;
    if (visit.name.starts_with(session + ", reference ")) {
      take_drift(connection, visit, first, status);
    }
  }
  judge_time(status);
  return status;
}

std::optional<std::string> current_session(store::Connection& connection,
                                           const store::CampaignRow& campaign) {
  std::optional<std::string> last;
  store::Id last_event = -1;
  for (const store::SessionRow& row : store::list_sessions(connection, campaign.id)) {
    if (!has_settings(row.settings_json)) continue;
    const auto events = store::events(connection, row.id);
    const store::Id id = events.empty() ? 0 : events.back().id;
    if (id < last_event) continue;
    last_event = id;
    last = row.name;
  }
  return last;
}

nlohmann::ordered_json status_json(const SessionStatus& s) {
  using Json = nlohmann::ordered_json;
  Json last = Json::array(), drift = Json::array(), base = Json::array();
  for (const SessionStatus::Base& b : s.base) {
    Json found = {{"at_utc", b.at_utc}};
    found.update(base_check_json(b.check));
    base.push_back(found);
  }
  for (const SessionStatus::Deviation& d : s.last) {
    last.push_back(with_off({{"point", d.point}}, d.off, s.measured));
  }
  for (const SessionStatus::Drift& d : s.drift) {
    drift.push_back(with_off({{"point", d.point}, {"epoch", d.epoch}, {"at_utc", d.at_utc}}, d.off,
                             s.measured));
  }
  Json json = {{"campaign", s.campaign},
               {"simulated", s.simulated},
               {"session", s.session},
               {"plan", s.plan},
               {"state", s.state},
               {"detail", s.detail},
               {"compensated", s.compensated},
               {"n_points", s.n_points},
               {"n_ok", s.n_ok},
               {"epoch", s.epoch},
               {"now_utc", s.now_utc},
               {"started_utc", s.started_utc},
               {"last_utc", s.last_utc},
               {"silent_s", s.silent_s},
               {"stalled", s.stalled},
               {"stall_after_s", s.stall_after_s},
               {"retries", s.retries},
               {"n_interrupted", s.n_interrupted},
               {"last", last},
               {"drift", drift},
               {"base", base}};
  if (s.process) json["process"] = *s.process;
  if (s.seconds_per_point) json["seconds_per_point"] = *s.seconds_per_point;
  if (s.left_s) json["left_s"] = *s.left_s;
  return json;
}

}  // namespace trammel::session

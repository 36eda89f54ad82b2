#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/archive/commands.hpp"
#include "app/archive/install.hpp"
#include "app/files/numbers.hpp"
#include "app/terminal/progress.hpp"

namespace trammel::archive {

namespace {

constexpr const char* kTime = "'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'";

/// A list of the status: its name, its columns, and what is asked for them.
struct List {
  const char* key;
  std::vector<Column> columns;
  std::string sql;
};

const std::vector<List>& lists() {
  static const std::vector<List> all = {
      {"stations",
       {{"station"},
        {"role"},
        {"n_campaigns", true},
        {"n_readings", true},
        {"n_rows", true},
        {"last_push"}},
       fmt::format("SELECT s.uuid, s.role, count(h.campaign), coalesce(sum(h.n_readings), "
                   "0)::bigint, coalesce(sum(h.n_rows), 0)::bigint, to_char(max(h.moved_at) AT "
                   "TIME ZONE 'UTC', {}) FROM trammel.station AS s LEFT JOIN trammel.campaign_head "
                   "AS h ON h.station = s.uuid GROUP BY s.uuid, s.role ORDER BY 6 DESC NULLS LAST",
                   kTime)},
      // Of the last hour, and those that hold something. What is lost waits for another.
      {"workers",
       {{"worker"},
        {"machine"},
        {"n_claimed", true},
        {"n_lost", true},
        {"n_done", true},
        {"n_failed", true}},
       "SELECT worker, machine, count(*) FILTER (WHERE lease_until >= now()), count(*) FILTER "
       "(WHERE lease_until < now()), count(*) FILTER (WHERE state = 'done'), count(*) FILTER "
       "(WHERE state = 'failed') FROM trammel.work WHERE worker IS NOT NULL AND (state = 'claimed' "
       "OR finished_at > now() - interval '1 hour') GROUP BY worker, machine ORDER BY machine, "
       "worker"},
      {"failures",
       {{"campaign"}, {"stage"}, {"attempts", true}, {"machine"}, {"error"}, {"finished"}},
       fmt::format("SELECT c.name, w.stage, w.attempts, w.machine, w.error, to_char(w.finished_at "
                   "AT TIME ZONE 'UTC', {}) FROM trammel.work AS w LEFT JOIN trammel.campaign AS c "
                   "USING (campaign) WHERE w.state = 'failed' ORDER BY w.finished_at DESC LIMIT 50",
                   kTime)},
      {"alarms",
       {{"campaign"},
        {"job_key"},
        {"cpu_level"},
        {"machine"},
        {"station"},
        {"outcome"},
        {"other_machine"},
        {"other_station"},
        {"other_outcome"}},
       "SELECT campaign, job_key, cpu_level, machine, station, outcome, other_machine, "
       "other_station, other_outcome FROM trammel.v_alarm ORDER BY received_at DESC LIMIT 50"}};
  return all;
}

struct Queue {
  std::int64_t waiting = 0, claimed = 0, lost = 0, done = 0, failed = 0;
  std::optional<double> rate_per_s = {};
  [[nodiscard]] std::int64_t open() const { return waiting + claimed + lost; }
  /// Nothing where nobody computes.
  [[nodiscard]] std::optional<double> time_left_s() const {
    if (claimed == 0 || !rate_per_s) return std::nullopt;
    return static_cast<double>(open()) / *rate_per_s;
  }
};

/// The rate: what was finished in the last ten minutes, by the time of them in which something was
/// being computed.
Queue queue_of(Link& link) {
  const auto row =
      link.ask(
              "WITH span AS (SELECT finished_at, greatest(claimed_at, now() - interval '10 min') "
              "AS began, coalesce(finished_at, least(lease_until, now())) AS ended FROM "
              "trammel.work WHERE state = 'claimed' OR finished_at > now() - interval '10 min'), "
              "busy AS (SELECT range_agg(tstzrange(began, ended)) AS spans FROM span WHERE began < "
              "ended) SELECT count(*) FILTER (WHERE state = 'waiting'), count(*) FILTER (WHERE "
              "lease_until >= now()), count(*) FILTER (WHERE lease_until < now()), count(*) FILTER "
              "(WHERE state = 'done'), count(*) FILTER (WHERE state = 'failed'), (SELECT "
              "(nullif(count(finished_at), 0) / (SELECT sum(extract(epoch FROM upper(s) - "
              "lower(s))) FROM busy, unnest(spans) AS s))::float8 FROM span WHERE began < ended) "
              "FROM trammel.work")
          .at(0);
  return {.waiting = number_of(row, 0),
          .claimed = number_of(row, 1),
          .lost = number_of(row, 2),
          .done = number_of(row, 3),
          .failed = number_of(row, 4),
          .rate_per_s = row.at(5) ? parse_number(*row[5]) : std::nullopt};
}

std::string queue_text(const Queue& queue) {
  std::string text = fmt::format("{} waiting, {} being computed", queue.waiting, queue.claimed);
  if (queue.lost > 0) text += fmt::format(", {} lost by their workers", queue.lost);
  text += fmt::format(", {} done, {} failed", queue.done, queue.failed);
  if (queue.rate_per_s) {
    text += fmt::format("; {:.3g} a second while something was computed", *queue.rate_per_s);
  }
  if (const auto left = queue.time_left_s()) {
    text += *left < 1 ? ", less than a second left" : ", " + terminal::clock_text(*left) + " left";
  } else if (queue.open() > 0 && queue.claimed == 0) {
    text += "; nobody computes: `trammel archive work` does";
  }
  return text;
}

}  // namespace

ExitCode run_status(const cli::ArchiveOptions& options, cli::Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  const Queue queue = queue_of(link);
  cli::Json json = cli::Json::object();
  std::string text = "work: " + queue_text(queue);
  bool alarm = false;
  for (const List& list : lists()) {
    const auto rows = link.ask(list.sql);
    json[list.key] = rows_json(list.columns, rows);
    alarm = alarm || (std::string_view(list.key) == "alarms" && !rows.empty());
    if (rows.empty()) continue;
    text += (text.ends_with('\n') ? "\n" : "\n\n");
    text += fmt::format("{}\n{}", list.key, rows_text(list.columns, rows));
  }
  json["work"] = {
      {"waiting", queue.waiting},
      {"claimed", queue.claimed},
      {"lost", queue.lost},
      {"done", queue.done},
      {"failed", queue.failed},
      {"rate_per_s", queue.rate_per_s ? cli::Json(*queue.rate_per_s) : cli::Json()},
      {"time_left_s", queue.time_left_s() ? cli::Json(*queue.time_left_s()) : cli::Json()}};
  if (context.json) {
    context.print("archive-status", json);
  } else {
    context.print(text);
  }
  if (!alarm) return ExitCode::ok;
  context.say(
      "alarm: one calibration came out otherwise on two machines of one kind; one of them "
      "computes wrongly");
  return ExitCode::not_acceptable;
}

}  // namespace trammel::archive

#include "app/archive/commands.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/archive/install.hpp"
#include "app/archive/pull.hpp"
#include "app/archive/push.hpp"
#include "app/archive/station.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "store/campaign.hpp"
#include "store/clock.hpp"
#include "store/open.hpp"

namespace trammel::archive {

namespace {

using cli::Context;
using cli::Json;

using Options = cli::ArchiveOptions;

/// The archive that the line names, else TRAMMEL_ARCHIVE, else the one of the station's file.
std::string uri_of(const Options& options, const std::optional<Station>& station) {
  if (!options.uri.empty()) return options.uri;
  const char* environment = std::getenv("TRAMMEL_ARCHIVE");
  if (environment != nullptr && *environment != '\0') return environment;
  if (station) return station->uri;
  throw NotFoundError({.what = "no archive is named",
                       .expected = "--archive URI, TRAMMEL_ARCHIVE, or a station",
                       .hint = "trammel archive init URI makes this database a station"});
}

}  // namespace

Link link_to(const Options& options, const Context& context) {
  const auto station = read_station(context.db());
  return Link({.uri = uri_of(options, station),
               .insecure = options.insecure,
               .who = "trammel " + (station ? station->uuid : std::string("reader"))});
}

Station require_station(const Context& context) {
  if (auto station = read_station(context.db())) return *station;
  throw NotFoundError({.what = "this database is not a station of an archive",
                       .where = {.file = context.db()},
                       .hint = "trammel archive init URI makes it one"});
}

Json rows_json(const std::vector<Column>& columns, const std::vector<Link::Row>& rows) {
  Json list = Json::array();
  for (const Link::Row& row : rows) {
    Json object = Json::object();
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (!row.at(k)) {
        object[columns[k].key] = nullptr;
      } else if (columns[k].number) {
        object[columns[k].key] = number_of(row, k);
      } else {
        object[columns[k].key] = *row[k];
      }
    }
    list.push_back(std::move(object));
  }
  return list;
}

std::string rows_text(const std::vector<Column>& columns, const std::vector<Link::Row>& rows) {
  std::vector<std::string> header;
  for (const Column& column : columns) header.emplace_back(column.key);
  terminal::Table table(header);
  for (const Link::Row& row : rows) {
    std::vector<std::string> line;
    for (std::size_t k = 0; k < columns.size(); ++k) line.push_back(row.at(k).value_or(""));
    table.add(std::move(line));
  }
  return table.text();
}

namespace {

ExitCode run_init(const Options& options, Context& context) {
  Link link({.uri = options.uri, .insecure = options.insecure, .who = "trammel init"});
  const int version = archive_version(link);
  const bool changed = install(link);
  require_archive(link);
  const auto before = read_station(context.db());
  if (before && !options.station.empty() && before->uuid != options.station) {
    throw InputError({.what = "this database is another station already",
                      .where = {.file = station_file(context.db()).string()},
                      .got = before->uuid,
                      .expected = options.station});
  }
  const Station station{.uuid = before                    ? before->uuid
                                : options.station.empty() ? store::new_uuid()
                                                          : options.station,
                        .uri = options.uri};
  write_station(context.db(), station);
  if (context.json) {
    context.print(
        "archive-init",
        {{"made", changed && version == 0}, {"station", station.uuid}, {"database", context.db()}});
  } else {
    context.print(fmt::format("{}; {} is station {} of it",
                              !changed       ? "the archive was there already"
                              : version == 0 ? "made the archive and its roles"
                                             : "brought the archive up to date",
                              cli::printable(context.db()), station.uuid));
  }
  context.next("trammel archive push");
  return ExitCode::ok;
}

/// The database as this version stores it: what an older one holds gets its digests when it is
/// migrated.
store::Connection open_station(const Context& context) {
  store::Connection db = store::open_as_it_is(context.db());
  if (store::version_of(db) == store::newest_version()) return db;
  throw StoreError({.what = "this database was written by an older trammel",
                    .where = {.file = context.db()},
                    .got = "version " + std::to_string(store::version_of(db)),
                    .expected = "version " + std::to_string(store::newest_version()),
                    .hint = "run `trammel db migrate`"});
}

ExitCode run_push(const Options& options, Context& context) {
  const Station station = require_station(context);
  store::Connection db = open_station(context);
  std::vector<CampaignName> campaigns = campaigns_of(db);
  if (!options.campaigns.empty()) {
    std::vector<store::Id> wanted;
    for (const std::string& name : options.campaigns) {
      wanted.push_back(store::require_campaign_id(db, name));
    }
    std::erase_if(campaigns, [&wanted](const CampaignName& campaign) {
      return std::ranges::find(wanted, campaign.id) == wanted.end();
    });
  }
  Link link = link_to(options, context);
  require_archive(link);
  terminal::Progress progress(context.quiet || context.json, ::isatty(STDERR_FILENO) == 1, 0,
                              static_cast<int>(campaigns.size()));
  const auto pushed = push(link, db, station.uuid, campaigns, [&](int done, const Pushed& one) {
    progress.reached(done, ", " + cli::printable(one.campaign));
  });
  progress.end();
  Json rows = Json::array();
  std::int64_t n_rows = 0, n_readings = 0;
  for (const Pushed& one : pushed) {
    n_rows += one.n_rows;
    n_readings += one.n_readings;
    rows.push_back({{"campaign", one.campaign},
                    {"uuid", one.uuid},
                    {"head", one.head.head},
                    {"n_readings", one.head.n_readings},
                    {"n_rows", one.head.n_rows},
                    {"n_readings_sent", one.n_readings},
                    {"n_rows_sent", one.n_rows}});
  }
  if (context.json) {
    context.print("archive-push", {{"station", station.uuid}, {"campaigns", rows}});
  } else {
    context.print(fmt::format(
        "pushed {}: {} and {} were new", terminal::counted(pushed.size(), "campaign"),
        terminal::counted(n_readings, "reading"), terminal::counted(n_rows, "other row")));
  }
  return ExitCode::ok;
}

ExitCode run_pull(const Options& options, Context& context) {
  const std::string station =
      options.station.empty() ? require_station(context).uuid : options.station;
  Link link = link_to(options, context);
  require_archive(link);
  const store::CheckReport report = pull(
      link, {.station = station, .campaign = {}, .with_results = options.with_results}, options.to);
  if (context.json) {
    context.print("archive-pull", {{"station", station},
                                   {"database", options.to},
                                   {"n_readings", report.n_readings},
                                   {"n_sealed_rows", report.n_sealed}});
  } else {
    context.print(fmt::format("pulled {}: verified, {} readings and {} other rows",
                              cli::printable(options.to), report.n_readings, report.n_sealed));
  }
  return ExitCode::ok;
}

ExitCode run_list(const Options& options, Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  const std::vector<Column> columns = {
      {"name"},    {"kind"}, {"machine"}, {"n_readings", true}, {"n_rows", true}, {"moved_at"},
      {"station"}, {"uuid"}, {"head"}};
  const auto rows = link.ask(
      "SELECT c.name, c.kind, c.machine, h.n_readings, h.n_rows, "
      "to_char(h.moved_at AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'), "
      "h.station, h.campaign, encode(h.head, 'hex') FROM (SELECT * FROM "
      "trammel.campaign_head ORDER BY moved_at DESC LIMIT $1::int) AS h "
      "LEFT JOIN trammel.campaign AS c USING (campaign) ORDER BY h.moved_at DESC",
      {std::to_string(options.newest)});
  if (context.json) {
    context.print("archive-list", {{"campaigns", rows_json(columns, rows)}});
  } else {
    context.print(rows_text(columns, rows));
  }
  return ExitCode::ok;
}

ExitCode run_verify(const Options& options, Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  std::vector<std::string> findings;
  for (const Link::Row& row : link.ask("SELECT trammel.findings() LIMIT 100")) {
    findings.push_back(text_of(row, 0));
  }
  const Link::Row counts = link.ask(
                                   "SELECT coalesce(sum(n_readings), 0)::bigint, "
                                   "coalesce(sum(n_rows), 0)::bigint FROM trammel.campaign_head")
                               .at(0);
  if (context.json) {
    context.print("archive-verify", {{"ok", findings.empty()},
                                     {"n_readings", number_of(counts, 0)},
                                     {"n_rows", number_of(counts, 1)},
                                     {"findings", findings}});
  } else if (findings.empty()) {
    context.print(fmt::format("ok: {} readings and {} other rows are what was pushed",
                              text_of(counts, 0), text_of(counts, 1)));
  } else {
    for (const std::string& finding : findings) context.print(cli::printable(finding));
  }
  return findings.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace

void setup(cli::Command app, Context& context) {
  setup_archive(app, context,
                {.init = run_init,
                 .push = run_push,
                 .pull = run_pull,
                 .list = run_list,
                 .verify = run_verify,
                 .status = run_status,
                 .rerun = run_rerun,
                 .work = run_work,
                 .query = run_query});
}

}  // namespace trammel::archive

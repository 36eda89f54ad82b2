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
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "store/campaign.hpp"
#include "store/clock.hpp"
#include "store/open.hpp"

namespace trammel::archive {

namespace {

using cli::Context;
using cli::Json;

/// What all verbs share.
struct Options {
  std::string uri;  // --archive, or the URI of init
  bool insecure = false;
  std::string station;
  std::vector<std::string> campaigns;
  std::string to;
  int newest = 50;
};

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

Link link_to(const Options& options, const Context& context) {
  const auto station = read_station(context.db());
  return Link({.uri = uri_of(options, station),
               .insecure = options.insecure,
               .who = "trammel " + (station ? station->uuid : std::string("reader"))});
}

Station require_station(const Context& context) {
  if (auto station = read_station(context.db())) return *station;
  throw NotFoundError({.what = "this database is no station of an archive",
                       .where = {.file = context.db()},
                       .hint = "trammel archive init URI makes it one"});
}

ExitCode run_init(const Options& options, Context& context) {
  Link link({.uri = options.uri, .insecure = options.insecure, .who = "trammel init"});
  const bool made = install(link);
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
    context.print("archive-init",
                  {{"made", made}, {"station", station.uuid}, {"database", context.db()}});
  } else {
    context.print(fmt::format("{}; {} is station {}",
                              made ? "made the archive with its roles" : "the archive is there",
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
  Link link({.uri = uri_of(options, station),
             .insecure = options.insecure,
             .who = "trammel " + station.uuid});
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
    context.print(fmt::format("pushed {} campaigns: {} readings and {} other rows were new",
                              pushed.size(), n_readings, n_rows));
  }
  return ExitCode::ok;
}

ExitCode run_pull(const Options& options, Context& context) {
  const std::string station =
      options.station.empty() ? require_station(context).uuid : options.station;
  Link link = link_to(options, context);
  require_archive(link);
  const store::CheckReport report = pull(link, station, options.to);
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

struct Column {
  const char* key;
  bool number;
};

/// Rows of a query, as a table or as JSON.
void print_rows(const char* command, const char* key, const std::vector<Column>& columns,
                const std::vector<Link::Row>& rows, const Context& context) {
  Json list = Json::array();
  std::vector<std::vector<std::string>> cells;
  for (const Link::Row& row : rows) {
    Json object = Json::object();
    std::vector<std::string> line;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::string text = row[k].value_or("");
      line.push_back(text);
      if (!row[k]) {
        object[columns[k].key] = nullptr;
      } else if (columns[k].number) {
        object[columns[k].key] = std::stoll(text);
      } else {
        object[columns[k].key] = text;
      }
    }
    list.push_back(object);
    cells.push_back(line);
  }
  if (context.json) {
    context.print(command, {{key, list}});
    return;
  }
  std::vector<std::string> header;
  for (const Column& column : columns) header.emplace_back(column.key);
  terminal::Table table(header);
  for (auto& line : cells) table.add(std::move(line));
  context.print(table.text());
}

ExitCode run_list(const Options& options, Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  print_rows("archive-list", "campaigns",
             {{"name", false},
              {"kind", false},
              {"machine", false},
              {"n_readings", true},
              {"n_rows", true},
              {"moved_at", false},
              {"station", false},
              {"uuid", false},
              {"head", false}},
             link.ask("SELECT c.name, c.kind, c.machine, h.n_readings, h.n_rows, "
                      "to_char(h.moved_at AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'), "
                      "h.station, h.campaign, encode(h.head, 'hex') FROM (SELECT * FROM "
                      "trammel.campaign_head ORDER BY moved_at DESC LIMIT $1::int) AS h "
                      "LEFT JOIN trammel.campaign AS c USING (campaign) ORDER BY h.moved_at DESC",
                      {std::to_string(options.newest)}),
             context);
  return ExitCode::ok;
}

ExitCode run_status(const Options& options, Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  print_rows(
      "archive-status", "stations",
      {{"station", false},
       {"role", false},
       {"n_campaigns", true},
       {"n_readings", true},
       {"n_rows", true},
       {"last_push", false}},
      link.ask("SELECT s.uuid, s.role, count(h.campaign), coalesce(sum(h.n_readings), 0)::bigint, "
               "coalesce(sum(h.n_rows), 0)::bigint, to_char(max(h.moved_at) AT TIME ZONE 'UTC', "
               "'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"') FROM trammel.station AS s LEFT JOIN "
               "trammel.campaign_head AS h ON h.station = s.uuid GROUP BY s.uuid, s.role "
               "ORDER BY 6 DESC NULLS LAST"),
      context);
  return ExitCode::ok;
}

ExitCode run_verify(const Options& options, Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  std::vector<std::string> findings;
  for (const Link::Row& row : link.ask("SELECT trammel.findings() LIMIT 100")) {
    findings.push_back(row[0].value_or(""));
  }
  const Link::Row counts = link.ask(
                                   "SELECT coalesce(sum(n_readings), 0)::bigint, "
                                   "coalesce(sum(n_rows), 0)::bigint FROM trammel.campaign_head")
                               .at(0);
  if (context.json) {
    context.print("archive-verify", {{"ok", findings.empty()},
                                     {"n_readings", std::stoll(counts[0].value())},
                                     {"n_rows", std::stoll(counts[1].value())},
                                     {"findings", findings}});
  } else if (findings.empty()) {
    context.print(fmt::format("ok: {} readings and {} other rows are what was pushed",
                              counts[0].value(), counts[1].value()));
  } else {
    for (const std::string& finding : findings) context.print(cli::printable(finding));
  }
  return findings.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

/// A verb with the options that all have.
cli::Command verb(cli::Command archive, const char* name, const char* description,
                  const std::shared_ptr<Options>& options) {
  cli::Command command = archive.command(name, description);
  command.flag("--insecure", options->insecure,
               "Take what the URI says of TLS: the server is not proven to be the archive");
  return command;
}

}  // namespace

void setup_archive(cli::Command app, Context& context) {
  cli::Command archive =
      cli::noun(app, "archive", "The campaigns of many laboratories in one PostgreSQL database");
  const auto options = std::make_shared<Options>();
  cli::Command init =
      verb(archive, "init",
           "Make the archive where there is none, and this database a station of it", options);
  init.option("URI", options->uri, "Where it is: postgresql://HOST/NAME, service=NAME")
      .required()
      .type("URI");
  init.option("--station", options->station, "Go on as this station, whose file is lost")
      .type("UUID");
  on_run(init, context, options, run_init);
  cli::Command push_verb = verb(archive, "push", "Send what the archive has not", options);
  push_verb.option("CAMPAIGN", options->campaigns, "These alone, by name or uuid").type("CAMPAIGN");
  cli::Command pull_verb =
      verb(archive, "pull", "Make a station's database again, as a new file", options);
  pull_verb.option("--out,FILE", options->to, "New file").required().type("FILE");
  pull_verb.option("--station", options->station, "Which; else the one of this database")
      .type("UUID");
  cli::Command list = verb(archive, "list", "Campaigns of all stations, newest first", options);
  list.option("--newest", options->newest, "How many").range(1, 1000000).shown_default();
  cli::Command check =
      verb(archive, "verify", "Is every row what was pushed? The archive recomputes all digests",
           options);
  cli::Command status =
      verb(archive, "status", "Stations, what they have stored, and when", options);
  using Run = ExitCode (*)(const Options&, Context&);
  const std::vector<std::pair<cli::Command, Run>> verbs = {{push_verb, run_push},
                                                           {pull_verb, run_pull},
                                                           {list, run_list},
                                                           {check, run_verify},
                                                           {status, run_status}};
  for (const auto& [command, run] : verbs) {
    command.option("--archive", options->uri, "Another archive than the station's").type("URI");
    on_run(command, context, options, run);
  }
}

}  // namespace trammel::archive

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/archive/commands.hpp"
#include "app/archive/install.hpp"
#include "app/archive/work.hpp"
#include "app/job/stages.hpp"
#include "app/session/stop_signal.hpp"
#include "app/terminal/counted.hpp"

namespace trammel::archive {

namespace {

std::string machine_name() {
  std::array<char, 256> name = {};
  return gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data()
                                                                           : "unknown";
}

/// As text of a JSON object that the stage takes; empty: as in each campaign's newest job.
void require_parameters(const std::string& stage, const std::string& text) {
  const job::Stage& found = job::find_stage(stage);
  if (text.empty()) return;
  const job::Json parameters = job::Json::parse(text, nullptr, false);
  if (!parameters.is_object()) {
    throw InputError({.what = "the parameters are no JSON object",
                      .where = {.field = "--parameters"},
                      .got = text,
                      .expected = R"(an object, as {"steps": 10})"});
  }
  static_cast<void>(job::completed(found, parameters));
}

void require_campaign(Link& link, const std::string& campaign) {
  const auto found =
      link.ask("SELECT 1 FROM trammel.campaign WHERE $1 IN (name, campaign) LIMIT 1", {campaign});
  if (!found.empty()) return;
  throw NotFoundError({.what = "the archive has no such campaign",
                       .where = {.field = "--campaign"},
                       .got = campaign,
                       .hint = "trammel archive list names those it has"});
}

}  // namespace

ExitCode run_rerun(const cli::ArchiveOptions& options, cli::Context& context) {
  require_parameters(options.stage, options.parameters);
  Link link = link_to(options, context);
  require_archive(link);
  for (const std::string& campaign : options.campaigns) require_campaign(link, campaign);
  const auto campaigns =
      options.campaigns.empty() ? std::vector<std::string>{""} : options.campaigns;
  std::int64_t queued = 0;
  for (const std::string& campaign : campaigns) {
    std::vector<Link::Row> rows;
    link.written_by_a_person(
        "--where",
        "a condition on the columns of campaign and campaign_head; tables and views: ", [&] {
          rows = link.ask(
              "SELECT trammel.queue($1, nullif($2, ''), $3, ARRAY(SELECT campaign FROM "
              "trammel.campaign "
              "JOIN trammel.campaign_head USING (campaign) WHERE (" +
                  options.where +
                  "\n) AND $4 IN ('', station) AND $5 IN ('', name, campaign) "
                  "ORDER BY moved_at DESC LIMIT nullif($6::bigint, 0)))",
              {options.stage, options.parameters, options.force ? "t" : "f", options.station,
               campaign, std::to_string(options.last)});
        });
    queued += number_of(rows.at(0), 0);
  }
  if (context.json) {
    context.print("archive-rerun", {{"stage", options.stage}, {"queued", queued}});
  } else {
    context.print(
        fmt::format("queued {} of {}", options.stage, terminal::counted(queued, "campaign")));
  }
  context.next("trammel archive work --until-empty");
  return ExitCode::ok;
}

ExitCode run_work(const cli::ArchiveOptions& options, cli::Context& context) {
  const Station station = require_station(context);
  {
    Link link = link_to(options, context);
    require_archive(link);
  }
  session::count_stop_signals();
  const WorkDone done =
      work({.station = station.uuid,
            .machine = machine_name(),
            .jobs = options.jobs,
            .until_empty = options.until_empty,
            .lease_s = options.lease_s,
            .connect = [&] { return std::make_unique<Link>(link_to(options, context)); },
            .stop = [] { return session::stop_signals() > 0; },
            .abandon = [] { return session::stop_signals() > 1; },
            .say = [&context](const std::string& line) { context.say(cli::printable(line)); }});
  const cli::Json counts = {{"computed", done.computed},
                            {"known", done.known},
                            {"failed", done.failed},
                            {"late", done.late}};
  if (context.json) {
    context.print("archive-work", counts);
  } else {
    context.print(
        fmt::format("{} computed and stored, {} known, {} attempts failed, {} finished too late",
                    done.computed, done.known, done.failed, done.late));
  }
  if (done.abandoned) {
    std::fflush(stdout);
    std::_Exit(static_cast<int>(ExitCode::interrupted));  // threads still compute
  }
  if (session::stop_signals() > 0) return ExitCode::interrupted;
  return done.failed == 0 ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace trammel::archive

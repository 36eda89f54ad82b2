#include "app/cli/archive.hpp"

#include <algorithm>

#include "app/cli/cli.hpp"

namespace trammel::cli {

namespace {

ExitCode run_elsewhere(const ArchiveOptions&, Context&) {
  throw NotFoundError({.what = "this is not the program trammel-archive",
                       .hint = "it is in the package trammel-archive"});
}

struct Verb {
  Command archive;
  Context& context;
  const std::shared_ptr<ArchiveOptions>& options;

  Command operator()(const char* name, const char* description, ArchiveRun run) const {
    Command command = archive.command(name, description);
    command.flag(
        "--insecure", options->insecure,
        "Take the URI's TLS settings as they are, without proof that the server is the archive");
    if (std::string_view(name) != "init") {
      command.option("--archive", options->uri, "Another archive than the station's").type("URI");
    }
    on_run(command, context, options, run == nullptr ? run_elsewhere : run);
    return command;
  }
};

void setup_work(const Verb& verb, ArchiveOptions& options, const ArchiveRuns& runs) {
  Command rerun =
      verb("rerun",
           "Queue a calibration of all campaigns that the options name, for workers to compute, "
           "each with\nthe parameters of its newest job of the stage",
           runs.rerun);
  rerun.option("--stage", options.stage, "The calibration: lsq, geometry, idw, ...")
      .required()
      .type("METHOD");
  rerun.option("--station", options.station, "Campaigns of this station").type("UUID");
  rerun.option("--campaign", options.campaigns, "Only these, by name or uuid").type("CAMPAIGN");
  rerun.option(
      "--where", options.where,
      "SQL condition on the columns of campaign and campaign_head: kind, station, n_readings, ...");
  rerun.option("--newest", options.last, "Only the N pushed last (default: all)")
      .range(1, 100000000);
  rerun.option("--parameters", options.parameters, "The stage's parameters, as JSON").type("JSON");
  rerun.flag("--force", options.force, "Compute again what the archive has");
  Command work = verb("work", "Compute what is queued, as one of any number of workers", runs.work);
  work.option("--jobs", options.jobs, "How many to compute at once (default 1)").range(1U, 256U);
  work.flag("--until-empty", options.until_empty, "End when nothing is queued or being computed");
  work.option("--lease-s", options.lease_s,
              "After so many seconds without a sign of life others take the work over (default 60)")
      .range(1.0, 86400.0);
}

}  // namespace

void setup_archive(Command app, Context& context, const ArchiveRuns& runs) {
  Command archive =
      noun(app, "archive", "The campaigns of many laboratories in one PostgreSQL database");
  const auto options = std::make_shared<ArchiveOptions>();
  const Verb verb{archive, context, options};
  Command init = verb(
      "init", "Make the archive where there is none, and this database a station of it", runs.init);
  init.option("URI", options->uri, "Where it is: postgresql://HOST/NAME, service=NAME")
      .required()
      .type("URI");
  init.option("--station", options->station, "Go on as this station, whose file was lost")
      .type("UUID");
  verb("push", "Send what the archive does not have yet", runs.push)
      .option("CAMPAIGN", options->campaigns, "Only these, by name or uuid")
      .type("CAMPAIGN");
  Command pull = verb("pull", "Make a station's database again, as a new file", runs.pull);
  pull.option("--out,FILE", options->to, "New file").required().type("FILE");
  pull.option("--station", options->station, "The station (default: the one that this database is)")
      .type("UUID");
  pull.flag("--with-results", options->with_results, "Also the jobs that workers computed");
  verb("list", "Campaigns of all stations, newest first", runs.list)
      .option("--newest", options->newest, "How many (default 50)")
      .range(1, 1000000);
  verb("verify", "Recompute every digest in the archive: is every row what was pushed?",
       runs.verify);
  verb("status",
       "Stations and what they have stored; the queue with its workers, failures and alarms",
       runs.status);
  setup_work(verb, *options, runs);
  setup_query_options(verb("query",
                           "Run one SELECT on the archive, read only. Views as in a station's "
                           "database, with the\ncolumn station: v_accuracy, v_point_error, v_job, "
                           "v_drift, v_point_status; and the table model",
                           runs.query),
                      options->query);
}

std::string first_command(const std::vector<std::string>& words) {
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (words[k] == "--db" || words[k] == "--out") {
      ++k;
    } else if (!words[k].starts_with("-")) {
      return words[k];
    }
  }
  return "";
}

bool is_for_the_archive(const std::vector<std::string>& words) {
  const std::string command = first_command(words);
  return command == "archive" ||
         (command == "query" && std::ranges::any_of(words, [](const std::string& word) {
            return word == "--archive" || word.starts_with("--archive=");
          }));
}

}  // namespace trammel::cli

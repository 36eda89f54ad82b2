#include "app/cli/diagnose.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/files/campaign_file.hpp"
#include "app/files/files.hpp"
#include "app/files/plan_json.hpp"
#include "app/job/diagnosis_text.hpp"
#include "app/job/model_chain.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct DiagnoseOptions {
  job::Request request;
  Json given = Json::object();
  std::string from;
  std::string require;
  std::string plan;
};

/// On a folder: no database is opened.
Json of_folder(const DiagnoseOptions& options) {
  const job::Stage& stage = job::find_stage("diagnose");
  const Campaign campaign = baseline_of(read_campaign(options.from));
  Json details = stage.run(campaign, stage.complete(options.given)).details;
  details["kind"] = job::kind_text(campaign.simulated);
  return details;
}

Json of_stored(const DiagnoseOptions& options, Context& context) {
  job::Request request = options.request;
  store::Connection db =
      store::open(context.db(), request.dry_run ? store::Access::read_only : store::Access::write);
  request.stage = "diagnose";
  request.parameters = options.given;
  const job::Outcome outcome = job::run(db, request);
  if (outcome.reused) {
    context.say(fmt::format(
        "reused: job {} has the same readings, parameters and version (--force computes it again)",
        outcome.job.id));
  }
  if (!request.dry_run) job::store_model_chain(db, outcome.job);
  Json details = Json::parse(outcome.job.data.result_json)["details"];
  details["job"] = outcome.job.id == 0 ? Json() : Json(outcome.job.id);
  details["job_key"] = outcome.job.data.key.key;
  details["kind"] = job::kind_text(job::campaign_of(db, outcome.job.data).simulated);
  return details;
}

void write_plan(const DiagnoseOptions& options, const Json& details, Context& context) {
  if (options.plan.empty() || options.request.dry_run) return;
  if (details["next_points"].empty()) {
    context.say("no plan was written: there are no points to suggest");
    return;
  }
  write_output(options.plan, plan_json(job::next_points_plan(details)).dump(2) + "\n",
               context.existing());
  context.say(
      fmt::format("wrote {}: measure it with 'trammel session run'", printable(options.plan)));
}

void require_usable(const DiagnoseOptions& options) {
  if (options.from.empty() == options.request.campaign.empty()) {
    throw UsageError({.what = "diagnose takes a stored campaign or a folder, one of them",
                      .hint = "trammel diagnose CAMPAIGN, or trammel diagnose --from DIR"});
  }
}

ExitCode run_diagnose(const DiagnoseOptions& options, Context& context) {
  require_usable(options);
  Json details = options.from.empty() ? of_stored(options, context) : of_folder(options);
  details.erase("models");
  write_plan(options, details, context);
  const std::string verdict = details["verdict"];
  if (context.json) {
    context.print("diagnose", details);
  } else {
    const std::string name = details["campaign"];
    context.print(job::campaign_title(printable(name), details["kind"] == "simulated") + "\n" +
                  job::diagnosis_text(details));
  }
  if (options.request.dry_run) {
    context.say("dry run: nothing is stored");
  } else if (!options.from.empty()) {
    context.next(fmt::format("trammel campaign import {}", shell_word(options.from)));
  } else if (!details["next_points"].empty() && !options.plan.empty()) {
    context.next(fmt::format("trammel plan check {} --campaign {}", shell_word(options.plan),
                             shell_word(options.request.campaign)));
  } else if (verdict == "explained") {
    context.next(fmt::format("trammel model list {}", shell_word(options.request.campaign)));
  } else if (!details["next_points"].empty() && options.plan.empty()) {
    context.next(
        fmt::format("trammel diagnose {} --plan next.json", shell_word(options.request.campaign)));
  }
  return options.require.empty() || options.require == verdict ? ExitCode::ok
                                                               : ExitCode::not_acceptable;
}

}  // namespace

void setup_diagnose(Command app, Context& context) {
  Command command =
      app.command("diagnose", "Which physical effect is the model missing, and can it be trusted");
  auto options = std::make_shared<DiagnoseOptions>();
  command.option("campaign", options->request.campaign, "name or uuid of a stored campaign");
  command
      .option("--from", options->from, "a campaign/2 or /1 folder instead; no database is touched")
      .type("FOLDER");
  command
      .option("--session", options->request.sessions,
              "on this session (repeatable; all baseline sessions)")
      .type("SESSION");
  command.option("--plan", options->plan, "write the points to measure next as a plan")
      .type("FILE");
  command
      .on_option<std::vector<double>>(
          "--within",
          [options](const std::vector<double>& bounds) { options->given["within_mm"] = bounds; },
          "x and y of the points to measure next: low high, mm (where it was measured)")
      .expected(2);
  command.option("--require", options->require, "exit 5 when the verdict is another")
      .one_of({"nothing_missing", "explained", "ambiguous", "unexplained"});
  command.on_option<int>(
      "--seed", [options](const int& v) { options->given["seed"] = v; }, "of the bootstrap (1)");
  command.on_option<int>(
      "--replicates", [options](const int& v) { options->given["replicates"] = v; },
      "of the bootstrap (2000)");
  command.on_flag(
      "--shared-epochs", [options] { options->given["epochs"] = "shared"; },
      "no joint zeros and frame offset of their own for later epochs");
  command.flag("--force", options->request.force, "compute again and store another run");
  command.flag("--dry-run", options->request.dry_run, "compute and show, store nothing");
  on_run(command, context, options, run_diagnose);
}

}  // namespace trammel::cli

#include "app/cli/calibrate.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct CalibrateOptions {
  job::Request request;
  Json given = Json::object();
};

/// A stage's parameter as an option: what is given on the line goes into the parameters by name.
template <class T>
void parameter(Command command, const std::shared_ptr<CalibrateOptions>& options,
               const std::string& flag, const std::string& name, const std::string& what) {
  command.on_option<T>(
      flag, [options, name](const T& value) { options->given[name] = value; }, what);
}

Option choice(Command command, const std::shared_ptr<CalibrateOptions>& options,
              const std::string& flag, const std::string& name, const std::string& value,
              const std::string& what) {
  return command.on_flag(
      flag, [options, name, value] { options->given[name] = value; }, what);
}

void epoch_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  const Option own = choice(
      c, o, "--own-epochs", "epochs", "own",
      "joint zeros and a frame of its own for each later epoch (else only where readings show "
      "a step)");
  choice(c, o, "--shared-epochs", "epochs", "shared",
         "no joint zeros and frame offset of their own for later epochs")
      .excludes(own);
}

void lsq_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  choice(c, o, "--complete", "parameters", "complete-21",
         "the complete 21 parameters instead of the paper's 18");
  epoch_options(c, o);
  choice(c, o, "--basic", "solution", "basic",
         "leave what is not identified at zero (the paper's) instead of the least change");
  parameter<int>(c, o, "--steps", "steps",
                 "times the system is linearised and solved (10; 1: once, as the paper)");
  parameter<double>(c, o, "--attitude-weight", "attitude_weight",
                    "weight of attitude over the tracker's 1/sigma (1)");
  parameter<double>(c, o, "--drop-below", "drop_below",
                    "repeated identification: drop sources below this share of their machining "
                    "tolerance, solve again (0: no repetition)");
}

void idw_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  epoch_options(c, o);
  parameter<double>(c, o, "--power", "power", "weights 1 / d^power (2)");
  parameter<int>(c, o, "--neighbours", "neighbours", "nearest samples that count (0: all)");
  c.on_flag(
      "--tune", [o] { o->given["tune"] = true; }, "power and neighbours by leave-one-out");
}

void rbf_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  epoch_options(c, o);
  parameter<int>(c, o, "--neurons", "neurons", "at most this many (50)");
  parameter<int>(c, o, "--seed", "seed", "of the k-means start (1)");
  parameter<double>(c, o, "--sigma-mm", "sigma_mm", "spread of all neurons (0: leave-one-out)");
  parameter<double>(c, o, "--relative-ridge", "relative_ridge", "of the weights (1e-8)");
  c.on_flag(
      "--smooth", [o] { o->given["smooth"] = true; },
      "a neuron on every sample, ridge and spread by leave-one-out");
}

void model_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  c.on_option<std::vector<std::string>>(
       "--effects", [o](const std::vector<std::string>& names) { o->given["effects"] = names; },
       "named effects to fit beside the geometry, or 'diagnosed' for those diagnose names")
      .delimiter(',')
      .type("EFFECT");
  epoch_options(c, o);
  c.on_flag(
      "--robust", [o] { o->given["robust"] = true; }, "outlying readings count less (Huber)");
  c.on_flag(
      "--prior", [o] { o->given["tolerance_prior"] = true; },
      "machining tolerances as priors instead of the least change");
}

void hybrid_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  model_options(c, o);
  choice(c, o, "--always-map", "map", "always",
         "use the map although it does not help on held-out blocks");
}

void contest_options(Command c, const std::shared_ptr<CalibrateOptions>& o) {
  parameter<int>(c, o, "--blocks", "blocks", "spatial blocks of the cross-validation (6)");
  parameter<int>(c, o, "--seed", "seed", "of the blocks (1)");
}

struct StageOptions {
  const char* stage;
  void (*add)(Command, const std::shared_ptr<CalibrateOptions>&);
};
constexpr StageOptions kStageOptions[] = {{"lsq", lsq_options},        {"idw", idw_options},
                                          {"rbf", rbf_options},        {"gp", epoch_options},
                                          {"geometry", model_options}, {"hybrid", hybrid_options},
                                          {"contest", contest_options}};

ExitCode run_calibrate(const CalibrateOptions& options, Context& context) {
  job::Request request = options.request;
  request.parameters = options.given;
  store::Connection db =
      store::open(context.db(), request.dry_run ? store::Access::read_only : store::Access::write);
  const job::Outcome outcome = job::run(db, request);
  if (outcome.reused) {
    context.say(
        fmt::format("reused: job {} has the same readings, parameters and version "
                    "(--force computes it again)",
                    outcome.job.id));
  }
  store::CampaignRow campaign = job::campaign_of(db, outcome.job.data);
  const std::string campaign_name = campaign.name;
  if (context.json) {
    Json fields = job::job_json(outcome.job, campaign);
    fields["reused"] = outcome.reused;
    fields["dry_run"] = request.dry_run;
    context.print("calibrate", fields);
  } else {
    campaign.name = printable(campaign.name);
    context.print(job::job_text(outcome.job, campaign));
  }
  if (outcome.job.id == 0) {
    context.say("dry run: nothing is stored");
  } else {
    context.next("trammel report " + shell_word(campaign_name));
  }
  return ExitCode::ok;
}

}  // namespace

void setup_calibrate(Command app, Context& context) {
  Command calibrate = noun(app, "calibrate", "Identify a correction from a campaign's readings");
  for (const job::Stage& stage : job::stages()) {
    if (stage.name == "diagnose") continue;  // a command of its own
    Command command = calibrate.command(stage.name, stage.what);
    auto options = std::make_shared<CalibrateOptions>();
    options->request.stage = stage.name;
    command.option("campaign", options->request.campaign, "name or uuid").required();
    command
        .option("--session", options->request.sessions,
                "train on this session (repeatable; all baseline sessions)")
        .type("SESSION");
    command.flag("--force", options->request.force, "compute again and store another run");
    command.flag("--despite-screen", options->request.despite_screen,
                 "although the screen finds something gross (campaign check)");
    command.on_flag(
        "--without-suspects", [options] { options->given["without_suspects"] = true; },
        "leave out readings that are wrong for certain (campaign check: stale, missed, far)");
    command.flag("--dry-run", options->request.dry_run, "compute and show, store nothing");
    for (const StageOptions& own : kStageOptions) {
      if (stage.name == own.stage) own.add(command, options);
    }
    on_run(command, context, options, run_calibrate);
  }
}

}  // namespace trammel::cli

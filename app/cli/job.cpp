#include "app/cli/job.hpp"

#include <fmt/format.h>

#include "app/cli/rerun_all.hpp"
#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct JobOptions {
  std::string job, other, campaign;
  bool force = false;
  bool dry_run = false;
  bool all = false;
  RerunAllOptions sweep;
};

store::Connection open(const Context& context, store::Access access = store::Access::read_only) {
  return store::open(context.db(), access);
}

std::string campaign_name(store::Connection& db, store::Id id) {
  for (const store::CampaignRow& c : store::list_campaigns(db)) {
    if (c.id == id) return c.name;
  }
  return {};
}

ExitCode run_list(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  std::optional<store::Id> only;
  if (!options.campaign.empty()) only = store::require_campaign(db, options.campaign).id;
  Json jobs = Json::array();
  std::string text = fmt::format("{:>5}  {:<12}{:<10}{:>4}  {:<26}{:<14}{}\n", "job", "campaign",
                                 "stage", "run", "created (UTC)", "key", "readings");
  for (const store::JobRow& j : store::list_jobs(db, only)) {
    jobs.push_back({{"id", j.id},
                    {"campaign", j.campaign},
                    {"stage", j.stage},
                    {"algorithm_version", j.algorithm_version},
                    {"run", j.run},
                    {"key", j.key},
                    {"readings", j.n_readings},
                    {"created_utc", j.created_utc},
                    {"duration_s", j.duration_s}});
    text += fmt::format("{:>5}  {:<12}{:<10}{:>4}  {:<26}{:<14}{}\n", j.id, printable(j.campaign),
                        j.stage, j.run, j.created_utc, j.key.substr(0, 12), j.n_readings);
  }
  if (context.json) {
    context.print("job-list", {{"jobs", jobs}});
  } else {
    context.print(jobs.empty() ? "no jobs yet" : text);
  }
  return ExitCode::ok;
}

ExitCode run_show(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const std::string campaign = campaign_name(db, job.data.campaign_id);
  if (context.json) {
    context.print("job-show", job::job_json(job, campaign));
  } else {
    context.print(job::job_text(job, printable(campaign)));
  }
  return ExitCode::ok;
}

/// Parts of the key that differ, as {part, then, now}.
Json changed_parts(const store::JobKey& then, const store::JobKey& now) {
  Json changed = Json::array();
  for (const auto& [part, digest] : now.parts) {
    const auto at = then.parts.find(part);
    if (at != then.parts.end() && at->second == digest) continue;
    changed.push_back({{"part", part},
                       {"then", at == then.parts.end() ? Json() : Json(at->second)},
                       {"now", digest}});
  }
  return changed;
}

ExitCode run_why(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const store::JobKey now = job::key_of(db, job::request_of(db, job));
  const Json changed = changed_parts(job.data.key, now);
  const job::Request request = job::request_of(db, job);
  Json parts = Json::object();
  std::string text = fmt::format("job {} ({}, key {}) was computed from\n", job.id, job.data.stage,
                                 job.data.key.key);
  for (const auto& [part, digest] : job.data.key.parts) {
    parts[part] = digest;
    text += fmt::format("  {:<20}{}\n", part, digest.substr(0, 16));
  }
  text += fmt::format("  {} readings of {} sessions, {} readings left out, by {} {} ({})\n",
                      job.data.n_readings, job.data.sessions.size(), job.data.exclusions.size(),
                      job.provenance.tool_version, job.provenance.git_revision,
                      job.provenance.compiler);
  for (const Json& c : changed) {
    text += fmt::format("  changed since: {}\n", c["part"].get<std::string>());
  }
  text += changed.empty() ? "nothing of it has changed: running it again reuses this job\n"
                          : "running it again makes a new job\n";
  if (context.json) {
    context.print("job-why", {{"id", job.id},
                              {"key", job.data.key.key},
                              {"parts", parts},
                              {"sessions", request.sessions},
                              {"exclusions", job.data.exclusions.size()},
                              {"changed", changed},
                              {"current_key", now.key},
                              {"up_to_date", changed.empty()}});
  } else {
    context.print(text);
  }
  return ExitCode::ok;
}

ExitCode run_diff(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job a = job::find(db, options.job), b = job::find(db, options.other);
  const Json changed = changed_parts(a.data.key, b.data.key);
  const bool same_result = job::same_result(a.data.result_json, b.data.result_json);
  if (context.json) {
    context.print(
        "job-diff",
        {{"a", a.id},
         {"b", b.id},
         {"same_key", a.data.key.key == b.data.key.key},
         {"same_result", same_result},
         {"changed", changed},
         {"parameters", {Json::parse(a.data.parameters_json), Json::parse(b.data.parameters_json)}},
         {"statistics",
          {job::statistics_json(a.data.statistics), job::statistics_json(b.data.statistics)}}});
    return ExitCode::ok;
  }
  std::string text;
  for (const Json& c : changed) {
    text += fmt::format("  differs: {}\n", c["part"].get<std::string>());
  }
  text += changed.empty() ? "the inputs are the same, " : "so the inputs differ, ";
  text += same_result ? "and the results are the same bit for bit\n" : "and the results differ\n";
  for (const store::Job* job : {&a, &b}) {
    text += fmt::format("job {}: {} {}\n", job->id, job->data.stage, job->data.parameters_json) +
            job::statistics_text(job->data.statistics);
  }
  context.print(text);
  return ExitCode::ok;
}

ExitCode run_verify(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const store::NewJob again = job::compute(db, job::request_of(db, job));
  const bool same_inputs = again.key.key == job.data.key.key;
  const bool same_result = job::same_result(again.result_json, job.data.result_json);
  const bool ok = same_inputs && same_result;
  const std::string verdict =
      ok ? "the same inputs give the same result, bit for bit"
      : !same_inputs
          ? "its inputs have changed since: the stored result stands for the earlier ones"
          : "the same inputs give another result: not the same program, or a changed row";
  if (context.json) {
    context.print("job-verify", {{"id", job.id},
                                 {"ok", ok},
                                 {"same_inputs", same_inputs},
                                 {"same_result", same_result},
                                 {"verdict", verdict}});
  } else {
    context.print(fmt::format("job {}: {}", job.id, verdict));
  }
  return ok ? ExitCode::ok : ExitCode::not_acceptable;
}

ExitCode run_rerun_one(const JobOptions& options, Context& context) {
  if (options.job.empty()) {
    throw UsageError({.what = "job rerun needs a job, or --all with a stage",
                      .hint = "see trammel job rerun --help"});
  }
  store::Connection db =
      open(context, options.dry_run ? store::Access::read_only : store::Access::write);
  job::Request request = job::request_of(db, job::find(db, options.job));
  request.force = options.force;
  request.dry_run = options.dry_run;
  const job::Outcome outcome = job::run(db, request);
  const std::string campaign = campaign_name(db, outcome.job.data.campaign_id);
  if (outcome.reused) {
    context.say(fmt::format("reused: nothing has changed since job {}", outcome.job.id));
  }
  if (outcome.job.id == 0) context.say("dry run: nothing is stored");
  if (context.json) {
    Json fields = job::job_json(outcome.job, campaign);
    fields["reused"] = outcome.reused;
    fields["dry_run"] = options.dry_run;
    context.print("job-rerun", fields);
  } else {
    context.print(job::job_text(outcome.job, printable(campaign)));
  }
  return ExitCode::ok;
}

ExitCode run_rerun(const JobOptions& options, Context& context) {
  if (!options.all) return run_rerun_one(options, context);
  return run_rerun_all(options.sweep, options.force, options.dry_run, context);
}

CLI::App& verb(CLI::App& app, const char* name, const char* what) {
  return *noun(app, "job", "Stored computations: inputs, results, and whether they still hold")
              .add_subcommand(name, what);
}

}  // namespace

void setup_job(CLI::App& app, Context& context) {
  auto options = std::make_shared<JobOptions>();
  const char* const which = "a job's number, or six or more digits of its key";
  CLI::App& list = verb(app, "list", "All jobs, or those of a campaign");
  list.add_option("campaign", options->campaign, "name or uuid");
  on_run(list, context, options, run_list);
  struct Verb {
    const char* name;
    const char* what;
    ExitCode (*run)(const JobOptions&, Context&);
  };
  for (const Verb& v :
       {Verb{"show", "What a job found", run_show},
        Verb{"why", "What a job was computed from, and what changed since", run_why},
        Verb{"verify", "Compute again and compare bit for bit (5: differs)", run_verify}}) {
    CLI::App& command = verb(app, v.name, v.what);
    command.add_option("job", options->job, which)->required();
    on_run(command, context, options, v.run);
  }
  CLI::App& diff = verb(app, "diff", "Two jobs side by side");
  diff.add_option("job", options->job, which)->required();
  diff.add_option("other", options->other, which)->required();
  on_run(diff, context, options, run_diff);
  CLI::App& rerun = verb(app, "rerun", "The same calibration on the readings as they are now");
  CLI::Option* one = rerun.add_option("job", options->job, which);
  rerun.add_flag("--force", options->force, "store another run although nothing changed");
  rerun.add_flag("--dry-run", options->dry_run, "compute and show, store nothing");
  CLI::Option* all =
      rerun.add_flag("--all", options->all, "every campaign of the database instead of one job");
  one->excludes(all);
  setup_rerun_all(rerun, *all, options->sweep);
  on_run(rerun, context, options, run_rerun);
}

}  // namespace trammel::cli

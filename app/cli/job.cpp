#include "app/cli/job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/cli/rerun_all.hpp"
#include "app/job/diff.hpp"
#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/table.hpp"
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

/// Its name as a terminal may show it.
store::CampaignRow shown(store::CampaignRow campaign) {
  campaign.name = printable(campaign.name);
  return campaign;
}

/// The exclusions that a job honoured: [{"seq", "reason"}, …].
Json excluded(store::Connection& db, const store::NewJob& job) {
  Json all = Json::array();
  for (const store::Exclusion& e : store::exclusions(db, job.campaign_id)) {
    if (std::ranges::find(job.exclusions, e.id) == job.exclusions.end()) continue;
    all.push_back({{"seq", e.seq}, {"reason", e.reason}});
  }
  return all;
}

std::string excluded_text(const Json& excluded) {
  std::string text;
  for (const Json& e : excluded) {
    text += fmt::format("  left out: seq {}: {}\n", e["seq"].get<int>(),
                        printable(e["reason"].get<std::string>()));
  }
  return text;
}

ExitCode run_list(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  std::optional<store::Id> only;
  if (!options.campaign.empty()) only = store::require_campaign(db, options.campaign).id;
  Json jobs = Json::array();
  Table table({"job", "campaign", "stage", "run", "created (UTC)", "key", "readings"});
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
    table.add({std::to_string(j.id), j.campaign, j.stage, std::to_string(j.run), j.created_utc,
               j.key.substr(0, 12), std::to_string(j.n_readings)});
  }
  if (context.json) {
    context.print("job-list", {{"jobs", jobs}});
  } else {
    context.print(jobs.empty() ? "no jobs yet" : table.text());
  }
  context.next(jobs.empty() ? "trammel campaign list"
                            : fmt::format("trammel job show {}", jobs.back()["id"].get<int>()));
  return ExitCode::ok;
}

ExitCode run_show(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const store::CampaignRow campaign = job::campaign_of(db, job.data);
  const Json left_out = excluded(db, job.data);
  if (context.json) {
    Json fields = job::job_json(job, campaign);
    fields["excluded"] = left_out;
    context.print("job-show", fields);
  } else {
    context.print(job::job_text(job, shown(campaign)) + excluded_text(left_out));
  }
  return ExitCode::ok;
}

ExitCode run_why(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const job::Request request = job::request_of(db, job);
  const store::NewJob now = job::inputs_of(db, request, job.data.key.scheme);
  const Json changed = job::changed_parts(job.data.key, now.key);
  const std::vector<std::string> stale = job::stale_words(db, job, now);
  const Json left_out = excluded(db, job.data);
  Json parts = Json::object();
  std::string text = fmt::format("job {} ({}, key {}) was computed from\n", job.id, job.data.stage,
                                 job.data.key.key);
  for (const auto& [part, digest] : job.data.key.parts) {
    parts[part] = digest;
    text += fmt::format("  {:<20}{}\n", part, digest.substr(0, 16));
  }
  text += fmt::format("  {} of {}, {} left out, by {} {} ({})\n",
                      terminal::counted(job.data.n_readings, "reading"),
                      terminal::counted(job.data.sessions.size(), "session"),
                      job.data.exclusions.size(), job.provenance.tool_version,
                      job.provenance.git_revision, job.provenance.compiler) +
          excluded_text(left_out);
  if (job.data.key.scheme != store::kKeyScheme) {
    text += fmt::format(
        "key scheme {}: of a database before version 5; `trammel job rerun {}` makes "
        "a job with a key of today\n",
        job.data.key.scheme, job.id);
  }
  for (const std::string& word : stale) text += "changed since: " + printable(word) + "\n";
  text += changed.empty() ? "nothing of it has changed: running it again reuses this job\n"
                          : "running it again makes a new job\n";
  if (context.json) {
    context.print("job-why", {{"id", job.id},
                              {"key", job.data.key.key},
                              {"key_scheme", job.data.key.scheme},
                              {"parts", parts},
                              {"sessions", request.sessions},
                              {"exclusions", job.data.exclusions.size()},
                              {"excluded", left_out},
                              {"changed", changed},
                              {"stale", stale},
                              {"current_key", now.key.key},
                              {"up_to_date", changed.empty()}});
  } else {
    context.print(text);
  }
  return ExitCode::ok;
}

ExitCode run_diff(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const Json differences =
      job::job_differences(db, job::find(db, options.job), job::find(db, options.other));
  if (context.json) {
    context.print("job-diff", differences);
  } else {
    context.print(job::job_differences_text(differences));
  }
  return ExitCode::ok;
}

ExitCode run_verify(const JobOptions& options, Context& context) {
  store::Connection db = open(context);
  const store::Job job = job::find(db, options.job);
  const store::NewJob again = job::recompute(db, job);
  const bool up_to_date =
      job::inputs_of(db, job::request_of(db, job), job.data.key.scheme).key.key == job.data.key.key;
  const bool same_inputs = again.key.key == job.data.key.key;
  const bool same_result = job::same_outcome(again, job.data);
  const bool ok = same_inputs && same_result;
  std::string verdict;
  if (ok) {
    verdict = "the readings it was computed from give the same result, bit for bit";
    if (!up_to_date) verdict += "; there are other inputs now, see trammel job why";
  } else if (again.algorithm_version != job.data.algorithm_version) {
    verdict = fmt::format("it was computed by version {} of {}, this program has version {}",
                          job.data.algorithm_version, job.data.stage, again.algorithm_version);
  } else if (!same_inputs) {
    verdict = "its readings are not what was stored: see trammel db verify";
  } else {
    verdict = "the same readings give another result: not the same program, or a changed row";
  }
  if (context.json) {
    context.print("job-verify", {{"id", job.id},
                                 {"ok", ok},
                                 {"same_inputs", same_inputs},
                                 {"same_result", same_result},
                                 {"up_to_date", up_to_date},
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
  const store::CampaignRow campaign = job::campaign_of(db, outcome.job.data);
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
    context.print(job::job_text(outcome.job, shown(campaign)));
  }
  return ExitCode::ok;
}

ExitCode run_rerun(const JobOptions& options, Context& context) {
  if (!options.all) return run_rerun_one(options, context);
  return run_rerun_all(options.sweep, options.force, options.dry_run, context);
}

Command verb(Command app, const char* name, const char* what) {
  return noun(app, "job", "Stored computations: inputs, results, and whether they still hold")
      .command(name, what);
}

}  // namespace

void setup_job(Command app, Context& context) {
  auto options = std::make_shared<JobOptions>();
  const char* const which = "a job's number, or six or more digits of its key";
  Command list = verb(app, "list", "All jobs, or those of a campaign");
  list.option("campaign", options->campaign, "name or uuid");
  on_run(list, context, options, run_list);
  struct Verb {
    const char* name;
    const char* what;
    ExitCode (*run)(const JobOptions&, Context&);
  };
  for (const Verb& v :
       {Verb{"show", "What a job found", run_show},
        Verb{"why", "What a job was computed from, and what changed since", run_why},
        Verb{"verify", "Compute again from the same readings and compare bit for bit (5: differs)",
             run_verify}}) {
    Command command = verb(app, v.name, v.what);
    command.option("job", options->job, which).required();
    on_run(command, context, options, v.run);
  }
  Command diff = verb(app, "diff", "Two jobs side by side");
  diff.option("job", options->job, which).required();
  diff.option("other", options->other, which).required().type("JOB");
  on_run(diff, context, options, run_diff);
  Command rerun = verb(app, "rerun", "The same calibration on the readings as they are now");
  const Option one = rerun.option("job", options->job, which);
  rerun.flag("--force", options->force, "store another run although nothing changed");
  rerun.flag("--dry-run", options->dry_run, "compute and show, store nothing");
  const Option all =
      rerun.flag("--all", options->all, "every campaign of the database instead of one job");
  one.excludes(all);
  setup_rerun_all(rerun, all, options->sweep);
  on_run(rerun, context, options, run_rerun);
}

}  // namespace trammel::cli

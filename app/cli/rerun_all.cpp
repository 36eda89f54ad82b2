#include "app/cli/rerun_all.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "app/job/rerun_all.hpp"
#include "app/session/stop_signal.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/progress.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

job::Json parameters_of(const std::string& text) {
  if (text.empty()) return nullptr;
  job::Json parameters = job::Json::parse(text, nullptr, false);
  if (parameters.is_object()) return parameters;
  throw InputError({.what = "the parameters are no JSON object",
                    .where = {.field = "--parameters"},
                    .got = text,
                    .expected = R"(an object, as {"steps": 10})"});
}

}  // namespace

void setup_rerun_all(Command rerun, Option all, RerunAllOptions& options) {
  rerun.option("--stage", options.stage, "the calibration: lsq, geometry, idw, ...")
      .needs(all)
      .type("METHOD");
  rerun.option("--where", options.where, "SQL condition on the table campaign")
      .needs(all)
      .type("CONDITION");
  rerun
      .option("--parameters", options.parameters,
              "of the stage, as JSON (default: those of each campaign's newest job)")
      .needs(all)
      .type("JSON");
  rerun.option("--threads", options.threads, "that compute (default: one per core)")
      .needs(all)
      .range(1U, 256U);
}

ExitCode run_rerun_all(const RerunAllOptions& options, bool force, bool dry_run, Context& context) {
  if (options.stage.empty()) {
    throw UsageError({.what = "job rerun --all needs --stage",
                      .hint = "as in: trammel job rerun --all --stage lsq"});
  }
  store::Connection db =
      store::open(context.db(), dry_run ? store::Access::read_only : store::Access::write);
  session::count_stop_signals();
  std::optional<terminal::Progress> bar;
  const job::SweepResult result =
      job::rerun_all(db, {.stage = options.stage,
                          .where = options.where,
                          .parameters = parameters_of(options.parameters),
                          .force = force,
                          .dry_run = dry_run,
                          .threads = options.threads,
                          .stop = [] { return session::stop_signals() > 0; },
                          .progress =
                              [&](int done, int total) {
                                if (!bar)
                                  bar.emplace(context.quiet, isatty(STDERR_FILENO) == 1, 0, total);
                                bar->reached(done);
                              }});
  if (bar) bar->end();
  job::Json failed = job::Json::array();
  for (const job::SweepFailure& f : result.failed) {
    failed.push_back({{"campaign", f.campaign}, {"error", f.text}});
  }
  if (context.json) {
    context.print("job-rerun-all", {{"stage", options.stage},
                                    {"campaigns", result.campaigns},
                                    {"computed", result.computed},
                                    {"reused", result.reused},
                                    {"failed", failed},
                                    {"stopped", result.stopped},
                                    {"dry_run", dry_run}});
  } else {
    std::string text =
        fmt::format("{} on {}: {} {}, {} reused, {} failed", options.stage,
                    terminal::counted(result.campaigns, "campaign"), result.computed,
                    dry_run ? "would be stored" : "stored", result.reused, result.failed.size());
    for (const job::SweepFailure& f : result.failed) {
      text += fmt::format("\n  {}: {}", printable(f.campaign), printable(f.text));
    }
    context.print(text);
  }
  if (result.stopped) {
    context.say("stopped: the same command goes on from here");
    return ExitCode::interrupted;
  }
  return result.failed.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace trammel::cli

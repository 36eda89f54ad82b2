#include "app/cli/protocol.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/cli/example_files.hpp"
#include "app/cli/report.hpp"
#include "app/files/files.hpp"
#include "app/files/plan_json.hpp"
#include "app/job/run.hpp"
#include "app/protocol/run.hpp"
#include "app/report/gather.hpp"
#include "app/report/print.hpp"
#include "app/session/stop_signal.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

session::Surroundings surroundings_of(const Context& context) {
  session::Surroundings surroundings;
  surroundings.correction_of = [](store::Connection& connection, store::Id id) {
    return job::correction_of(connection, id);
  };
  surroundings.stop_signals = session::stop_signals;
  surroundings.stopped_by = session::stop_signal_words;
  // Each step is told as it ends: a progress line is for a person who watches.
  surroundings.terminal = isatty(STDERR_FILENO) == 1;
  surroundings.quiet = context.quiet || !surroundings.terminal;
  return surroundings;
}

/// One step, and everything that is wrong with its plan.
void tell(const protocol::StepOutcome& step, const std::string& number, const Context& context) {
  context.say(fmt::format("{}  {:<17} {}{}", number, printable(step.name), printable(step.detail),
                          step.done_before ? "  (done before)" : ""));
  for (const Violation& violation : step.violations) context.say("  " + describe(violation));
}

/// Runs the protocol, telling each step. A plan that is not safe is refused before there is a
/// database.
protocol::Outcome execute(const protocol::Protocol& protocol, const Context& context) {
  const std::vector<protocol::StepOutcome> unsafe = protocol::preflight(protocol);
  for (const protocol::StepOutcome& step : unsafe) tell(step, "refused", context);
  if (!unsafe.empty()) return {.steps = unsafe, .code = unsafe.front().code};
  store::Connection connection = store::open(context.db(), store::Access::create);
  session::count_stop_signals();
  std::size_t n = 0;
  return protocol::run(connection, protocol, surroundings_of(context),
                       [&](const protocol::StepOutcome& step) {
                         tell(step, fmt::format("{:>2}/{}", ++n, protocol.steps.size()), context);
                       });
}

report::Report report_of(const std::string& campaign, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  return report::gather(connection, store::require_campaign(connection, campaign));
}

Json steps_json(const std::vector<protocol::StepOutcome>& outcomes) {
  Json steps = Json::array();
  for (const protocol::StepOutcome& step : outcomes) {
    steps.push_back({{"name", step.name},
                     {"kind", step.kind},
                     {"done_before", step.done_before},
                     {"skipped", step.skipped},
                     {"detail", step.detail},
                     {"exit_code", static_cast<int>(step.code)}});
    if (!step.violations.empty()) {
      steps.back()["violations"] = violations_json(step.violations);
    }
  }
  return steps;
}

void say_stopped(const protocol::Outcome& outcome, const std::string& again,
                 const Context& context) {
  if (!outcome.steps.back().violations.empty()) {
    context.say("nothing has moved: fix the plans or the mechanism's limits first");
    return;
  }
  context.say(fmt::format("stopped in step {}: what was measured is stored",
                          printable(outcome.steps.back().name)));
  context.next(again);
}

/// What is there stays: a user may have changed it, and the campaign was measured with it.
void write_unless_there(const std::filesystem::path& path, std::string_view content) {
  if (!std::filesystem::exists(path)) write_output(path, content, Existing::refuse);
}

std::vector<protocol::StepOutcome> planned_steps(const protocol::Protocol& protocol,
                                                 const Context& context) {
  if (!std::filesystem::exists(context.db())) return protocol::dry_run(nullptr, protocol);
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  return protocol::dry_run(&connection, protocol);
}

/// Tells what a run would do; nothing is stored and nothing moves.
ExitCode tell_plan(const std::string& command, const protocol::Protocol& protocol,
                   const Context& context) {
  const std::vector<protocol::StepOutcome> steps = planned_steps(protocol, context);
  if (context.json) {
    context.print(command, {{"campaign", protocol.name},
                            {"database", context.db()},
                            {"dry_run", true},
                            {"exit_code", 0},
                            {"steps", steps_json(steps)}});
    return ExitCode::ok;
  }
  std::string text =
      fmt::format("campaign {} in {}\n", printable(protocol.name), printable(context.db()));
  for (std::size_t k = 0; k < steps.size(); ++k) {
    text += fmt::format("{:>2}/{}  {:<16} {}{}\n", k + 1, steps.size(), printable(steps[k].name),
                        printable(steps[k].detail), steps[k].done_before ? "  (done before)" : "");
  }
  context.print(text);
  context.say("dry run: nothing is stored and nothing moves");
  return ExitCode::ok;
}

/// As it stands in the folder, else as it would be written there.
protocol::Protocol demo_protocol(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "protocol.json";
  return std::filesystem::exists(file) ? protocol::read_protocol(file)
                                       : protocol::parse_protocol(kPaperProtocol, file);
}

/// The demo's own, whatever TRAMMEL_DB names: that, and one that no demo began, is somebody's
/// laboratory.
void own_database(const std::filesystem::path& folder, Context& context) {
  if (!context.db_option.empty()) return;
  context.db_option = (folder / "trammel.db").string();
  if (!std::filesystem::exists(context.db()) || std::filesystem::exists(folder / "protocol.json")) {
    return;
  }
  throw InputError({.what = "there is a laboratory in this folder that no demo began",
                    .where = {.file = context.db()},
                    .hint = "name another folder: trammel demo FOLDER"});
}

}  // namespace

ExitCode run_protocol(const ProtocolOptions& options, Context& context) {
  const protocol::Protocol protocol = protocol::read_protocol(options.file);
  if (options.dry_run) return tell_plan("protocol-run", protocol, context);
  const protocol::Outcome outcome = execute(protocol, context);
  if (context.json) {
    context.print("protocol-run", {{"campaign", protocol.name},
                                   {"database", context.db()},
                                   {"dry_run", false},
                                   {"exit_code", static_cast<int>(outcome.code)},
                                   {"steps", steps_json(outcome.steps)}});
  } else if (outcome.code == ExitCode::ok) {
    context.print(fmt::format("campaign {}: all {} steps are done", printable(protocol.name),
                              protocol.steps.size()));
  }
  if (outcome.code == ExitCode::ok) {
    context.next("trammel report " + shell_word(protocol.name));
  } else {
    say_stopped(outcome, "trammel protocol run " + shell_word(options.file), context);
  }
  return outcome.code;
}

ExitCode run_demo(const DemoOptions& options, Context& context) {
  const std::filesystem::path folder = options.folder;
  own_database(folder, context);
  if (options.dry_run) return tell_plan("demo", demo_protocol(folder), context);
  std::filesystem::create_directories(folder);
  write_unless_there(folder / "robot.json", kPaperRobot);
  write_unless_there(folder / "protocol.json", kPaperProtocol);
  const protocol::Protocol protocol = protocol::read_protocol(folder / "protocol.json");
  context.say(fmt::format("measuring the paper's campaign on a virtual robot, into {}",
                          printable(context.db())));
  const protocol::Outcome outcome = execute(protocol, context);
  if (outcome.code != ExitCode::ok) {
    say_stopped(outcome, "trammel demo " + shell_word(options.folder), context);
    return outcome.code;
  }
  const report::Report found = report_of(protocol.name, context);
  const Json json = report::to_json(found);
  write_output(folder / "report.txt", report::to_text(found, {.glyphs = page().glyphs}),
               Existing::replace);
  write_output(folder / "report.html", report_page(protocol.name, context), Existing::replace);
  Json file = {{"schema", "trammel/report/1"}};
  file.update(json);
  write_output(folder / "report.json", file.dump(2) + "\n", Existing::replace);
  if (context.json) {
    context.print("demo",
                  {{"database", context.db()}, {"folder", folder.string()}, {"report", json}});
  } else {
    context.print(with_bold_headings(report::to_text(found, page())));
  }
  context.say(fmt::format("database {}; report {}, report.html and report.json",
                          printable(context.db()), (folder / "report.txt").string()));
  context.next("trammel campaign show " + shell_word(protocol.name));
  return ExitCode::ok;
}

void setup_protocol(Command app, Context& context) {
  Command protocols = noun(app, "protocol", "A whole campaign as data");
  auto options = std::make_shared<ProtocolOptions>();
  Command run = protocols.command(
      "run", "Measure, calibrate, compensate, measure again; resumes, and skips what is done");
  run.option("FILE", options->file, "protocol/1, as examples/paper/protocol.json").required();
  run.flag("--dry-run", options->dry_run, "Say what is left to do, store and move nothing");
  on_run(run, context, options, run_protocol);
}

void setup_demo(Command app, Context& context) {
  auto options = std::make_shared<DemoOptions>();
  Command demo =
      app.command("demo", "The paper's whole campaign on the virtual robot, with its report");
  demo.option("FOLDER", options->folder, "Where everything goes").shown_default();
  demo.flag("--dry-run", options->dry_run, "Say what is left to do, store and move nothing");
  on_run(demo, context, options, run_demo);
}

}  // namespace trammel::cli

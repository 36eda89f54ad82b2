#include "app/cli/protocol.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "app/cli/example_files.hpp"
#include "app/cli/report.hpp"
#include "app/device/open.hpp"
#include "app/files/files.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/temporary_folder.hpp"
#include "app/job/run.hpp"
#include "app/protocol/run.hpp"
#include "app/report/gather.hpp"
#include "app/report/page/page.hpp"
#include "app/report/print.hpp"
#include "app/session/plan_record.hpp"
#include "app/session/stop_signal.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/progress.hpp"
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
  for (const std::string& what : step.missing) context.say("  missing: " + printable(what));
}

/// Waits until a person at this terminal has acted; false after Ctrl-C.
bool asked_here(const std::string& ask, const Context& context) {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) return false;
  context.say(
      fmt::format("{}: press Enter when it is done, Ctrl-C to go on later", printable(ask)));
  constexpr int kPollMs = 200;
  for (pollfd key{STDIN_FILENO, POLLIN, 0}; session::stop_signals() == 0;) {
    if (poll(&key, 1, kPollMs) <= 0) continue;
    std::string line;
    return static_cast<bool>(std::getline(std::cin, line));
  }
  return false;
}

/// Runs the protocol, telling each step. A plan that is not safe, or that a real stage has no
/// record of, is refused before there is a database. `confirmed`: pauses whose work the line says
/// is done.
protocol::Outcome execute(const protocol::Protocol& protocol,
                          const std::vector<std::string>& confirmed, const Context& context) {
  const protocol::Requests requests = protocol::requests_of(protocol);
  std::vector<protocol::StepOutcome> unsafe = protocol::preflight(protocol, requests, nullptr);
  std::erase_if(unsafe, [](const auto& step) { return step.code == ExitCode::ok; });
  for (const protocol::StepOutcome& step : unsafe) tell(step, "refused", context);
  if (!unsafe.empty()) return {.steps = unsafe, .code = unsafe.front().code};
  store::Connection connection = store::open(context.db(), store::Access::create);
  session::count_stop_signals();
  std::size_t n = 0;
  const protocol::Person person{
      .tell =
          [&](const protocol::StepOutcome& step) {
            tell(step, fmt::format("{:>2}/{}", ++n, protocol.steps.size()), context);
          },
      .confirms =
          [&](const std::string& name, const std::string& ask) {
            return std::ranges::find(confirmed, name) != confirmed.end() ||
                   asked_here(ask, context);
          }};
  return protocol::run(connection, protocol, requests, surroundings_of(context), person);
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
    if (!step.missing.empty()) steps.back()["missing"] = step.missing;
    if (step.estimated_s > 0) steps.back()["estimated_s"] = step.estimated_s;
  }
  return steps;
}

/// `again` is the line that goes on, `check` the one that looks at the plans; empty: none.
void say_stopped(const protocol::Outcome& outcome, const std::string& again,
                 const std::string& check, const Context& context) {
  const protocol::StepOutcome& last = outcome.steps.back();
  if (!last.violations.empty()) {
    context.say("nothing has moved: fix the plans or the mechanism's limits first");
    if (!check.empty()) context.next(check);
  } else if (last.code == ExitCode::safety_stop && !last.missing.empty()) {
    context.say("nothing has moved since: see what is missing");
    if (!check.empty()) context.next(check + " --record");
  } else if (last.kind == "pause") {
    context.say("once it is done, confirm it; what was measured is stored");
    context.next(again + " --confirm " + shell_word(last.name));
  } else if (last.kind == "report") {
    context.say("all is measured; the tolerance is not shown to be met");
  } else {
    context.say(
        fmt::format("stopped in step {}: what was measured is stored", printable(last.name)));
    context.next(again);
  }
}

/// What is there stays: a user may have changed it, and the campaign was measured with it.
void write_unless_there(const std::filesystem::path& path, std::string_view content) {
  if (!std::filesystem::exists(path)) write_output(path, content, Existing::refuse);
}

/// The database, to be read, where there is one yet.
std::optional<store::Connection> laboratory_there(const Context& context) {
  if (!std::filesystem::exists(context.db())) return std::nullopt;
  return store::open(context.db(), store::Access::read_only);
}

std::vector<protocol::StepOutcome> planned_steps(const protocol::Protocol& protocol,
                                                 const Context& context) {
  const protocol::Requests requests = protocol::requests_of(protocol);
  std::optional<store::Connection> laboratory = laboratory_there(context);
  return protocol::dry_run(laboratory ? &*laboratory : nullptr, protocol, requests);
}

/// "left to measure: 1:02:03 h, without the points that diagnoses will suggest".
std::string duration_words(const protocol::Protocol& protocol,
                           const std::vector<protocol::StepOutcome>& steps, double& total_s) {
  bool unknown = false;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    total_s += steps[k].estimated_s;
    const auto* measure = std::get_if<protocol::MeasureStep>(&protocol.steps[k].what);
    unknown = unknown || (measure != nullptr && measure->suggested() && !steps[k].done_before);
  }
  return "left to measure: " + terminal::clock_text(total_s) +
         (unknown ? ", without the points that diagnoses will suggest" : "");
}

/// Tells what a run would do; nothing is stored and nothing moves.
ExitCode tell_plan(const std::string& command, const protocol::Protocol& protocol,
                   const Context& context) {
  const std::vector<protocol::StepOutcome> steps = planned_steps(protocol, context);
  double total_s = 0;
  const std::string duration = duration_words(protocol, steps, total_s);
  const auto bad = std::ranges::find_if(
      steps, [](const protocol::StepOutcome& step) { return step.code != ExitCode::ok; });
  const ExitCode code = bad == steps.end() ? ExitCode::ok : bad->code;
  if (context.json) {
    context.print(command, {{"campaign", protocol.name},
                            {"database", context.db()},
                            {"dry_run", true},
                            {"exit_code", static_cast<int>(code)},
                            {"estimated_s", total_s},
                            {"steps", steps_json(steps)}});
    return code;
  }
  std::string text =
      fmt::format("campaign {} in {}\n", printable(protocol.name), printable(context.db()));
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const protocol::StepOutcome& step = steps[k];
    text += fmt::format("{:>2}/{}  {:<16} {}{}{}\n", k + 1, steps.size(), printable(step.name),
                        printable(step.detail),
                        step.estimated_s > 0 ? ", " + terminal::clock_text(step.estimated_s) : "",
                        step.done_before ? "  (done before)" : "");
    for (const Violation& violation : step.violations) text += "  " + describe(violation) + "\n";
    for (const std::string& what : step.missing) text += "  missing: " + printable(what) + "\n";
  }
  context.print(text + duration);
  context.say("dry run: nothing is stored and nothing moves");
  return code;
}

/// As it stands in the folder, else as it would be written there.
ExitCode tell_demo(const std::filesystem::path& folder, Context& context) {
  const std::filesystem::path file = folder / "protocol.json";
  if (std::filesystem::exists(file)) {
    return tell_plan("demo", protocol::read_protocol(file), context);
  }
  const TemporaryFolder aside;  // a dry run writes nothing where they are to stand
  write_unless_there(aside.path() / "robot.json", kPaperRobot);
  return tell_plan("demo", protocol::parse_protocol(kPaperProtocol, aside.path() / "protocol.json"),
                   context);
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

void require_pauses(const protocol::Protocol& protocol, const std::vector<std::string>& names) {
  std::vector<std::string> pauses;
  for (const protocol::Step& step : protocol.steps) {
    if (std::holds_alternative<protocol::PauseStep>(step.what)) pauses.push_back(step.name);
  }
  for (const std::string& name : names) {
    if (std::ranges::find(pauses, name) != pauses.end()) continue;
    throw UsageError({.what = "the protocol has no such pause",
                      .where = {.field = "--confirm"},
                      .got = name,
                      .expected = pauses.empty() ? "a protocol with pauses"
                                                 : fmt::format("{}", fmt::join(pauses, ", "))});
  }
}

/// One record for each file that steps name: the plan it is of must be one.
std::size_t write_records(const protocol::Protocol& protocol, const protocol::Requests& requests,
                          const Context& context) {
  std::map<std::string, std::string> written;  // file, digest
  for (const protocol::Step& step : protocol.steps) {
    const auto* measure = std::get_if<protocol::MeasureStep>(&step.what);
    if (measure == nullptr || measure->suggested() || measure->plan_check.empty()) continue;
    const session::Request& request = requests.at(step.name);
    const device::Devices devices = device::open_devices(request.stage, request.tracker);
    CheckOptions check = session::check_for(request.check, devices.motion);
    const std::string file = measure->plan_check.string();
    const std::string digest = session::plan_sha256(request.plan, devices.machine);
    if (const auto [at, is_new] = written.emplace(file, digest); !is_new) {
      if (at->second == digest) continue;
      throw InputError({.what = "two plans cannot have one record",
                        .where = {.file = file, .field = "plan_check"},
                        .got = step.name,
                        .expected = "a file for each plan"});
    }
    session::write_plan_record(file, request.plan, devices.machine, check, context.existing());
  }
  return written.size();
}

ExitCode check_protocol(const ProtocolOptions& options, Context& context) {
  const protocol::Protocol protocol = protocol::read_protocol(options.file);
  const protocol::Requests requests = protocol::requests_of(protocol);
  std::optional<store::Connection> laboratory = laboratory_there(context);
  std::vector<protocol::StepOutcome> steps =
      protocol::preflight(protocol, requests, laboratory ? &*laboratory : nullptr);
  bool safe = true;
  for (protocol::StepOutcome& step : steps) {
    safe = safe && step.violations.empty();
    step.missing.clear();  // it is what this command is asked for
    step.code = step.violations.empty() ? ExitCode::ok : ExitCode::safety_stop;
  }
  const bool records = options.record && safe && !options.dry_run;
  const std::size_t n_records = records ? write_records(protocol, requests, context) : 0;
  if (context.json) {
    context.print("protocol-check", {{"campaign", protocol.name},
                                     {"safe", safe},
                                     {"n_records", n_records},
                                     {"steps", steps_json(steps)}});
  } else {
    std::string text;
    for (const protocol::StepOutcome& step : steps) {
      for (const Violation& v : step.violations) {
        text += printable(step.name) + ", " + describe(v) + "\n";
      }
    }
    text +=
        fmt::format("{}: {}, {}", printable(protocol.name), terminal::counted(steps.size(), "plan"),
                    safe ? "every target and path is safe" : "not all are safe");
    if (records) text += "; " + terminal::counted(n_records, "record") + " written";
    context.print(text);
  }
  const std::string file = shell_word(options.file);
  context.next(safe ? "trammel protocol run " + file + " --dry-run"
                    : "put it right, then: trammel protocol check " + file);
  return safe ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace

ExitCode run_protocol(const ProtocolOptions& options, Context& context) {
  const protocol::Protocol protocol = protocol::read_protocol(options.file);
  require_pauses(protocol, options.confirmed);
  if (options.dry_run) return tell_plan("protocol-run", protocol, context);
  const protocol::Outcome outcome = execute(protocol, options.confirmed, context);
  if (context.json) {
    context.print("protocol-run", {{"campaign", protocol.name},
                                   {"database", context.db()},
                                   {"dry_run", false},
                                   {"exit_code", static_cast<int>(outcome.code)},
                                   {"steps", steps_json(outcome.steps)}});
  } else if (outcome.code == ExitCode::ok) {
    context.print(fmt::format("campaign {}: {} done", printable(protocol.name),
                              protocol.steps.size() == 1
                                  ? "its step is"
                                  : fmt::format("all {} steps are", protocol.steps.size())));
  }
  if (outcome.code == ExitCode::ok) {
    context.next("trammel report " + shell_word(protocol.name));
  } else {
    say_stopped(outcome, "trammel protocol run " + shell_word(options.file),
                "trammel protocol check " + shell_word(options.file), context);
  }
  return outcome.code;
}

ExitCode run_demo(const DemoOptions& options, Context& context) {
  const std::filesystem::path folder = options.folder;
  own_database(folder, context);
  if (options.dry_run) return tell_demo(folder, context);
  std::filesystem::create_directories(folder);
  write_unless_there(folder / "robot.json", kPaperRobot);
  write_unless_there(folder / "protocol.json", kPaperProtocol);
  const protocol::Protocol protocol = protocol::read_protocol(folder / "protocol.json");
  context.say(fmt::format("measuring the paper's campaign on a virtual robot, into {}",
                          printable(context.db())));
  const protocol::Outcome outcome = execute(protocol, {}, context);
  if (outcome.code != ExitCode::ok) {
    say_stopped(outcome, "trammel demo " + shell_word(options.folder), "", context);
    return outcome.code;
  }
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, protocol.name);
  const report::Gathered gathered = report::gather(connection, campaign);
  const report::Report& found = gathered.report;
  const Json json = report::to_json(found);
  write_output(folder / "report.txt", report::to_text(found, {.glyphs = page().glyphs}),
               Existing::replace);
  write_output(folder / "report.html",
               report::page_html(report::page_json(connection, campaign, gathered)),
               Existing::replace);
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
  run.option("--confirm", options->confirmed,
             "The pause of this name is over (a terminal shows a prompt); several with commas")
      .delimiter(',')
      .type("PAUSE");
  run.flag("--dry-run", options->dry_run,
           "Say what is left to do and how long it takes, store and move nothing");
  on_run(run, context, options, run_protocol);
  auto checked = std::make_shared<ProtocolOptions>();
  Command check =
      protocols.command("check", "Every target and path of every plan; records for a real stage");
  check.option("FILE", checked->file, "protocol/1").required();
  check.flag("--record", checked->record, "Write the records that its steps name (plan_check)");
  check.flag("--dry-run", checked->dry_run, "Check, write no record");
  on_run(check, context, checked, check_protocol);
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

#include "app/cli/protocol.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "app/cli/example_files.hpp"
#include "app/cli/report.hpp"
#include "app/exchange/files.hpp"
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
  // Each step is told as it ends: a progress line is for a person who watches.
  surroundings.terminal = isatty(STDERR_FILENO) == 1;
  surroundings.quiet = context.quiet || !surroundings.terminal;
  return surroundings;
}

/// Runs the protocol, telling each step.
protocol::Outcome execute(const protocol::Protocol& protocol, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::create);
  session::count_stop_signals();
  std::size_t n = 0;
  return protocol::run(
      connection, protocol, surroundings_of(context), [&](const protocol::StepOutcome& step) {
        context.say(fmt::format("{:>2}/{}  {:<17} {}{}", ++n, protocol.steps.size(),
                                printable(step.name), printable(step.detail),
                                step.done_before ? "  (done before)" : ""));
      });
}

report::Report report_of(const std::string& campaign, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  return report::gather(connection, store::require_campaign(connection, campaign));
}

Json steps_json(const protocol::Outcome& outcome) {
  Json steps = Json::array();
  for (const protocol::StepOutcome& step : outcome.steps) {
    steps.push_back({{"name", step.name},
                     {"kind", step.kind},
                     {"done_before", step.done_before},
                     {"skipped", step.skipped},
                     {"detail", step.detail},
                     {"exit_code", static_cast<int>(step.code)}});
  }
  return steps;
}

void say_stopped(const protocol::Outcome& outcome, const std::string& again,
                 const Context& context) {
  context.say(fmt::format("stopped in step {}: what was measured is stored",
                          printable(outcome.steps.back().name)));
  context.next(again);
}

std::string db_words(const Context& context) {
  return context.db() == "./trammel.db" ? "" : " --db " + shell_word(context.db());
}

/// What is there stays: a user may have changed it, and the campaign was measured with it.
void write_unless_there(const std::filesystem::path& path, std::string_view content) {
  if (!std::filesystem::exists(path)) write_file_atomically(path, content);
}

}  // namespace

ExitCode run_protocol(const ProtocolOptions& options, Context& context) {
  const protocol::Protocol protocol = protocol::read_protocol(options.file);
  const protocol::Outcome outcome = execute(protocol, context);
  if (context.json) {
    context.print("protocol-run", {{"campaign", protocol.name},
                                   {"database", context.db()},
                                   {"exit_code", static_cast<int>(outcome.code)},
                                   {"steps", steps_json(outcome)}});
  } else if (outcome.code == ExitCode::ok) {
    context.print(fmt::format("campaign {}: all {} steps are done", printable(protocol.name),
                              protocol.steps.size()));
  }
  if (outcome.code == ExitCode::ok) {
    context.next("trammel report " + shell_word(protocol.name) + db_words(context));
  } else {
    say_stopped(outcome, "trammel protocol run " + shell_word(options.file) + db_words(context),
                context);
  }
  return outcome.code;
}

ExitCode run_demo(const DemoOptions& options, Context& context) {
  const std::filesystem::path folder = options.folder;
  std::filesystem::create_directories(folder);
  write_unless_there(folder / "robot.json", kPaperRobot);
  write_unless_there(folder / "protocol.json", kPaperProtocol);
  if (!context.db_given()) context.db_option = (folder / "trammel.db").string();
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
  write_file_atomically(folder / "report.txt", report::to_text(found));
  write_file_atomically(folder / "report.json", json.dump(2) + "\n");
  if (context.json) {
    context.print("demo",
                  {{"database", context.db()}, {"folder", folder.string()}, {"report", json}});
  } else {
    context.print(with_bold_headings(report::to_text(found)));
  }
  context.say(fmt::format("database {}, report {} and {}", printable(context.db()),
                          (folder / "report.txt").string(), (folder / "report.json").string()));
  context.next("trammel campaign show " + shell_word(protocol.name) + db_words(context));
  return ExitCode::ok;
}

void setup_protocol(CLI::App& app, Context& context) {
  CLI::App& protocols = noun(app, "protocol", "A whole campaign as data");
  auto options = std::make_shared<ProtocolOptions>();
  CLI::App* run = protocols.add_subcommand(
      "run", "Measure, calibrate, compensate, measure again; resumes, and skips what is done");
  run->add_option("FILE", options->file, "protocol/1, as examples/paper/protocol.json")->required();
  on_run(*run, context, options, run_protocol);
}

void setup_demo(CLI::App& app, Context& context) {
  auto options = std::make_shared<DemoOptions>();
  CLI::App* demo = app.add_subcommand(
      "demo", "The paper's whole campaign on the virtual robot, with its report");
  demo->add_option("FOLDER", options->folder, "Where everything goes")->capture_default_str();
  on_run(*demo, context, options, run_demo);
}

}  // namespace trammel::cli

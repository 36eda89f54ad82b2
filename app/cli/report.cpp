#include "app/cli/report.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/files/files.hpp"
#include "app/report/dcc.hpp"
#include "app/report/gather.hpp"
#include "app/report/page/page.hpp"
#include "app/report/print.hpp"
#include "app/terminal/columns.hpp"
#include "store/open.hpp"

namespace trammel::cli {

std::string with_bold_headings(const std::string& text) {
  if (!colour(STDOUT_FILENO)) return text;
  std::string out, line, next;
  std::istringstream in(text);
  for (bool more = static_cast<bool>(std::getline(in, line)); more; line = next) {
    next.clear();
    more = static_cast<bool>(std::getline(in, next));
    out += (next.starts_with("---") ? bold(line) : line) + "\n";
  }
  return out;
}

report::Page page() {
  constexpr std::size_t kWide = 102;  // columns that whole tables take
  return {.glyphs = utf8_wanted() ? report::Glyphs::blocks : report::Glyphs::ascii,
          .narrow = terminal_columns().value_or(kWide) < kWide};
}

namespace {

/// A machine that is not shown to pass is no acceptable answer.
ExitCode answered(const report::Report& found) {
  return found.tolerance && found.tolerance->machine != Conformity::passes
             ? ExitCode::not_acceptable
             : ExitCode::ok;
}

void say_written(const std::string& file, const std::string& what, const ReportOptions& options,
                 const Context& context) {
  context.say(
      fmt::format("{}{}: {}", options.dry_run ? "would write " : "", printable(file), what));
}

void print_report(const report::Report& found, Context& context) {
  if (context.json) {
    context.print("report", report::to_json(found));
  } else {
    context.print(with_bold_headings(report::to_text(found, page())));
  }
  const std::string name = shell_word(found.campaign);
  const bool is_prr = found.mechanism.starts_with("3-PRR");
  context.next(found.jobs.empty()
                   ? (is_prr ? "trammel calibrate lsq " : "trammel calibrate geometry ") + name
               : found.story.empty() ? "trammel diagnose " + name
                                     : "trammel assess " + name);
}

void print_page(const report::Report& found, const std::string& html, const ReportOptions& options,
                const Context& context) {
  if (context.json) {
    Json fields = report::to_json(found);
    fields["html"] = {
        {"file", options.html}, {"n_bytes", html.size()}, {"written", !options.dry_run}};
    context.print("report", fields);
  } else {
    context.print(fmt::format("{}{}: {:.2f} MB, needs a browser and nothing else",
                              options.dry_run ? "would write " : "", printable(options.html),
                              static_cast<double>(html.size()) / 1e6) +
                  (found.tolerance ? "\n" + report::tolerance_words(*found.tolerance) + "." : ""));
  }
}

}  // namespace

ExitCode run_report(const ReportOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  report::Gathered gathered = report::gather(connection, campaign);
  report::Report& found = gathered.report;
  report::JudgedPoints points;
  if (options.tolerance_mm || !options.dcc.empty()) {
    points = report::judged_points(connection, campaign, gathered);
  }
  if (options.tolerance_mm) found.tolerance = report::tolerance_test(points, *options.tolerance_mm);
  if (!options.dcc.empty()) {
    const std::string xml = report::dcc_xml(connection, campaign, found, points);
    if (!options.dry_run) write_output(options.dcc, xml, context.existing());
    say_written(options.dcc, "a digital calibration certificate in the form of PTB's DCC 3.3.0",
                options, context);
  }
  if (options.html.empty()) {
    print_report(found, context);
  } else {
    const std::string html = report::page_html(report::page_json(connection, campaign, gathered));
    if (!options.dry_run) write_output(options.html, html, context.existing());
    print_page(found, html, options, context);
  }
  return answered(found);
}

void setup_report(Command app, Context& context) {
  auto options = std::make_shared<ReportOptions>();
  Command command = app.command("report", "Accuracy before and after, and what it rests on");
  command.option("CAMPAIGN", options->campaign, "Name or uuid").required();
  command
      .option("--html", options->html,
              "Write the report as a page in one file: all figures, for screen and paper")
      .type("FILE");
  command
      .option("--tolerance", options->tolerance_mm,
              "mm: does the position error stay within it, U considered? exit 5 if it is not shown")
      .positive();
  command
      .option("--dcc", options->dcc, "Write the errors with U as a digital calibration certificate")
      .type("FILE");
  command.flag("--dry-run", options->dry_run, "Make page and certificate, and write nothing");
  on_run(command, context, options, run_report);
}

}  // namespace trammel::cli

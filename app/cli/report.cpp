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

std::string report_page(const std::string& campaign, const Context& context,
                        const std::optional<double>& tolerance_mm) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  return report::page_html(
      report::page_json(connection, store::require_campaign(connection, campaign), tolerance_mm));
}

namespace {

report::Report found_of(const ReportOptions& options, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  report::Report found = report::gather(connection, campaign);
  if (options.tolerance_mm) {
    found.tolerance = report::tolerance_test(report::judged_points(connection, campaign, found),
                                             *options.tolerance_mm);
  }
  return found;
}

/// A machine that is not shown to pass is no acceptable answer.
ExitCode answered(const report::Report& found) {
  return found.tolerance && found.tolerance->machine != Conformity::passes
             ? ExitCode::not_acceptable
             : ExitCode::ok;
}

void write_dcc(const ReportOptions& options, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  const report::Report found = report::gather(connection, campaign);
  const std::string xml = report::dcc_xml(connection, campaign, found,
                                          report::judged_points(connection, campaign, found));
  if (!options.dry_run) write_output(options.dcc, xml, context.existing());
  context.say(fmt::format("{}{}: a digital calibration certificate in the form of PTB's DCC 3.3.0",
                          options.dry_run ? "would write " : "", printable(options.dcc)));
}

ExitCode print_report(const ReportOptions& options, const Context& context) {
  const report::Report found = found_of(options, context);
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
  return answered(found);
}

}  // namespace

ExitCode run_report(const ReportOptions& options, Context& context) {
  if (!options.dcc.empty()) write_dcc(options, context);
  if (options.html.empty()) return print_report(options, context);
  const report::Report found = found_of(options, context);
  const std::string html = report_page(options.campaign, context, options.tolerance_mm);
  if (!options.dry_run) write_output(options.html, html, context.existing());
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

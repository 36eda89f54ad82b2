#include "app/cli/report.hpp"

#include <unistd.h>

#include <sstream>

#include "app/cli/columns.hpp"
#include "app/report/gather.hpp"
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

void print_report(const std::string& campaign, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const report::Report found =
      report::gather(connection, store::require_campaign(connection, campaign));
  if (context.json) {
    context.print("report", report::to_json(found));
  } else {
    context.print(with_bold_headings(report::to_text(found, page())));
  }
  const std::string name = shell_word(found.campaign);
  context.next(found.jobs.empty()    ? "trammel calibrate lsq " + name
               : found.story.empty() ? "trammel diagnose " + name
                                     : "trammel assess " + name);
}

ExitCode run_report(const ReportOptions& options, Context& context) {
  print_report(options.campaign, context);
  return ExitCode::ok;
}

void setup_report(CLI::App& app, Context& context) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command =
      app.add_subcommand("report", "Accuracy before and after, and what it rests on");
  command->add_option("CAMPAIGN", options->campaign, "Name or uuid")->required();
  on_run(*command, context, options, run_report);
}

}  // namespace trammel::cli

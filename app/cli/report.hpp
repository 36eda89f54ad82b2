#pragma once

#include <string>

#include "app/cli/context.hpp"
#include "app/report/print.hpp"

namespace trammel::cli {

struct ReportOptions {
  std::string campaign;
  std::string html;  // the page's file; empty: none
  bool dry_run = false;
};

/// `report CAMPAIGN`: before and after, for each figure whether in-sample or held-out; with --html
/// as a page in one file.
void setup_report(Command app, Context& context);
ExitCode run_report(const ReportOptions& options, Context& context);

/// `text` with its underlined headings bold, on a terminal that may be coloured.
std::string with_bold_headings(const std::string& text);

/// What stdout is: a terminal of some width, or a file.
report::Page page();

/// The report of a campaign as a page.
std::string report_page(const std::string& campaign, const Context& context);

/// Prints the report of a campaign, as text or JSON.
void print_report(const std::string& campaign, const Context& context);

}  // namespace trammel::cli

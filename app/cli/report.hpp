#pragma once

#include <optional>
#include <string>

#include "app/cli/context.hpp"
#include "app/report/print.hpp"

namespace trammel::cli {

struct ReportOptions {
  std::string campaign;
  std::string html;  // the page's file; empty: none
  std::string dcc;   // the certificate's file; empty: none
  std::optional<double> tolerance_mm;
  bool dry_run = false;
};

/// `report CAMPAIGN`: before and after, for each figure whether in-sample or held-out; with --html
/// as a page in one file; with --tolerance whether the machine is shown to meet it (else exit 5).
void setup_report(Command app, Context& context);
ExitCode run_report(const ReportOptions& options, Context& context);

/// `text` with its underlined headings bold, on a terminal that may be coloured.
std::string with_bold_headings(const std::string& text);

/// What stdout is: a terminal of some width, or a file.
report::Page page();

}  // namespace trammel::cli

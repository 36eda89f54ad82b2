#pragma once
// What the verbs of `trammel archive` do; what they take stands in app/cli/archive.hpp.

#include "app/archive/link.hpp"
#include "app/archive/station.hpp"
#include "app/cli/archive.hpp"

namespace trammel::archive {

/// The one noun of the program trammel-archive.
void setup(cli::Command app, cli::Context& context);

/// To the archive that the line names, else TRAMMEL_ARCHIVE, else the one of the station's file.
Link link_to(const cli::ArchiveOptions& options, const cli::Context& context);
Station require_station(const cli::Context& context);

ExitCode run_status(const cli::ArchiveOptions& options, cli::Context& context);
ExitCode run_rerun(const cli::ArchiveOptions& options, cli::Context& context);
ExitCode run_work(const cli::ArchiveOptions& options, cli::Context& context);
ExitCode run_query(const cli::ArchiveOptions& options, cli::Context& context);

/// A column of an answer: text, or a whole number.
struct Column {
  const char* key;
  bool number = false;
};
/// Rows as a list of objects, and as a table with a line of names.
cli::Json rows_json(const std::vector<Column>& columns, const std::vector<Link::Row>& rows);
std::string rows_text(const std::vector<Column>& columns, const std::vector<Link::Row>& rows);

}  // namespace trammel::archive

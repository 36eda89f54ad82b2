#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "app/archive/commands.hpp"
#include "app/archive/install.hpp"

namespace trammel::archive {

namespace {

/// As SQLite has them: whole numbers (and what is true), numbers, texts.
store::Cell cell_of(const std::optional<std::string>& text, unsigned type) {
  if (!text) return nullptr;
  switch (type) {
    case 16:  // bool
      return std::int64_t{*text == "t"};
    case 20:  // int8, int2, int4
    case 21:
    case 23:
      return static_cast<std::int64_t>(std::stoll(*text));
    case 700:  // float4, float8, numeric
    case 701:
    case 1700:
      return std::stod(*text);
    default:
      return *text;
  }
}

/// A name alone asks for all of it.
std::string question_of(const std::string& sql) {
  const bool name = !sql.empty() && std::ranges::all_of(sql, [](unsigned char c) {
    return std::islower(c) != 0 || c == '_';
  });
  return name ? "SELECT * FROM trammel." + sql : sql;
}

}  // namespace

ExitCode run_query(const cli::ArchiveOptions& options, cli::Context& context) {
  Link link = link_to(options, context);
  require_archive(link);
  const Link::Transaction asked(link);  // rolled back
  link.run(
      "SET TRANSACTION READ ONLY; SET LOCAL search_path = trammel, pg_catalog, pg_temp; "
      "SET LOCAL statement_timeout = " +
      std::to_string(static_cast<long>(options.query.timeout_s * 1000)));
  const Link::Table table = link.table(question_of(options.query.sql));
  std::size_t at = 0;
  const auto next = [&]() -> std::optional<std::vector<store::Cell>> {
    if (at == table.rows.size()) return std::nullopt;
    std::vector<store::Cell> cells;
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      cells.push_back(cell_of(table.rows[at][k], table.types[k]));
    }
    ++at;
    return cells;
  };
  cli::print_answer({table.columns, next}, options.query, context);
  return ExitCode::ok;
}

}  // namespace trammel::archive

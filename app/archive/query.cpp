#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <nlohmann/json.hpp>

#include "app/archive/answer.hpp"
#include "app/archive/commands.hpp"
#include "app/archive/install.hpp"
#include "app/files/numbers.hpp"

namespace trammel::archive {

namespace {

constexpr std::chrono::milliseconds kGrace{500};  // in which the server should have ended it

/// As SQLite has them: whole numbers (and what is true), numbers, texts. What is no number of that
/// size, as 1e400 and NaN, stays the text it is.
store::Cell cell_of(const std::string& text, unsigned type) {
  switch (type) {
    case 16:  // bool
      return std::int64_t{text == "t"};
    case 20:  // int8, int2, int4
    case 21:
    case 23: {
      std::int64_t value = 0;
      const char* const end = text.data() + text.size();
      const auto read = std::from_chars(text.data(), end, value);
      if (read.ec == std::errc{} && read.ptr == end) return value;
      return text;
    }
    case 700:  // float4, float8, numeric
    case 701:
    case 1700:
      if (const auto value = parse_number(text)) return *value;
      return text;
    default:
      return text;
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
  using std::chrono::milliseconds;
  Link link = link_to(options, context);
  require_archive(link);
  const milliseconds limit(static_cast<long>(options.query.timeout_s * 1000));
  link.run(
      "BEGIN READ ONLY; SET LOCAL search_path = trammel, pg_catalog, pg_temp; "
      "SET LOCAL statement_timeout = " +
      std::to_string(limit.count()));
  const std::string question = question_of(options.query.sql);
  link.written_by_a_person("SQL", "one SELECT, or the name of a table or view: ", [&] {
    Link::Answer answer(link, question, limit + kGrace);
    const bool is_select = question == options.query.sql;
    const auto next = [&]() -> std::optional<std::vector<store::Cell>> {
      const auto row = answer.next();
      if (!row) return std::nullopt;
      std::vector<store::Cell> cells;
      for (std::size_t k = 0; k < row->size(); ++k) {
        const auto& value = (*row)[k];
        if (is_select && value && value->size() > store::kLongestAnsweredBytes) {
          throw StoreError({.what = "a value of the answer is too long",
                            .where = {.field = answer.columns()[k]},
                            .got = std::to_string(value->size()) + " bytes",
                            .expected = std::to_string(store::kLongestAnsweredBytes) + " at most"});
        }
        cells.push_back(value ? cell_of(*value, answer.types().at(k)) : nullptr);
      }
      return cells;
    };
    cli::print_answer({answer.columns(), next}, options.query, context);
  });
  return ExitCode::ok;
}

}  // namespace trammel::archive

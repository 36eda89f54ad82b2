#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace trammel {

/// One value and where it stands.
struct CsvCell {
  std::string_view text;
  int column = 0;  // from 1, in bytes
};

/// A table of text: header line, then rows of as many cells. Cells look into `text` and `unquoted`.
struct CsvTable {
  struct Row {
    int line = 0;  // from 1
    std::vector<CsvCell> cells;
  };

  std::string name;  // the file, as errors show it
  std::unique_ptr<const std::string> text;
  std::deque<std::string> unquoted;
  Row header;
  std::vector<Row> rows;

  /// Where cell `k` of `row` stands; the field is the column's name.
  [[nodiscard]] Where where(const Row& row, std::size_t k) const;
};

inline constexpr std::size_t kMaxCsvBytes = 512u << 20;
inline constexpr std::size_t kMaxCsvRows = 2'000'000;
inline constexpr std::size_t kMaxCsvColumns = 1000;
inline constexpr std::size_t kMaxCsvCellBytes = 100'000;

/// RFC 4180: comma-separated, "quoted ""cells""", CRLF or LF, the last newline may be missing, a
/// byte order mark is skipped; and what people's programs write where it has one reading: blanks
/// around cells, empty lines at the end, comments (lines that begin with # and are no row), a first
/// line sep=; of a spreadsheet, separators behind the last column, semicolons or tabs in place of
/// commas (as the header line has them), and decimal commas, in quotes where commas separate.
/// Throws InputError with line and column: no header, two kinds of separators in it, an empty or
/// repeated column name, a row with more or fewer cells than the header, a quote that does not
/// close, text after a closing quote, a NUL byte, UTF-16, an empty line between others, decimal
/// points beside decimal commas, more than the caps above. Proof: csv_test.cpp.
CsvTable parse_csv(std::string text, const std::string& name);
CsvTable read_csv(const std::filesystem::path& path);

/// ';' of the line sep=;, as spreadsheets write it above the header: in capitals or quotes too,
/// with blanks behind it. NUL: it is no such line. Proof: csv_test.cpp.
char stated_separator(std::string_view line);

/// A cell as RFC 4180 writes it: quoted when it must be.
std::string csv_cell(std::string_view text);

/// Free text for a cell: what a spreadsheet would run (it begins with = + - @, tab, carriage
/// return, or a full-width form of these) gets a ' in front, as it would be typed to be text. A
/// number stays as it is. Nothing is lost: text that begins with ' and then such a sign gets one
/// more. Proof: csv_test.cpp.
std::string defused(std::string_view text);
/// The text that `defused` was given.
std::string_view undefused(std::string_view cell);

}  // namespace trammel

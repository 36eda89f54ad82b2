#include "app/files/csv.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "app/files/files.hpp"
#include "app/files/numbers.hpp"

namespace trammel {

namespace {

/// Walks the text row by row.
class Scanner {
 public:
  explicit Scanner(CsvTable& table) : table_(table), text_(*table.text) {
    if (text_.starts_with("\xEF\xBB\xBF")) start_ = at_ = 3;
  }

  [[nodiscard]] bool at_end() const { return at_ >= text_.size(); }

  CsvTable::Row row() {
    CsvTable::Row row{.line = line_, .cells = {}};
    for (;;) {
      if (row.cells.size() == kMaxCsvColumns) {
        refuse("more than " + std::to_string(kMaxCsvColumns) + " columns");
      }
      row.cells.push_back(cell());
      if (row.cells.back().text.size() > kMaxCsvCellBytes) {
        refuse("a cell of more than " + std::to_string(kMaxCsvCellBytes) + " bytes");
      }
      if (at_end() || text_[at_] != ',') break;
      ++at_;
    }
    end_line();
    return row;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(
        {.what = what, .where = {.file = table_.name, .line = line_, .column = column(at_)}});
  }

  [[nodiscard]] int column(std::size_t offset) const {
    return static_cast<int>(offset - start_) + 1;
  }

  CsvCell cell() {
    if (!at_end() && text_[at_] == '"') return quoted();
    const std::size_t from = at_;
    at_ = std::min(text_.find_first_of(std::string_view(",\r\n\"\0", 5), at_), text_.size());
    if (!at_end() && text_[at_] == '"')
      refuse("a quote inside a cell that does not begin with one");
    if (!at_end() && text_[at_] == '\0') refuse("a NUL byte");
    return {text_.substr(from, at_ - from), column(from)};
  }

  CsvCell quoted() {
    const int begin = column(at_);
    std::string& value = table_.unquoted.emplace_back();
    for (++at_;; ++at_) {
      if (at_end()) refuse("a quote that does not close");
      if (text_[at_] == '\0') refuse("a NUL byte");
      if (text_[at_] == '"') {
        if (at_ + 1 >= text_.size() || text_[at_ + 1] != '"') break;
        ++at_;
      }
      if (text_[at_] == '\n') {
        ++line_;
        start_ = at_ + 1;
      }
      value += text_[at_];
    }
    ++at_;
    if (!at_end() && std::string_view(",\r\n").find(text_[at_]) == std::string_view::npos) {
      refuse("text after a closing quote");
    }
    return {value, begin};
  }

  void end_line() {
    if (at_end()) return;
    if (text_[at_] == '\r') {
      if (at_ + 1 >= text_.size() || text_[at_ + 1] != '\n') refuse("a carriage return on its own");
      ++at_;
    }
    ++at_;
    ++line_;
    start_ = at_;
  }

  CsvTable& table_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t start_ = 0;  // of the line
  int line_ = 1;
};

bool is_blank(const CsvTable::Row& row) {
  return row.cells.size() == 1 && row.cells[0].text.empty();
}

void check_header(const CsvTable& table) {
  if (is_blank(table.header)) {
    throw InputError({.what = "the header line is missing",
                      .where = {.file = table.name, .line = 1, .column = 1}});
  }
  std::vector<std::string_view> seen;
  for (const CsvCell& cell : table.header.cells) {
    const Where where{.file = table.name,
                      .line = table.header.line,
                      .column = cell.column,
                      .field = std::string(cell.text)};
    if (cell.text.empty()) throw InputError({.what = "a column without a name", .where = where});
    if (std::find(seen.begin(), seen.end(), cell.text) != seen.end()) {
      throw InputError({.what = "duplicate column",
                        .where = where,
                        .hint = parse_number(cell.text) ? "is the header line missing?" : ""});
    }
    seen.push_back(cell.text);
  }
}

void check_length(const CsvTable& table, const CsvTable::Row& row) {
  const std::size_t n = table.header.cells.size();
  if (row.cells.size() == n) return;
  const std::size_t k = std::min(row.cells.size(), n);  // the first that is missing or too many
  Where where{.file = table.name,
              .line = row.line,
              .column = row.cells[std::min(k, row.cells.size() - 1)].column};
  if (k < n) where.field = std::string(table.header.cells[k].text);
  throw InputError({.what = k < n ? "a field is missing" : "more fields than columns",
                    .where = where,
                    .got = std::to_string(row.cells.size()) + " fields",
                    .expected = std::to_string(n)});
}

// Where the sign stands that makes a spreadsheet run the text, behind any '; or none.
std::optional<std::size_t> sign_at(std::string_view text) {
  static constexpr std::array<std::string_view, 10> kSigns = {
      "=", "+", "-", "@", "\t", "\r", "\uFF1D", "\uFF0B", "\uFF0D", "\uFF20"};
  const std::size_t at = std::min(text.find_first_not_of('\''), text.size());
  for (const std::string_view sign : kSigns) {
    if (text.substr(at).starts_with(sign)) return at;
  }
  return std::nullopt;
}

}  // namespace

Where CsvTable::where(const Row& row, std::size_t k) const {
  return {.file = name,
          .line = row.line,
          .column = row.cells.at(k).column,
          .field = std::string(header.cells.at(k).text)};
}

CsvTable parse_csv(std::string text, const std::string& name) {
  CsvTable table;
  table.name = name;
  table.text = std::make_unique<const std::string>(std::move(text));
  Scanner scanner(table);
  table.header = scanner.row();
  check_header(table);
  while (!scanner.at_end()) {
    if (table.rows.size() == kMaxCsvRows) {
      throw InputError({.what = "more than " + std::to_string(kMaxCsvRows) + " rows",
                        .where = {.file = name},
                        .hint = "import it in parts"});
    }
    table.rows.push_back(scanner.row());
    if (is_blank(table.rows.back()) && table.header.cells.size() > 1) {
      throw InputError({.what = "an empty line",
                        .where = {.file = name, .line = table.rows.back().line, .column = 1}});
    }
    check_length(table, table.rows.back());
  }
  return table;
}

CsvTable read_csv(const std::filesystem::path& path) {
  return parse_csv(read_file(path, kMaxCsvBytes), path.string());
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string defused(std::string_view text) {
  if (!sign_at(text) || parse_number(text)) return std::string(text);
  return "'" + std::string(text);
}

std::string_view undefused(std::string_view cell) {
  return cell.starts_with('\'') && sign_at(cell) ? cell.substr(1) : cell;
}

}  // namespace trammel

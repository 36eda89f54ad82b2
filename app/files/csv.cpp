#include "app/files/csv.hpp"

#include <algorithm>
#include <array>
#include <cctype>
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
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF")) {
      refuse("the file is UTF-16: save it as UTF-8");
    }
    const char mark = stated_separator(line());
    if (mark != '\0') to_next_line();
    skip_comments(0);
    const std::string_view header = line();
    separator_ =
        mark != '\0' ? mark : separator_of(header.substr(0, header.find_last_not_of(" \t") + 1));
    if (!is_separator(separator_)) refuse("'sep=' names no comma, semicolon or tab");
    ends_ = {separator_, '\r', '\n', '"', '\0'};
  }

  [[nodiscard]] char separator() const { return separator_; }

  [[nodiscard]] bool at_end() const { return at_ >= text_.size(); }

  /// Lines that begin with # and are no row: a # of its own is the name of a column, and what has
  /// as many cells as the `columns` of the header may be text that begins so.
  void skip_comments(std::size_t columns) {
    while (!at_end() && text_[at_] == '#') {
      const std::string_view comment = line();
      if (comment.size() > 1 && is_separator(comment[1])) return;
      const auto marks = std::ranges::count(comment, separator_);
      if (columns > 0 && static_cast<std::size_t>(marks) + 1 == columns) return;
      to_next_line();
    }
  }

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
      if (at_end() || text_[at_] != separator_) break;
      ++at_;
    }
    end_line();
    return row;
  }

 private:
  [[nodiscard]] static bool is_separator(char c) { return c == ',' || c == ';' || c == '\t'; }

  [[nodiscard]] std::string_view line() const {
    return text_.substr(at_, text_.find_first_of("\r\n", at_) - at_);
  }
  void to_next_line() {
    at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
    end_line();
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(
        {.what = what, .where = {.file = table_.name, .line = line_, .column = column(at_)}});
  }

  [[nodiscard]] int column(std::size_t offset) const {
    return static_cast<int>(offset - start_) + 1;
  }

  /// The one mark that separates the names of the header line.
  [[nodiscard]] char separator_of(std::string_view header) const {
    std::string found;
    bool quoted = false;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (!quoted && is_separator(c) && found.find(c) == std::string::npos) {
        found += c;
      }
    }
    if (found.size() > 1) {
      refuse(
          "the header line has more than one of comma, semicolon and tab: which of them "
          "separates columns has two readings");
    }
    return found.empty() ? ',' : found.front();
  }

  [[nodiscard]] bool is_padding(char c) const {
    return c == ' ' || (c == '\t' && separator_ != '\t');
  }
  void skip_padding() {
    while (!at_end() && is_padding(text_[at_])) ++at_;
  }

  CsvCell cell() {
    skip_padding();
    if (!at_end() && text_[at_] == '"') return quoted();
    const std::size_t from = at_;
    at_ = std::min(text_.find_first_of(std::string_view(ends_.data(), ends_.size()), at_),
                   text_.size());
    if (!at_end() && text_[at_] == '"')
      refuse("a quote inside a cell that does not begin with one");
    if (!at_end() && text_[at_] == '\0') refuse("a NUL byte");
    std::size_t to = at_;
    while (to > from && is_padding(text_[to - 1])) --to;
    return {text_.substr(from, to - from), column(from)};
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
    skip_padding();
    if (!at_end() && text_[at_] != separator_ && text_[at_] != '\r' && text_[at_] != '\n') {
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
  char separator_ = ',';
  std::array<char, 5> ends_ = {};  // of a cell
};

bool is_blank(const CsvTable::Row& row) {
  return std::ranges::all_of(row.cells, [](const CsvCell& cell) { return cell.text.empty(); });
}

/// Separators behind the last column, as spreadsheets leave them.
void drop_empty_end(CsvTable::Row& row, std::size_t columns) {
  while (row.cells.size() > columns && row.cells.back().text.empty()) row.cells.pop_back();
}

/// Whether a number of the table has a decimal point.
bool has_decimal_points(const CsvTable& table) {
  return std::ranges::any_of(table.rows, [](const CsvTable::Row& row) {
    return std::ranges::any_of(row.cells, [](const CsvCell& cell) {
      return cell.text.find('.') != std::string_view::npos && parse_number(cell.text);
    });
  });
}

/// Numbers may have decimal commas: all or none of them. (Where commas separate, those stand in
/// quotes, and beside decimal points they may be text.)
void take_decimal_commas(CsvTable& table) {
  const CsvCell* point = nullptr;
  const CsvCell* comma = nullptr;
  for (CsvTable::Row& row : table.rows) {
    for (CsvCell& cell : row.cells) {
      const std::size_t at = cell.text.find(',');
      if (at == std::string_view::npos) {
        if (cell.text.find('.') != std::string_view::npos && parse_number(cell.text)) point = &cell;
      } else {
        std::string dotted(cell.text);
        dotted[at] = '.';
        if (!parse_number(dotted)) continue;
        comma = &cell;
        cell.text = table.unquoted.emplace_back(std::move(dotted));
      }
      if (point == nullptr || comma == nullptr) continue;
      throw InputError({.what = "numbers with a decimal point and with a comma: '1,234' has two "
                                "readings here",
                        .where = {.file = table.name, .line = row.line, .column = cell.column},
                        .expected = "one decimal mark in the whole file"});
    }
  }
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
                    .expected = std::to_string(n),
                    .hint = k < n ? ""
                                  : "where commas are decimal marks, columns are separated by "
                                    "semicolons or tabs"});
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

char stated_separator(std::string_view line) {
  std::string word(line.substr(0, line.find_last_not_of(" \r") + 1));
  if (word.size() > 2 && word.front() == '"' && word.back() == '"') {
    word = word.substr(1, word.size() - 2);
  }
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word.size() == 5 && word.starts_with("sep=") ? word.back() : '\0';
}

CsvTable parse_csv(std::string text, const std::string& name) {
  CsvTable table;
  table.name = name;
  table.text = std::make_unique<const std::string>(std::move(text));
  Scanner scanner(table);
  table.header = scanner.row();
  drop_empty_end(table.header, 1);
  check_header(table);
  int empty_line = 0;
  const std::size_t columns = table.header.cells.size();
  for (scanner.skip_comments(columns); !scanner.at_end(); scanner.skip_comments(columns)) {
    if (table.rows.size() == kMaxCsvRows) {
      throw InputError({.what = "more than " + std::to_string(kMaxCsvRows) + " rows",
                        .where = {.file = name},
                        .hint = "import it in parts"});
    }
    CsvTable::Row row = scanner.row();
    if (is_blank(row) && table.header.cells.size() > 1) {
      if (empty_line == 0) empty_line = row.line;
      continue;
    }
    if (empty_line > 0) {
      throw InputError({.what = "an empty line between others",
                        .where = {.file = name, .line = empty_line, .column = 1}});
    }
    drop_empty_end(row, table.header.cells.size());
    check_length(table, row);
    table.rows.push_back(std::move(row));
  }
  while (!table.rows.empty() && is_blank(table.rows.back())) table.rows.pop_back();
  if (scanner.separator() != ',' || !has_decimal_points(table)) take_decimal_commas(table);
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

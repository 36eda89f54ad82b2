#include "app/terminal/table.hpp"

#include <algorithm>
#include <numeric>

#include "app/files/numbers.hpp"
#include "app/terminal/text.hpp"

namespace trammel::terminal {

namespace {

constexpr std::size_t kBetween = 2;
constexpr std::size_t kLeastText = 8;  // a column of text is not made narrower than this

bool is_number(const std::string& text) { return text.empty() || parse_number(text).has_value(); }

struct Column {
  std::size_t width = 0;
  std::size_t least = 0;  // what the longest number and the header of numbers take
  bool numbers = true;
};

std::vector<Column> columns_of_table(const std::vector<std::vector<std::string>>& cells) {
  std::vector<Column> columns(cells.front().size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    Column& column = columns[k];
    column.numbers = cells.size() > 1;
    column.least = kLeastText;
    for (std::size_t r = 0; r < cells.size(); ++r) {
      column.width = std::max(column.width, columns_of(cells[r][k]));
      if (r == 0) continue;
      if (!is_number(cells[r][k]))
        column.numbers = false;
      else
        column.least = std::max(column.least, columns_of(cells[r][k]));
    }
    if (column.numbers) column.least = column.width;
  }
  return columns;
}

void narrow(std::vector<Column>& columns, std::size_t room) {
  const auto total = [&columns] {
    return std::accumulate(columns.begin(), columns.end(), kBetween * (columns.size() - 1),
                           [](std::size_t sum, const Column& c) { return sum + c.width; });
  };
  while (total() > room) {
    const auto spare = [](const Column& c) { return c.width > c.least ? c.width : 0; };
    const auto widest = std::ranges::max_element(columns, {}, spare);
    if (spare(*widest) == 0) return;  // the terminal is too narrow for the numbers alone
    --widest->width;
  }
}

}  // namespace

std::string Table::text(std::optional<std::size_t> room) const {
  std::vector<std::vector<std::string>> cells = rows_;
  for (auto& row : cells) {
    for (std::string& cell : row) cell = printable(cell);
  }
  std::vector<Column> columns = columns_of_table(cells);
  if (room) narrow(columns, *room);
  std::string out;
  for (const auto& row : cells) {
    std::string line;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::string cell = shortened(row[k], columns[k].width);
      const std::string blanks(columns[k].width - columns_of(cell), ' ');
      line += (k == 0 ? "" : "  ") + (columns[k].numbers ? blanks + cell : cell + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace trammel::terminal

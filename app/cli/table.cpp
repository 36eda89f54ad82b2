#include "app/cli/table.hpp"

#include <algorithm>

#include "app/cli/context.hpp"
#include "app/exchange/numbers.hpp"

namespace trammel::cli {

namespace {

// Characters, not bytes: continuation bytes of UTF-8 take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

bool is_number(const std::string& text) { return text.empty() || parse_number(text).has_value(); }

}  // namespace

std::string Table::text() const {
  std::string out;
  std::vector<std::vector<std::string>> cells = rows_;
  for (auto& row : cells) {
    for (std::string& cell : row) cell = printable(cell);
  }
  const std::size_t n = cells.front().size();
  std::vector<std::size_t> widths(n, 0);
  std::vector<bool> right(n, cells.size() > 1);
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (std::size_t k = 0; k < n; ++k) {
      widths[k] = std::max(widths[k], width(cells[r][k]));
      if (r > 0 && !is_number(cells[r][k])) right[k] = false;
    }
  }
  for (const auto& row : cells) {
    std::string line;
    for (std::size_t k = 0; k < n; ++k) {
      const std::string blanks(widths[k] - width(row[k]), ' ');
      line += (k == 0 ? "" : "  ") + (right[k] ? blanks + row[k] : row[k] + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace trammel::cli

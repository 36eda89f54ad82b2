#include "tests/support/csv.hpp"
#include "tests/support/paths.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace trammel::tests {

namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

}  // namespace

const std::string& Table::text(std::size_t row, const std::string& column) const {
  const auto at = std::find(columns.begin(), columns.end(), column);
  if (at == columns.end()) throw std::runtime_error("no column " + column);
  return rows.at(row).at(static_cast<std::size_t>(at - columns.begin()));
}

double Table::number(std::size_t row, const std::string& column) const {
  return std::stod(text(row, column));
}

Table read_table(const std::string& path) {
  std::ifstream in(tests::source_folder() + "/tests/" + path);
  if (!in) throw std::runtime_error("missing golden numbers: tests/" + path);
  Table table;
  std::string line;
  std::getline(in, line);
  table.columns = split(line);
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    table.rows.push_back(split(line));
    if (table.rows.back().size() != table.columns.size())
      throw std::runtime_error("ragged: " + path);
  }
  return table;
}

}  // namespace trammel::tests

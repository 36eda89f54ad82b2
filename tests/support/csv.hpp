#pragma once
// Golden numbers: comma-separated tables under tests/. A missing file fails the test.

#include <string>
#include <vector>

namespace trammel::tests {

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
};

/// `path` is relative to tests/. Throws std::runtime_error when it is missing or ragged.
Table read_table(const std::string& path);

}  // namespace trammel::tests

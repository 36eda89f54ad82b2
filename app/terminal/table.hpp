#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/terminal/columns.hpp"

namespace trammel::terminal {

/// A table of text with aligned columns, two blanks between; columns of numbers stand to the right.
/// Text is made safe for a terminal.
class Table {
 public:
  explicit Table(std::vector<std::string> header) : rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// Where a line is longer than `columns`, the widest columns of text are shortened, marked by …;
  /// numbers never are. Proof: columns_test.cpp.
  [[nodiscard]] std::string text(std::optional<std::size_t> columns = terminal_columns()) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace trammel::terminal

#pragma once

#include <string>
#include <vector>

namespace trammel::cli {

/// A table of text with aligned columns, two blanks between; columns of numbers stand to the right.
/// Text is made safe for a terminal.
class Table {
 public:
  explicit Table(std::vector<std::string> header) : rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace trammel::cli

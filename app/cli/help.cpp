#include "app/cli/help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "app/cli/command_tree.hpp"
#include "app/terminal/columns.hpp"

namespace trammel::cli {

namespace {

constexpr std::size_t kWidest = 100;
constexpr std::size_t kColumn = 30;
constexpr std::size_t kLeastText = 20;  // columns that a description needs to be read

std::size_t help_columns() { return std::min(terminal_columns().value_or(kWidest), kWidest); }

/// Words of `text` in lines of `columns`.
std::vector<std::string> lines_of(const std::string& text, std::size_t columns) {
  std::vector<std::string> lines;
  std::istringstream paragraphs(text);
  for (std::string paragraph; std::getline(paragraphs, paragraph);) {
    std::string line;
    std::istringstream words(paragraph);
    for (std::string word; words >> word;) {
      if (!line.empty() && columns_of(line) + 1 + columns_of(word) > columns) {
        lines.push_back(line);
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    lines.push_back(line);
  }
  return lines;
}

/// Where a terminal has no room for both, the description goes below the name.
std::string two_columns(const std::string& left, const std::string& right) {
  const std::size_t column = help_columns() < kColumn + kLeastText ? 4 : kColumn;
  std::string text = "  " + left;
  const std::string indent(column, ' ');
  bool beside = columns_of(text) + 2 <= column;
  for (const std::string& line : lines_of(right, help_columns() - column)) {
    text += beside ? std::string(column - std::min(column, columns_of(text)), ' ') + line
                   : "\n" + indent + line;
    beside = false;
  }
  return text + "\n";
}

}  // namespace

std::string option_help(Option option, bool as_argument) {
  const std::string more = option.takes_many() ? " ..." : "";
  const std::string value = value_name(option);
  if (as_argument) return two_columns(value + more, described(option));
  std::string values;
  for (int k = 0; k < std::max(option.expected_min(), 1) && !value.empty(); ++k) {
    values += " " + value;
  }
  return two_columns(option.all_names() + values + more, described(option));
}

std::string positional_usage(Option option) {
  const std::string name = value_name(option) + (option.takes_many() ? "..." : "");
  return option.is_required() ? name : "[" + name + "]";
}

std::string command_help(const std::string& name, const std::string& description) {
  return two_columns(name, description);
}

std::string description_help(const std::string& description) {
  return fmt::format("{}\n", fmt::join(lines_of(description, help_columns()), "\n"));
}

std::string footer_help(const std::string& footer) { return folded(footer, help_columns()); }

}  // namespace trammel::cli

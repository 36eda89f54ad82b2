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

std::string two_columns(const std::string& left, const std::string& right) {
  std::string text = "  " + left;
  const std::string indent(kColumn, ' ');
  bool beside = columns_of(text) + 2 <= kColumn;
  for (const std::string& line : lines_of(right, help_columns() - kColumn)) {
    text += beside ? std::string(kColumn - std::min(kColumn, columns_of(text)), ' ') + line
                   : "\n" + indent + line;
    beside = false;
  }
  return text + "\n";
}

class Help final : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    const std::string more =
        option->get_expected_max() >= CLI::detail::expected_max_vector_size ? " ..." : "";
    if (is_positional) return two_columns(value_name(*option) + more, described(*option));
    const std::string value = value_name(*option);
    std::string values;
    const int n = option->get_expected_min();
    for (int k = 0; k < std::max(n, 1) && !value.empty(); ++k) values += " " + value;
    return two_columns(option->get_name(false, true) + values + more, described(*option));
  }

  std::string make_option_usage(const CLI::Option* option) const override {
    const std::string more =
        option->get_expected_max() >= CLI::detail::expected_max_vector_size ? "..." : "";
    const std::string name = value_name(*option) + more;
    return option->get_required() ? name : "[" + name + "]";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return two_columns(command->get_name(), command->get_description());
  }

  std::string make_description(const CLI::App* app) const override {
    return fmt::format("{}\n", fmt::join(lines_of(app->get_description(), help_columns()), "\n"));
  }

  std::string make_footer(const CLI::App* app) const override {
    return folded(CLI::Formatter::make_footer(app), help_columns());
  }
};

}  // namespace

std::shared_ptr<CLI::Formatter> help_formatter() {
  auto help = std::make_shared<Help>();
  help->label("SUBCOMMAND", "COMMAND");
  help->label("Positionals", "Arguments");
  return help;
}

}  // namespace trammel::cli

#include "app/cli/command_tree.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace trammel::cli {

namespace {

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c == '_' ? '-' : c;
  });
  return text;
}

/// The type's name without what validators add: "TEXT:{a,b}".
std::string bare_type(Option option) {
  const std::string type = option.type_text();
  return type.substr(0, type.find(':'));
}

}  // namespace

std::vector<Command> visible_commands(Command app) {
  std::vector<Command> visible = app.commands();
  std::erase_if(visible, [](Command command) { return command.is_hidden(); });
  return visible;
}

std::optional<Command> find_command(Command app, const std::string& word) {
  for (const Command command : app.commands()) {
    if (command.name() == word) return command;
  }
  return std::nullopt;
}

Command chosen_command(Command app) {
  const auto below = app.chosen();
  return below ? chosen_command(*below) : app;
}

std::string full_name(Command app) {
  const auto parent = app.parent();
  return parent ? full_name(*parent) + " " + app.name() : app.name();
}

std::vector<Option> options_of(Command app) {
  std::vector<Option> options;
  for (std::optional<Command> at = app; at; at = at->parent()) {
    for (const Option option : at->options()) {
      const auto names = option.long_names();
      const bool new_name = std::ranges::none_of(
          options, [&names](Option known) { return known.long_names() == names; });
      if (!names.empty() && new_name) options.push_back(option);
    }
  }
  return options;
}

std::optional<Option> find_option(Command app, const std::string& word) {
  for (const Option option : options_of(app)) {
    if (option.has_name(word)) return option;
  }
  return std::nullopt;
}

std::vector<Option> positionals_of(Command app) {
  std::vector<Option> positionals = app.options();
  std::erase_if(positionals, [](Option option) { return !option.is_positional(); });
  return positionals;
}

std::string value_name(Option option) {
  if (option.expected_max() == 0) return "";
  const std::string type = bare_type(option);
  if (type == "FLOAT") return "NUMBER";
  if (type == "INT" || type == "UINT") return "N";
  if (!type.empty() && type != "TEXT") return type;
  return upper(option.is_positional() ? option.name() : option.long_names().front());
}

std::vector<std::string> choices_of(Option option) {
  const std::string type = option.type_text();
  const std::size_t open = type.find('{'), close = type.find('}');
  std::vector<std::string> choices;
  if (open == std::string::npos || close == std::string::npos) return choices;
  for (std::size_t at = open + 1; at < close;) {
    const std::size_t end = std::min(type.find(',', at), close);
    choices.push_back(type.substr(at, end - at));
    at = end + 1;
  }
  return choices;
}

std::string described(Option option) {
  std::string text = option.description();
  const auto add = [&text](const std::string& more) {
    text += (text.empty() ? "" : " ") + ("[" + more + "]");
  };
  const auto choices = choices_of(option);
  const bool told = std::ranges::all_of(choices, [&text](const std::string& choice) {
    return text.find(choice) != std::string::npos;
  });
  if (!told) add(fmt::format("{}", fmt::join(choices, ", ")));
  std::string standard = option.default_text();
  if (standard.starts_with('[') && standard.ends_with(']')) {
    standard = standard.substr(1, standard.size() - 2);
  }
  if (!standard.empty()) add("default " + standard);
  if (option.is_required() && !option.is_positional()) add("required");
  for (const Option other : option.needed()) add("with " + other.name());
  for (const Option other : option.excluded()) {
    add("without " + (other.is_positional() ? value_name(other) : other.name()));
  }
  return text;
}

bool looks_like_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9') && word[1] != '.';
}

}  // namespace trammel::cli

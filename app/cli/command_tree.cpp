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
std::string bare_type(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

}  // namespace

std::vector<const CLI::App*> visible_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); });
}

const CLI::App* find_command(const CLI::App& app, const std::string& word) {
  const auto named =
      app.get_subcommands([&word](const CLI::App* sub) { return sub->get_name() == word; });
  return named.empty() ? nullptr : named.front();
}

const CLI::App& chosen_command(const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app : chosen_command(*parsed.front());
}

std::string full_name(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : full_name(*parent) + " " + app.get_name();
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  std::vector<const CLI::Option*> options;
  for (const CLI::App* at = &app; at != nullptr; at = at->get_parent()) {
    for (const CLI::Option* option : at->get_options()) {
      const auto same = [option](const CLI::Option* known) {
        return known->get_lnames() == option->get_lnames();
      };
      const bool new_name = std::ranges::none_of(options, same);
      if (!option->get_lnames().empty() && new_name) options.push_back(option);
    }
  }
  return options;
}

const CLI::Option* find_option(const CLI::App& app, const std::string& word) {
  for (const CLI::Option* option : options_of(app)) {
    if (option->check_name(word)) return option;
  }
  return nullptr;
}

std::vector<const CLI::Option*> positionals_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

std::string value_name(const CLI::Option& option) {
  if (option.get_expected_max() == 0) return "";
  const std::string type = bare_type(option);
  if (type == "FLOAT") return "NUMBER";
  if (type == "INT" || type == "UINT") return "N";
  if (!type.empty() && type != "TEXT") return type;
  return upper(option.get_positional() ? option.get_name(true) : option.get_lnames().front());
}

std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
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

std::string described(const CLI::Option& option) {
  std::string text = option.get_description();
  const auto add = [&text](const std::string& more) {
    text += (text.empty() ? "" : " ") + ("[" + more + "]");
  };
  const auto choices = choices_of(option);
  const bool told = std::ranges::all_of(choices, [&text](const std::string& choice) {
    return text.find(choice) != std::string::npos;
  });
  if (!told) add(fmt::format("{}", fmt::join(choices, ", ")));
  std::string standard = option.get_default_str();
  if (standard.starts_with('[') && standard.ends_with(']')) {
    standard = standard.substr(1, standard.size() - 2);
  }
  if (!standard.empty()) add("default " + standard);
  if (option.get_required() && !option.get_positional()) add("required");
  for (const CLI::Option* other : option.get_needs()) add("with " + other->get_name());
  for (const CLI::Option* other : option.get_excludes()) {
    add("without " + (other->get_positional() ? value_name(*other) : other->get_name()));
  }
  return text;
}

bool looks_like_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9') && word[1] != '.';
}

}  // namespace trammel::cli

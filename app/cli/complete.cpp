#include "app/cli/complete.hpp"

#include <algorithm>

#include "app/cli/command_tree.hpp"

namespace trammel::cli {

namespace {

/// The words before the last, read as the program reads them.
struct Read {
  explicit Read(Command app) : at(app) {}
  Command at;
  std::optional<Option> pending;  // takes the next word
  int missing = 0;                // words that it takes yet
  std::size_t n_positionals = 0;
  bool only_positionals = false;  // behind "--"
  std::vector<Option> options;
  Given given;
};

std::optional<Option> positional(Command app, std::size_t number) {
  const auto all = positionals_of(app);
  return number < all.size() ? std::optional(all[number]) : std::nullopt;
}

void keep(Option option, const std::string& value, Given& given) {
  given[value_name(option)] = value;
  for (const std::string& name : option.long_names()) given["--" + name] = value;
}

void read_option(const std::string& word, Read& read) {
  const std::size_t equals = word.find('=');
  const auto option = find_option(read.at, word.substr(0, equals));
  if (!option) return;
  read.options.push_back(*option);
  if (equals != std::string::npos) {
    keep(*option, word.substr(equals + 1), read.given);
  } else if (option->expected_max() > 0) {
    read.pending = option;
    read.missing = std::max(1, option->expected_min());
  }
}

void read_word(const std::string& word, Read& read) {
  if (read.missing > 0) {
    keep(*read.pending, word, read.given);
    --read.missing;
  } else if (word == "--") {
    read.only_positionals = true;
  } else if (!read.only_positionals && looks_like_option(word)) {
    read_option(word, read);
  } else if (const auto command = find_command(read.at, word)) {
    read.at = *command;
  } else if (const auto option = positional(read.at, read.n_positionals)) {
    keep(*option, word, read.given);
    ++read.n_positionals;
  }
}

Candidates values_of(Option option, const Read& read, const Values& values) {
  Candidates found;
  for (const std::string& choice : choices_of(option)) found.words.push_back({choice, ""});
  return found.words.empty() ? values(value_name(option), read.given) : found;
}

Candidates options_now(const Read& read) {
  Candidates found;
  for (const Option option : options_of(read.at)) {
    const bool again = option.expected_max() > 1;
    const bool used = std::ranges::find(read.options, option) != read.options.end();
    if (option.is_hidden() || (used && !again)) continue;
    found.words.push_back({"--" + option.long_names().front(), option.description()});
  }
  return found;
}

Candidates commands_now(Command app) {
  Candidates found;
  for (const Command command : visible_commands(app)) {
    found.words.push_back({command.name(), command.description()});
  }
  return found;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Those that begin with `typed` and that a line can hold, behind `before` ("--order=").
Candidates fitting(Candidates all, const std::string& before, const std::string& typed) {
  Candidates found{.words = {}, .paths = all.paths};
  for (Candidate& candidate : all.words) {
    if (!candidate.word.starts_with(typed) || printable(candidate.word) != candidate.word) continue;
    found.words.push_back({before + candidate.word, printable(first_line(candidate.what))});
  }
  return found;
}

}  // namespace

Candidates candidates(Command app, const std::vector<std::string>& words, const Values& values) {
  Read read(app);
  for (std::size_t k = 0; k + 1 < words.size(); ++k) read_word(words[k], read);
  const std::string last = words.empty() ? "" : words.back();
  if (read.missing > 0) return fitting(values_of(*read.pending, read, values), "", last);
  if (!read.only_positionals && last.starts_with('-')) {
    const std::size_t equals = last.find('=');
    if (equals == std::string::npos) return fitting(options_now(read), "", last);
    const auto option = find_option(read.at, last.substr(0, equals));
    if (!option) return {};
    return fitting(values_of(*option, read, values), last.substr(0, equals + 1),
                   last.substr(equals + 1));
  }
  if (const Candidates verbs = commands_now(read.at); !verbs.words.empty()) {
    return fitting(verbs, "", last);
  }
  const auto option = positional(read.at, read.n_positionals);
  return !option ? Candidates{} : fitting(values_of(*option, read, values), "", last);
}

}  // namespace trammel::cli

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/cli/command_line.hpp"

namespace trammel::cli {

/// Edits (insert, delete, change, swap of neighbours) that turn `a` into `b`.
int edit_distance(const std::string& a, const std::string& b);

/// The nearest of `names` to `word`, all that tie; none when even the nearest is another word
/// (more than a third of the letters differ, one edit always allowed).
std::vector<std::string> nearest(const std::string& word, const std::vector<std::string>& names);

/// A word of the command line that names nothing, and what it may have been meant to be.
struct Unknown {
  std::string word;
  bool is_option = false;
  std::string command;  // the command it was given to: "trammel campaign"
  std::vector<std::string> suggestions;
  std::vector<std::string> known;
};

/// The first word that is no command or option of `app`, or none.
std::optional<Unknown> first_unknown(Command app, const std::vector<std::string>& words);

}  // namespace trammel::cli

#include "app/cli/suggest.hpp"

#include <set>

#include "app/cli/cli.hpp"
#include "app/cli/command_tree.hpp"
#include "app/cli/commands.hpp"
#include "tests/support/catch.hpp"

using namespace trammel::cli;

TEST_CASE("edit distance counts inserts, deletes, changes and swaps", "[cli]") {
  CHECK(edit_distance("report", "report") == 0);
  CHECK(edit_distance("report", "reprot") == 1);
  CHECK(edit_distance("report", "repot") == 1);
  CHECK(edit_distance("report", "rreport") == 1);
  CHECK(edit_distance("kitten", "sitting") == 3);
}

namespace {

/// Every word one edit away (delete, swap, change to 'x', insert 'x').
std::set<std::string> one_edit(const std::string& word) {
  std::set<std::string> words;
  for (std::size_t k = 0; k < word.size(); ++k) {
    words.insert(word.substr(0, k) + word.substr(k + 1));
    words.insert(word.substr(0, k) + "x" + word.substr(k + 1));
    words.insert(word.substr(0, k) + "x" + word.substr(k));
    if (k + 1 < word.size()) {
      std::string swapped = word;
      std::swap(swapped[k], swapped[k + 1]);
      words.insert(swapped);
    }
  }
  words.erase(word);
  return words;
}

}  // namespace

namespace {

using Words = std::vector<std::string>;

/// Words that lead to each command of the tree, the program itself first.
void walk(Command app, const Words& path, std::vector<std::pair<Words, Words>>& found) {
  Words names;
  for (const Command sub : visible_commands(app)) names.push_back(sub.name());
  for (std::optional<Command> at = app; at; at = at->parent()) {
    for (const Option option : at->options()) {
      for (const std::string& name : option.long_names()) names.push_back("--" + name);
    }
  }
  found.emplace_back(path, names);
  for (const Command sub : visible_commands(app)) {
    Words longer = path;
    longer.push_back(sub.name());
    walk(sub, longer, found);
  }
}

}  // namespace

TEST_CASE("a misspelling by one edit of any verb or option anywhere is answered by the right one",
          "[cli]") {
  Context context;
  CommandLine app;
  set_up(app, context, commands());
  std::vector<std::pair<Words, Words>> places;
  walk(app, {}, places);
  int right = 0, asked = 0;
  for (const auto& [path, names] : places) {
    for (const std::string& name : names) {
      for (const std::string& wrong : one_edit(name)) {
        // Without its dashes an option is a value; a verb with a dash in front is an option.
        if (wrong.starts_with("--") != name.starts_with("--")) continue;
        Words words = path;
        words.push_back(wrong);
        const auto unknown = first_unknown(app, words);
        if (!unknown) continue;  // it is another command, or a value
        ++asked;
        const auto& said = unknown->suggestions;
        right += std::find(said.begin(), said.end(), name) != said.end() ? 1 : 0;
      }
    }
  }
  CAPTURE(right, asked);
  REQUIRE(asked > 5000);
  CHECK(right >= 0.95 * asked);
}

TEST_CASE("a misspelling by one edit of any command is answered by the right one in 95 of 100",
          "[cli]") {
  Context context;
  CommandLine app;
  set_up(app, context, commands());
  int right = 0, asked = 0;
  std::vector<std::string> names;
  for (const Command sub : visible_commands(app)) names.push_back(sub.name());
  names.insert(names.end(), {"--json", "--db", "--version"});
  for (const std::string& name : names) {
    for (const std::string& wrong : one_edit(name)) {
      const auto unknown = first_unknown(app, {wrong});
      if (!unknown) continue;  // it is another command or a value
      ++asked;
      const auto& said = unknown->suggestions;
      right += std::find(said.begin(), said.end(), name) != said.end() ? 1 : 0;
    }
  }
  REQUIRE(asked > 0);
  CHECK(right >= 0.95 * asked);
}

#include "app/cli/suggest.hpp"

#include <set>

#include "app/cli/cli.hpp"
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

TEST_CASE("a misspelling by one edit of any command is answered by the right one in 95 of 100",
          "[cli]") {
  Context context;
  CLI::App app("", "trammel");
  set_up(app, context, commands());
  int right = 0, asked = 0;
  std::vector<std::string> names;
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* sub : app.get_subcommands(all)) names.push_back(sub->get_name());
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

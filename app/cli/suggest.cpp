#include "app/cli/suggest.hpp"

#include <algorithm>

#include "app/cli/command_tree.hpp"

namespace trammel::cli {

int edit_distance(const std::string& a, const std::string& b) {
  const std::size_t n = a.size(), m = b.size();
  std::vector<std::vector<int>> d(n + 1, std::vector<int>(m + 1));
  for (std::size_t i = 0; i <= n; ++i) d[i][0] = static_cast<int>(i);
  for (std::size_t j = 0; j <= m; ++j) d[0][j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= n; ++i) {
    for (std::size_t j = 1; j <= m; ++j) {
      const int change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[n][m];
}

std::vector<std::string> nearest(const std::string& word, const std::vector<std::string>& names) {
  int best = std::max(1, static_cast<int>(word.size()) / 3);
  std::vector<std::string> found;
  for (const std::string& name : names) {
    const int distance = edit_distance(word, name);
    if (distance > best) continue;
    if (distance < best) found.clear();
    best = distance;
    found.push_back(name);
  }
  return found;
}

namespace {

std::vector<std::string> command_names(Command app) {
  std::vector<std::string> names;
  for (const Command sub : visible_commands(app)) names.push_back(sub.name());
  return names;
}

std::vector<std::string> option_names(Command app) {
  std::vector<std::string> names;
  for (const Option option : options_of(app)) {
    for (const std::string& name : option.long_names()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

std::optional<Unknown> first_unknown(Command app, const std::vector<std::string>& words) {
  Command at = app;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (words[k] == "--") return std::nullopt;
    if (looks_like_option(words[k])) {
      const std::string name = words[k].substr(0, words[k].find('='));
      const auto option = find_option(at, name);
      if (!option) {
        const std::vector<std::string> known = option_names(at);
        return Unknown{name, true, full_name(at), nearest(name, known), known};
      }
      const bool takes_next = option->expected_min() > 0 && name == words[k];
      if (takes_next) k += static_cast<std::size_t>(option->expected_min());
      continue;
    }
    const std::vector<std::string> names = command_names(at);
    if (names.empty()) continue;  // a value of the command
    const auto sub = find_command(at, words[k]);
    if (!sub) {
      std::vector<std::string> near = nearest(words[k], names);
      if (near.empty()) near = nearest(words[k], option_names(at));
      return Unknown{words[k], false, full_name(at), near, names};
    }
    at = *sub;
  }
  return std::nullopt;
}

}  // namespace trammel::cli

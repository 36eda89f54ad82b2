#include "app/terminal/typable.hpp"

#include <vector>

namespace trammel::terminal {

namespace {

/// Words of a line as a shell sees them, quotes kept.
std::vector<std::string> quoted_words(std::string_view line) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (const char c : line) {
    quoted = quoted != (c == '\'');
    if (c == ' ' && !quoted) {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

bool is_option(const std::string& word) { return word.starts_with("--"); }
bool is_dashed(const std::string& word) { return word.starts_with("'-"); }

}  // namespace

std::string typable(std::string_view line) {
  const std::vector<std::string> words = quoted_words(line);
  std::string head, tail;
  bool ended = false;  // behind the first value that begins with '-'
  for (std::size_t k = 0; k < words.size(); ++k) {
    const bool has_value = is_option(words[k]) && k + 1 < words.size() && !is_option(words[k + 1]);
    if (has_value && is_dashed(words[k + 1])) {
      head += " " + words[k] + "=" + words[k + 1];
      ++k;
    } else if (is_option(words[k])) {
      head += " " + words[k];
      if (has_value && ended) head += " " + words[++k];
    } else {
      ended = ended || is_dashed(words[k]);
      (ended ? tail : head) += " " + words[k];
    }
  }
  return (head + (tail.empty() ? "" : " --" + tail)).substr(1);
}

}  // namespace trammel::terminal

#include "app/terminal/columns.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace trammel::terminal {

namespace {

constexpr std::size_t kFoldIndent = 4;
constexpr std::size_t kLeastTerminal = 20;  // what claims to be narrower is no terminal to fit

bool begins_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

std::string folded_line(std::string_view line, std::size_t columns) {
  const std::size_t begins = std::min(line.find_first_not_of(' '), line.size());
  const std::string indent(std::min(begins + kFoldIndent, columns / 4), ' ');
  std::string out;
  std::size_t used = 0;
  while (!line.empty()) {  // a word with the blanks before it
    const std::size_t word = line.find_first_not_of(' ');
    if (word == std::string_view::npos) break;
    const std::size_t end = std::min(line.find(' ', word), line.size());
    const std::size_t wide = columns_of(line.substr(0, end));
    if (!out.empty() && used + wide > columns) {
      out.append("\n").append(indent).append(line.substr(word, end - word));
      used = indent.size() + wide - word;
    } else {
      out.append(line.substr(0, end));
      used += wide;
    }
    line.remove_prefix(end);
  }
  return out;
}

}  // namespace

std::size_t columns_of(std::string_view text) {
  std::size_t n = 0;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] == '\x1b') {
      k = std::min(text.find('m', k), text.size() - 1);
    } else if (begins_character(text[k])) {
      ++n;
    }
  }
  return n;
}

std::optional<std::size_t> terminal_columns(int descriptor) {
  winsize size{};
  if (isatty(descriptor) != 1 || ioctl(descriptor, TIOCGWINSZ, &size) != 0) return {};
  if (size.ws_col < kLeastTerminal) return {};
  return size.ws_col;
}

std::string shortened(const std::string& text, std::size_t columns) {
  if (columns_of(text) <= columns) return text;
  std::string out;
  std::size_t n = 0;
  for (const char byte : text) {
    if (begins_character(byte) && ++n >= columns) break;
    out += byte;
  }
  return out + (utf8_wanted() ? "…" : "~");
}

std::string folded(std::string_view text, std::size_t columns) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    out += columns_of(line) <= columns ? std::string(line) : folded_line(line, columns);
    if (end < text.size()) out += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

bool utf8_wanted() {
  if (environment("TERM") == "dumb") return false;
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {  // the first that is set decides
    std::string locale(environment(name));
    if (locale.empty()) continue;
    std::ranges::transform(locale, locale.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return locale.find("utf-8") != std::string::npos || locale.find("utf8") != std::string::npos;
  }
  return false;
}

}  // namespace trammel::terminal

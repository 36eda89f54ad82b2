#include "app/terminal/lines.hpp"

#include <algorithm>
#include <sstream>

#include "app/terminal/columns.hpp"

namespace trammel::terminal {

namespace {

constexpr std::size_t kWidth = 100;  // a line of prose that is still read with ease

std::size_t width() { return std::min(terminal_columns().value_or(kWidth), kWidth); }

}  // namespace

std::string heading(const std::string& text) {
  return "\n" + text + "\n" + std::string(std::min(columns_of(text), width()), '-') + "\n";
}

std::string wrapped(const std::string& text, const std::string& indent, bool keep) {
  const std::size_t columns = width();
  std::string out, line;
  std::istringstream words(text);
  std::string before = keep ? text.substr(0, text.find_first_not_of(' ')) : "";
  for (std::string word; words >> word;) {
    if (line.empty()) {
      line = before + word;
    } else if (line.size() + 1 + word.size() > columns) {
      out += line + "\n";
      line = indent + word;
    } else {
      line += " " + word;
    }
  }
  return out + line + "\n";
}

}  // namespace trammel::terminal

#include "app/terminal/lines.hpp"

#include <sstream>

namespace trammel::terminal {

std::string heading(const std::string& text) {
  return "\n" + text + "\n" + std::string(text.size(), '-') + "\n";
}

std::string wrapped(const std::string& text, const std::string& indent, bool keep) {
  constexpr std::size_t kWidth = 100;
  std::string out, line;
  std::istringstream words(text);
  std::string before = keep ? text.substr(0, text.find_first_not_of(' ')) : "";
  for (std::string word; words >> word;) {
    if (line.empty()) {
      line = before + word;
    } else if (line.size() + 1 + word.size() > kWidth) {
      out += line + "\n";
      line = indent + word;
    } else {
      line += " " + word;
    }
  }
  return out + line + "\n";
}

}  // namespace trammel::terminal

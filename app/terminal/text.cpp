#include "app/terminal/text.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace trammel::terminal {

bool colour(int descriptor) {
  const char* no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  return isatty(descriptor) == 1;
}

std::string bold(std::string_view text) {
  if (!colour(STDOUT_FILENO)) return std::string(text);
  return "\x1b[1m" + std::string(text) + "\x1b[0m";
}

namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 1;
  bool valid = false;  // UTF-8, in its shortest form
};

Character character_at(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[at + k]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t n = lead >= 0xC2 && lead < 0xE0   ? 2
                        : lead >= 0xE0 && lead < 0xF0 ? 3
                        : lead >= 0xF0 && lead < 0xF5 ? 4
                                                      : 0;
  if (n == 0 || at + n > text.size()) return {};
  char32_t code = lead & (0x7FU >> n);
  for (std::size_t k = 1; k < n; ++k) {
    if ((byte(k) & 0xC0U) != 0x80) return {};
    code = code << 6 | (byte(k) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kLeast[n] || code > 0x10FFFF || surrogate) return {};
  return {code, n, true};
}

bool acts(char32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x061C || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

}  // namespace

std::string printable(std::string_view text, std::string_view kept) {
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    const Character c = character_at(text, k);
    const bool keep = kept.find(text[k]) != std::string_view::npos;
    out += keep || (c.valid && !acts(c.code)) ? text.substr(k, c.bytes) : std::string_view("?");
    k += c.bytes;
  }
  return out;
}

std::string printable_json(std::string_view json) {
  std::string out;
  for (std::size_t k = 0; k < json.size();) {
    const Character c = character_at(json, k);
    if (c.valid && c.code >= 0x7F && acts(c.code)) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c.code));
    } else {
      out += json.substr(k, c.bytes);
    }
    k += c.bytes;
  }
  return out;
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:@%+=,";
  if (!text.empty() && text[0] != '-' && text.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(text);
  }
  std::string quoted = "'";
  for (const char c : printable(text))
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace trammel::terminal

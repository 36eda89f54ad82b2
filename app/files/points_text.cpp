#include "app/files/points_text.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "app/files/csv.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

constexpr std::size_t kMaxLineBytes = 20'000;
constexpr std::string_view kBlanks = " \t";

/// Characters 0x80 to 0x9F of code page 1252; the five it leaves open become U+FFFD.
constexpr std::array<std::uint16_t, 32> kHigh1252 = {
    0x20AC, 0xFFFD, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0xFFFD, 0x017D, 0xFFFD, 0xFFFD, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0xFFFD, 0x017E, 0x0178};

void append_utf8(std::string& out, unsigned code) {
  const auto low = [](unsigned bits) { return static_cast<char>(0x80 | (bits & 0x3F)); };
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += {static_cast<char>(0xC0 | (code >> 6)), low(code)};
  } else {
    out += {static_cast<char>(0xE0 | (code >> 12)), low(code >> 6), low(code)};
  }
}

std::string_view trimmed(std::string_view text) {
  const std::size_t from = text.find_first_not_of(kBlanks);
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(kBlanks) - from + 1);
}

std::size_t comment_sign(std::string_view text) {
  if (text.starts_with("//")) return 2;
  return text.starts_with('#') || text.starts_with('%') ? 1 : 0;
}

}  // namespace

std::string from_code_page_1252(std::string_view bytes) {
  std::string out;
  out.reserve(bytes.size() + bytes.size() / 8);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(out, byte >= 0x80 && byte < 0xA0 ? kHigh1252[byte - 0x80u] : byte);
  }
  return out;
}

bool is_utf8(std::string_view bytes) {
  for (std::size_t k = 0; k < bytes.size();) {
    const auto lead = static_cast<unsigned char>(bytes[k]);
    const std::size_t length = lead < 0x80                    ? 1
                               : lead >= 0xC2 && lead <= 0xDF ? 2
                               : lead >= 0xE0 && lead <= 0xEF ? 3
                               : lead >= 0xF0 && lead <= 0xF4 ? 4
                                                              : 0;
    if (length == 0 || k + length > bytes.size()) return false;
    for (std::size_t j = 1; j < length; ++j) {
      if ((static_cast<unsigned char>(bytes[k + j]) & 0xC0) != 0x80) return false;
    }
    k += length;
  }
  return true;
}

PointsText points_text(std::string bytes, const std::string& name) {
  PointsText text;
  if (bytes.find('\0') != std::string::npos) {
    throw InputError({.what = "the file holds NUL bytes: is it UTF-16, or no text?",
                      .where = {.file = name},
                      .expected = "text in UTF-8 or code page 1252"});
  }
  text.code_page_1252 = !is_utf8(bytes);
  if (text.code_page_1252) bytes = from_code_page_1252(bytes);
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  int number = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    std::string_view line(bytes.data() + at, end - at);
    if (line.ends_with('\r')) line.remove_suffix(1);
    at = end + 1;
    ++number;
    if (line.size() > kMaxLineBytes) {
      throw InputError({.what = "a line of more than " + std::to_string(kMaxLineBytes) + " bytes",
                        .where = {.file = name, .line = number}});
    }
    const std::string_view content = trimmed(line);
    if (content.empty() || (number == 1 && stated_separator(content) != '\0')) continue;
    if (const std::size_t sign = comment_sign(content); sign > 0) {
      text.comments.emplace_back(trimmed(content.substr(sign)));
    } else {
      text.lines.push_back({number, std::string(line)});
    }
  }
  return text;
}

std::vector<PointsCell> points_cells(std::string_view line, char delimiter) {
  std::vector<PointsCell> cells;
  const std::string_view ends = delimiter == ' ' ? kBlanks : std::string_view(&delimiter, 1);
  for (std::size_t at = 0; at <= line.size();) {
    if (delimiter == ' ') at = std::min(line.find_first_not_of(kBlanks, at), line.size());
    std::size_t end = std::min(line.find_first_of(ends, at), line.size());
    const std::size_t quote = line.find_first_not_of(kBlanks, at);
    const bool quoted = delimiter != ' ' && quote < line.size() && line[quote] == '"';
    const std::size_t close = quoted ? line.find('"', quote + 1) : std::string_view::npos;
    if (close != std::string_view::npos) {
      end = std::min(line.find_first_of(ends, close), line.size());
    }
    std::string_view text = trimmed(line.substr(at, end - at));
    if (text.size() > 1 && close != std::string_view::npos && text.ends_with('"')) {
      text = text.substr(1, text.size() - 2);
    }
    const auto offset = text.empty() ? at : static_cast<std::size_t>(text.data() - line.data());
    cells.push_back({text, static_cast<int>(offset) + 1});
    at = end + 1;
  }
  while (!cells.empty() && cells.back().text.empty()) cells.pop_back();
  return cells;
}

std::string single_blanks(std::string_view text) {
  std::string out;
  for (const PointsCell& word : points_cells(text, ' ')) {
    out += (out.empty() ? "" : " ") + std::string(word.text);
  }
  return out;
}

}  // namespace trammel

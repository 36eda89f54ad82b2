#pragma once
// The text of a points file before anybody knows its format: encoding, lines, cells.

#include <string>
#include <string_view>
#include <vector>

namespace trammel {

struct PointsLine {
  int number = 0;    // from 1
  std::string text;  // UTF-8, without its end
};

struct PointsText {
  std::vector<PointsLine> lines;      // neither blank nor comment
  std::vector<std::string> comments;  // after their sign
  bool code_page_1252 = false;
};

/// Splits into lines. Throws InputError for a NUL byte (UTF-16 has many) and for overlong lines.
PointsText points_text(std::string bytes, const std::string& name);

struct PointsCell {
  std::string_view text;  // without blanks around it
  int column = 0;         // from 1, in bytes
};

/// The cells of a line, without empty ones at its end. ' ' parts at runs of blanks and tabs.
std::vector<PointsCell> points_cells(std::string_view line, char delimiter);

/// Runs of blanks as one, none at the ends.
std::string single_blanks(std::string_view text);

/// `bytes` as UTF-8 when they are not: each byte a character of code page 1252.
std::string from_code_page_1252(std::string_view bytes);
bool is_utf8(std::string_view bytes);

}  // namespace trammel

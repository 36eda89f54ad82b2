#include "core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace trammel {

Error::Error(ExitCode code, ErrorText text)
    : std::runtime_error(describe(text)), code_(code), text_(std::move(text)) {}

std::string describe(const ErrorText& text) {
  const Where& at = text.where;
  std::string line = at.file;
  if (at.line > 0) line.append(":").append(std::to_string(at.line));
  if (at.column > 0) line.append(":").append(std::to_string(at.column));
  if (!line.empty()) line += ": ";
  line += text.what;
  if (!at.field.empty() && !at.point.empty()) {
    line += " (" + at.field + ", " + at.point + ")";
  } else if (!at.field.empty() || !at.point.empty()) {
    line += " (" + at.field + at.point + ")";
  }
  if (!text.got.empty()) line += ": got " + text.got;
  if (!text.expected.empty())
    line += (text.got.empty() ? ": expected " : ", expected ") + text.expected;
  if (!text.hint.empty()) line += "; " + text.hint;
  return line;
}

void assertion_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "trammel: broken promise at %s:%d: %s\n", file, line, condition);
  std::abort();
}

}  // namespace trammel

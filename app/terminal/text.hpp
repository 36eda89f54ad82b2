#pragma once
// Text that is safe and plain to read where it is shown.

#include <string>
#include <string_view>

namespace trammel::terminal {

/// stdout (1) or stderr (2) is a terminal, and NO_COLOR is not set.
bool colour(int descriptor);

/// `text` bold when stdout is a terminal that may be coloured.
std::string bold(std::string_view text);

/// Text from a file or a device, safe on a terminal and on a page: what would act on them becomes
/// '?', but for the characters in `kept`. That is control characters (C0, DEL and C1, as U+009B),
/// those that turn round the text beside them (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to
/// U+2069), line and paragraph separators, and each byte that is no UTF-8, which a terminal of
/// eight bits takes for one of them. Proof: text_test.cpp.
std::string printable(std::string_view text, std::string_view kept = "");

/// A text of JSON with the same characters beyond ASCII, and DEL, as \u escapes: nothing is lost.
std::string printable_json(std::string_view json);

/// `text` as one word of a shell: quoted when it must be, or begins with '-'.
std::string shell_word(std::string_view text);

}  // namespace trammel::terminal

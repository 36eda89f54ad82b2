#pragma once
// How much room text takes on a terminal, and how it is made to fit.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace trammel::terminal {

/// Columns of `text`: characters, not bytes, less the escape sequences of bold().
std::size_t columns_of(std::string_view text);

/// Columns of the terminal on stdout (1) or stderr (2); none where that is a file or a pipe.
std::optional<std::size_t> terminal_columns(int descriptor = 1);

/// `text` in at most `columns`; what is left out is marked by … at the end (~ without UTF-8).
std::string shortened(const std::string& text, std::size_t columns);

/// Lines longer than `columns` go on in the next one, four blanks to the right of where they began.
/// Broken at blanks alone: no number and no word is cut. Proof: columns_test.cpp.
std::string folded(std::string_view text, std::size_t columns);

/// The locale has UTF-8 and the terminal is not dumb: blocks and shades can be shown.
bool utf8_wanted();

}  // namespace trammel::terminal

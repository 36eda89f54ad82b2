#pragma once
// Text that is safe and plain to read where it is shown.

#include <string>
#include <string_view>

namespace trammel::terminal {

/// stdout (1) or stderr (2) is a terminal, and NO_COLOR is not set.
bool colour(int descriptor);

/// `text` bold when stdout is a terminal that may be coloured.
std::string bold(std::string_view text);

/// Text from a file or a device, safe on a terminal: control characters become '?'.
std::string printable(std::string_view text);

/// `text` as one word of a shell: quoted when it must be, or begins with '-'.
std::string shell_word(std::string_view text);

}  // namespace trammel::terminal

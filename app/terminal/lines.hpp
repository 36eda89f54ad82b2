#pragma once

#include <string>

namespace trammel::terminal {

/// The text on a line of its own, underlined.
std::string heading(const std::string& text);

/// Broken at blanks so that no line is wider than a terminal; further lines begin with `indent`.
/// `keep`: blanks at the beginning of the text stay.
std::string wrapped(const std::string& text, const std::string& indent = "", bool keep = false);

}  // namespace trammel::terminal

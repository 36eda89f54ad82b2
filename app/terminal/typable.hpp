#pragma once

#include <string>
#include <string_view>

namespace trammel::terminal {

/// A command line made of shell_words (text.hpp) such that values which begin with '-' are taken
/// for values: of an option behind '=', others behind "--", with what follows them.
/// Proof: text_test.cpp.
std::string typable(std::string_view line);

}  // namespace trammel::terminal

#pragma once
// Where the tests find the tree and what was built. Told to one file, so that every other object is
// the same wherever the tree lies.

#include <string>

namespace trammel::tests {

std::string source_folder();
std::string build_folder();

}  // namespace trammel::tests

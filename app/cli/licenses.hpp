#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// Something of others that is part of this program, with the terms that go with it.
struct Library {
  std::string name;
  std::string version;
  std::string_view terms;
};

/// What is linked: the C++ libraries with the terms of their Debian packages (licenses.cmake), and
/// what the report's page is bundled with. Proof: licenses_test.cpp, against the build itself.
std::vector<Library> libraries();

/// The fields of trammel/version/1.
Json version_json();

/// `licenses`: the terms of this program and of all that is part of it.
void setup_licenses(Command app, Context& context);

}  // namespace trammel::cli

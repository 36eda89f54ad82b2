// What ships ends at an overrun: read from the programs and the libraries as they were built.

#include <fmt/format.h>

#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using namespace trammel;

namespace {

std::string read_elf(const std::string& what, const std::string& file) {
  const tests::Finished finished = tests::run_command({"readelf", what, "-W", file}, "/");
  REQUIRE(finished.exit_code == 0);
  return finished.out;
}

/// The linker's tables are read-only before main() runs.
bool has_full_relro(const std::string& file) {
  return read_elf("-l", file).find("GNU_RELRO") != std::string::npos &&
         read_elf("-d", file).find("NOW") != std::string::npos;
}
/// A function with a buffer looks at a guard before it returns.
bool guards_stacks(const std::string& file) {
  return read_elf("-s", file).find("__stack_chk_fail") != std::string::npos;
}
/// Calls such as memcpy are told how much room there is.
bool checks_buffers(const std::string& file) {
  const std::string symbols = read_elf("-s", file);
  for (const char* call : {"__memcpy_chk", "__memmove_chk", "__read_chk", "__readlink_chk",
                           "__snprintf_chk", "__strcpy_chk"}) {
    if (symbols.find(call) != std::string::npos) return true;
  }
  return false;
}
/// operator[] of a container looks at its bounds.
bool checks_containers(const std::string& file) {
  return read_elf("-s", file).find("__glibcxx_assert_fail") != std::string::npos;
}

}  // namespace

TEST_CASE("what ships is hardened, and so is each library of ours it is made of",
          "[cli][release]") {
  const std::string built = tests::build_folder() + "/";
  for (const char* program : {"trammel", "trammel-archive"}) {
    CAPTURE(program);
    CHECK(has_full_relro(built + program));
    CHECK(guards_stacks(built + program));
    CHECK(checks_buffers(built + program));
    CHECK(checks_containers(built + program));
  }
  // the programs hold libraries of others too, which are hardened by themselves
  for (const char* folder : {"core", "store", "app"}) {
    CAPTURE(folder);
    const std::string library = fmt::format("{}{}/libtrammel_{}.a", built, folder, folder);
    CHECK(guards_stacks(library));
    CHECK(checks_containers(library));
  }
  CHECK(checks_buffers(built + "app/libtrammel_app.a"));
}

TEST_CASE("a program that is compiled without all this is seen to lack it", "[cli][release]") {
  const tests::TemporaryFolder folder;
  folder.write("bare.cpp",
               "#include <cstring>\n#include <vector>\n"
               "int main(int n, char** words) {\n"
               "  char text[8];\n  std::strcpy(text, words[0]);\n"
               "  return std::vector<int>(4)[static_cast<unsigned>(n)] + text[0];\n}\n");
  const auto compiled = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"c++", "-O2"});
    options.insert(options.end(), {"bare.cpp", "-o", "bare"});
    REQUIRE(tests::run_command(options, folder.path()).exit_code == 0);
    const std::string file = (folder.path() / "bare").string();
    return std::vector<bool>{has_full_relro(file), guards_stacks(file), checks_buffers(file),
                             checks_containers(file)};
  };
  CHECK(compiled({"-fno-stack-protector", "-U_FORTIFY_SOURCE", "-Wl,-z,norelro,-z,lazy"}) ==
        std::vector<bool>{false, false, false, false});
  CHECK(compiled({"-fstack-protector-strong", "-D_FORTIFY_SOURCE=2", "-D_GLIBCXX_ASSERTIONS",
                  "-Wl,-z,relro,-z,now"}) == std::vector<bool>{true, true, true, true});
}

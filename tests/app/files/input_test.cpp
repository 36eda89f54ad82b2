// Files that are read, and what is no file.

#include <sys/stat.h>

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "app/files/files.hpp"
#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::TemporaryFolder;

namespace {

std::filesystem::path pipe_in(const TemporaryFolder& folder) {
  const auto path = folder.path() / "pipe";
  REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
  return path;
}

}  // namespace

TEST_CASE("a pipe is read to its end, whenever its writer comes", "[files]") {
  const TemporaryFolder folder;
  const auto pipe = pipe_in(folder);
  const std::string text(200'000, 'x');  // more than a pipe holds
  std::jthread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::ofstream(pipe) << text;
  });
  CHECK(read_file(pipe, 1'000'000) == text);
  std::jthread another([&] { std::ofstream{pipe}; });  // and says nothing
  CHECK(read_file(pipe, 1'000'000).empty());
}

TEST_CASE("a pipe that nobody writes into is refused", "[files]") {
  const TemporaryFolder folder;
  const auto pipe = pipe_in(folder);
  const auto begun = std::chrono::steady_clock::now();
  const auto finished = tests::run_program({"plan", "check", pipe.string(), "--mechanism",
                                            tests::source_folder() + "/examples/paper/robot.json"},
                                           folder.path());
  CHECK(finished.exit_code == 4);
  CHECK_THAT(finished.err, Contains("nothing comes out of this pipe"));
  CHECK(std::chrono::steady_clock::now() - begun < std::chrono::seconds(10));
  const auto opened =
      tests::run_program({"campaign", "list", "--db", pipe.string()}, folder.path());
  CHECK(opened.exit_code == 8);
  CHECK_THAT(opened.err, Contains("a device or a pipe"));
}

TEST_CASE("a file is read to its bound and no further", "[files]") {
  const TemporaryFolder folder;
  const auto file = folder.write("f", std::string(100'000, 'y'));
  CHECK(read_file(file, 100'000).size() == 100'000);
  CHECK_THROWS_WITH(read_file(file, 99'999), Contains("too large"));
  CHECK_THROWS_WITH(read_file("/dev/zero", 99'999), Contains("too large"));
  CHECK(read_file("/dev/null", 1).empty());
  CHECK_THROWS_AS(read_file(folder.path(), 1), InputError);
  CHECK_THROWS_AS(read_file(folder.path() / "none", 1), NotFoundError);
}

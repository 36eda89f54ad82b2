#include <sys/stat.h>
#include <unistd.h>

#include <thread>

#include "app/files/files.hpp"
#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::read_text;

namespace {

constexpr const char* kPlan = R"({"schema": "trammel/plan/1", "name": "a"})";
constexpr const char* kOtherPlan = R"({"schema": "trammel/plan/1", "name": "b"})";

mode_t mode_of(const std::filesystem::path& path) {
  struct stat is = {};
  REQUIRE(::stat(path.c_str(), &is) == 0);
  return is.st_mode & 07777;
}

}  // namespace

TEST_CASE("an existing file is replaced only when asked to, by a file of its own format",
          "[files]") {
  const tests::TemporaryFolder folder;
  const auto path = folder.path() / "plan.json";
  write_output(path, kPlan, Existing::refuse);
  CHECK_THROWS_WITH(write_output(path, kOtherPlan, Existing::refuse), Contains("--overwrite"));
  CHECK(read_text(path) == kPlan);
  write_output(path, kOtherPlan, Existing::replace);
  CHECK(read_text(path) == kOtherPlan);
  for (const char* other : {"<!doctype html>", "a,b\n1,2\n", R"({"schema": "trammel/model/1"})",
                            R"({"format": "robot/1"})"}) {
    CAPTURE(other);
    CHECK_THROWS_AS(write_output(path, other, Existing::replace), InputError);
    CHECK(read_text(path) == kOtherPlan);
  }
  folder.write("empty.json", "");
  write_output(folder.path() / "empty.json", kPlan, Existing::replace);
  CHECK_THROWS_AS(write_output("", kPlan, Existing::replace), InputError);
  CHECK_THROWS_AS(write_output(folder.path(), kPlan, Existing::replace), InputError);
  int n_files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    CHECK(entry.path().extension() == ".json");  // nothing half-written is left beside them
    ++n_files;
  }
  CHECK(n_files == 2);
}

TEST_CASE("a database and its journals are never replaced, whatever is asked", "[files]") {
  const tests::TemporaryFolder folder;
  const std::string database = "SQLite format 3" + std::string(1, '\0') + std::string(84, 'x');
  const auto path = folder.write("lab.db", database);
  const auto wal = folder.write("lab.db-wal", "frames");
  for (const Existing existing : {Existing::refuse, Existing::replace}) {
    CHECK_THROWS_WITH(write_output(path, "<!doctype html>", existing), Contains("database"));
    CHECK_THROWS_WITH(write_output(wal, "<!doctype html>", existing), Contains("database"));
  }
  CHECK(read_text(path) == database);
  CHECK(read_text(wal) == "frames");
}

TEST_CASE("the umask holds, a replaced file keeps its mode, a link stays a link", "[files]") {
  const tests::TemporaryFolder folder;
  const mode_t before = ::umask(0077);
  write_output(folder.path() / "private.json", kPlan, Existing::refuse);
  ::umask(before);
  CHECK(mode_of(folder.path() / "private.json") == 0600);
  const auto path = folder.write("real.json", kPlan);
  ::chmod(path.c_str(), 0640);
  const auto link = folder.path() / "link.json";
  std::filesystem::create_symlink(path, link);
  CHECK_THROWS_AS(write_output(link, kOtherPlan, Existing::refuse), InputError);
  write_output(link, kOtherPlan, Existing::replace);
  CHECK(std::filesystem::is_symlink(link));
  CHECK(read_text(path) == kOtherPlan);
  CHECK(mode_of(path) == 0640);
}

TEST_CASE("a device and a pipe are written through and stay what they are", "[files]") {
  write_output("/dev/null", kPlan, Existing::refuse);
  CHECK(std::filesystem::is_character_file("/dev/null"));
  const tests::TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  std::string read;
  std::thread reader([&] { read = read_text(pipe); });
  write_output(pipe, kPlan, Existing::refuse);
  reader.join();
  CHECK(read == kPlan);
  CHECK(std::filesystem::is_fifo(pipe));
}

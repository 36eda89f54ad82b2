// A database that is moved, removed or replaced while it is written.

#include "store/place.hpp"

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "store/transaction.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::TempFolder;
namespace fs = std::filesystem;

namespace {

int n_campaigns(const fs::path& file) {
  Connection db = store::open(file, Access::read_only);
  return static_cast<int>(list_campaigns(db).size());
}

}  // namespace

TEST_CASE("a database that is no longer where it was opened is noticed, and keeps its data",
          "[store]") {
  struct Deed {
    const char* name;
    std::function<void(const fs::path& lab, const TempFolder&)> done;
    const char* says;        // "": it is still the one that was opened
    const char* data_is_in;  // afterwards
  };
  const std::vector<Deed> deeds = {
      {"nothing", [](auto&, auto&) {}, "", "lab.db"},
      {"another name beside it",
       [](auto& lab, auto& in) { fs::create_hard_link(lab, in.file("link.db")); }, "", "lab.db"},
      {"a copy", [](auto& lab, auto& in) { fs::copy_file(lab, in.file("copy.db")); }, "", "lab.db"},
      {"renamed", [](auto& lab, auto& in) { fs::rename(lab, in.file("moved.db")); },
       "lab.db is not there", "moved.db"},
      {"removed, its other name left",
       [](auto& lab, auto& in) {
         fs::create_hard_link(lab, in.file("left.db"));
         fs::remove(lab);
       },
       "lab.db is not there", "left.db"},
      {"another laboratory in its place",
       [](auto& lab, auto& in) {
         fs::create_hard_link(lab, in.file("left.db"));
         fs::rename(in.file("other.db"), lab);
       },
       "lab.db is another file", "left.db"},
      {"its log removed", [](auto& lab, auto&) { fs::remove(lab.string() + "-wal"); },
       "lab.db-wal is not there", "lab.db"},
      {"its log's index replaced",
       [](auto& lab, auto& in) {
         fs::copy_file(lab.string() + "-shm", in.file("shm"));
         fs::rename(in.file("shm"), lab.string() + "-shm");
       },
       "lab.db-shm is another file", "lab.db"},
  };
  for (const bool by_link : {false, true}) {
    for (const Deed& deed : deeds) {
      CAPTURE(deed.name, by_link);
      const TempFolder folder;
      { store::open(folder.file("other.db"), Access::create); }
      {
        Connection other = store::open(folder.file("other.db"), Access::write);
        add_campaign(other, test::small_campaign(1, "theirs"));
        add_campaign(other, test::small_campaign(1, "theirs too"));
        add_campaign(other, test::small_campaign(1, "and this"));
      }
      const fs::path lab = folder.file("lab.db");
      fs::path name = lab;
      if (by_link) {
        fs::create_directory(folder.file("links"));
        name = folder.file("links") / "link.db";
        fs::create_symlink(lab, name);
      }
      std::string said;
      {
        Connection db = store::open(name, Access::create);
        Place place(db);
        add_campaign(db, test::small_campaign(1, "before"));
        CHECK_NOTHROW(place.require_same());
        deed.done(lab, folder);
        add_campaign(db, test::small_campaign(1, "after"));
        try {
          place.require_same();
        } catch (const StoreError& error) {
          said = error.what();
          CHECK(error.code() == ExitCode::storage);
          CHECK_THROWS_AS(add_campaign(db, test::small_campaign(1, "late")), StoreError);
        }
      }
      CHECK(said.empty() == std::string(deed.says).empty());
      if (!by_link) CHECK_THAT(said, Contains(deed.says));
      CHECK(n_campaigns(folder.file(deed.data_is_in)) == 2);
      // What took its place is what it was, without a log of others over it.
      if (fs::exists(lab) && std::string(deed.data_is_in) != "lab.db") CHECK(n_campaigns(lab) == 3);
    }
  }
}

TEST_CASE("a link that leads elsewhere is another database", "[store]") {
  const TempFolder folder;
  { store::open(folder.file("other.db"), Access::create); }
  { store::open(folder.file("lab.db"), Access::create); }
  fs::create_symlink(folder.file("lab.db"), folder.file("link.db"));
  Connection db = store::open(folder.file("link.db"), Access::write);
  Place place(db);
  fs::remove(folder.file("link.db"));
  fs::create_symlink(folder.file("other.db"), folder.file("link.db"));
  CHECK_THROWS_WITH(place.require_same(), Contains("link.db is another file"));
}

TEST_CASE(
    "a database with two names is read and not written: by the second, what is stored is lost",
    "[store]") {
  const TempFolder folder;
  {
    Connection db = store::open(folder.file("lab.db"), Access::create);
    add_campaign(db, test::small_campaign(1, "ours"));
  }
  fs::create_hard_link(folder.file("lab.db"), folder.file("link.db"));
  for (const char* name : {"lab.db", "link.db"}) {
    CHECK(n_campaigns(folder.file(name)) == 1);
    for (const Access access : {Access::write, Access::create}) {
      CHECK_THROWS_WITH(store::open(folder.file(name), access), Contains("a second name"));
    }
  }
  fs::remove(folder.file("link.db"));
  CHECK_NOTHROW(store::open(folder.file("lab.db"), Access::write));

  // the control: SQLite alone, in two processes, a row by each name
  const fs::path a = folder.file("a.db"), b = folder.file("b.db");
  const auto run = [](sqlite3* db, const char* sql) {
    return sqlite3_exec(db, sql, nullptr, nullptr, nullptr) == SQLITE_OK;
  };
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();  // before anything is open that it would share
  if (child == 0) {
    char word = 0;
    static_cast<void>(!::read(ends[0], &word, 1));
    sqlite3* second = nullptr;
    sqlite3_open(b.c_str(), &second);
    ::_exit(run(second, "INSERT INTO t VALUES (2)") ? 0 : 1);
  }
  sqlite3* first = nullptr;
  sqlite3_open(a.c_str(), &first);
  CHECK(run(first, "PRAGMA journal_mode = WAL; CREATE TABLE t (x)"));
  CHECK(run(first, "PRAGMA wal_checkpoint(TRUNCATE)"));
  fs::create_hard_link(a, b);
  CHECK(run(first, "INSERT INTO t VALUES (1)"));
  CHECK(::write(ends[1], "b", 1) == 1);
  int status = -1;
  ::waitpid(child, &status, 0);
  CHECK(status == 0);
  for (const int end : ends) ::close(end);
  sqlite3_close(first);
  int left = 2;
  sqlite3_open(a.c_str(), &first);
  const auto count = [](void* to, int, char** values, char**) {
    *static_cast<int*>(to) = std::stoi(values[0]);
    return 0;
  };
  sqlite3_exec(first, "SELECT count(*) FROM t", count, &left, nullptr);
  sqlite3_close(first);
  CHECK(left < 2);
}

TEST_CASE("another log beside the same file is left to those who write it", "[store]") {
  const TempFolder folder;
  const fs::path lab = folder.file("lab.db"), log = lab.string() + "-wal";
  std::string file;
  {
    Connection db = store::open(lab, Access::create);
    Place place(db);
    add_campaign(db, test::small_campaign(1, "ours"));
    fs::remove(log);
    std::ofstream(log) << "frames of another process";
    file = tests::read_text(lab);
    CHECK_THROWS_WITH(place.require_same(), Contains("lab.db-wal is another file"));
  }
  CHECK(tests::read_text(log) == "frames of another process");
  CHECK(tests::read_text(lab) == file);
}

TEST_CASE("a copy of the main file alone holds what was made, while it is open", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  fs::copy_file(folder.file("lab.db"), folder.file("new.db"));
  CHECK(n_campaigns(folder.file("new.db")) == 0);
  add_campaign(db, test::small_campaign(1, "one"));
  fs::copy_file(folder.file("lab.db"), folder.file("early.db"));
  CHECK(n_campaigns(folder.file("early.db")) == 0);  // the control: it is in the log alone
  checkpoint(db);
  fs::copy_file(folder.file("lab.db"), folder.file("late.db"));
  CHECK(n_campaigns(folder.file("late.db")) == 1);
}

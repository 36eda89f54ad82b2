#include "store/verify.hpp"

#include <fstream>
#include <iterator>

#include "store/job.hpp"
#include "store/model.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/stress/byte_sweep.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::TempFolder;

namespace {

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

// A database with rows of every kind, in one file without a log.
std::string whole_database(const TempFolder& folder) {
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign =
      import_campaign(db, test::small_campaign(), {.extra_json = {{2, "{}"}}}).campaign_id;
  const Id session = test::measured_session(db, campaign, "baseline", 3);
  add_event(db, session, "done");
  exclude_reading(db, campaign, 2, "bumped");
  NewJob job{.campaign_id = campaign, .key = {std::string(64, 'a'), {}}, .stage = "lsq"};
  add_model(db, {.campaign_id = campaign, .name = "nominal", .job_id = add_job(db, job)});
  CHECK(verify(db).findings.empty());
  Connection(folder.file("lab.db"), Access::write)
      .execute("VACUUM INTO '" + folder.file("copy.db").string() + "'");
  return bytes_of(folder.file("copy.db"));
}

// The n attempts at a session's points and their readings, in one file without a log.
std::filesystem::path measured_database(const TempFolder& folder, int n) {
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign =
      import_campaign(db, test::small_campaign(), {.extra_json = {{2, "{}"}}}).campaign_id;
  test::measured_session(db, campaign, "baseline", n);
  Connection(folder.file("lab.db"), Access::write)
      .execute("VACUUM INTO '" + folder.file("copy.db").string() + "'");
  return folder.file("copy.db");
}

std::uint32_t root_of(const std::filesystem::path& file, const std::string& name) {
  Connection db(file, Access::read_only);
  return static_cast<std::uint32_t>(
      test::number(db, "SELECT rootpage FROM sqlite_schema WHERE name = '" + name + "'"));
}

std::string all_lines(const std::vector<std::string>& findings) {
  std::string all;
  for (const std::string& finding : findings) all += finding + "\n";
  return all;
}

// What verify says of a file, or why it can not be opened.
std::vector<std::string> verdict(const std::filesystem::path& file) {
  try {
    Connection db = store::open(file, Access::read_only);
    return verify(db).findings;
  } catch (const Error& error) {
    return {error.what()};
  }
}

// Changes through SQL what no guard allows: the guards are taken away and put back.
void tamper(const std::filesystem::path& file, const std::string& table, const std::string& sql) {
  Connection db(file, Access::write);
  std::vector<std::string> guards;
  {
    Statement rows(db,
                   "SELECT sql, name FROM sqlite_schema WHERE type = 'trigger' AND tbl_name = ?");
    rows << table;
    std::vector<std::string> names;
    while (rows.step()) {
      guards.push_back(rows.text(0));
      names.push_back(rows.text(1));
    }
    rows.reset();
    for (const std::string& name : names) db.execute("DROP TRIGGER " + name);
  }
  db.execute("PRAGMA foreign_keys = OFF");
  db.execute(sql);
  for (const std::string& guard : guards) db.execute(guard);
}

}  // namespace

TEST_CASE("every single changed byte of every stored reading is found and the reading named",
          "[store]") {
  const TempFolder folder;
  whole_database(folder);
  const test::SweepCount count =
      test::sweep_bytes(folder.file("copy.db"), {.table = "reading", .masks = {0x01}});
  CHECK(count.rows == 9);
  CHECK(count.bytes > 9 * 100);
  CHECK(count.found == count.bytes);
  CHECK(count.named == count.bytes);
  CHECK(count.untouched_is_clean);  // the control
  INFO(count.first_miss);
  CHECK(count.first_miss.empty());
}

TEST_CASE("a changed length of any row on several pages is found and the row named", "[store]") {
  const TempFolder folder;
  const auto file = measured_database(folder, 130);
  constexpr int kFirstByteOnly = 1 << 16;
  for (const char* table : {"attempt", "reading"}) {
    const test::SweepCount count =
        test::sweep_bytes(file, {.table = table, .masks = {0x01, 0x80}, .step = kFirstByteOnly});
    INFO(table << ": " << count.first_miss);
    CHECK(count.untouched_is_clean);
    CHECK(count.bytes >= 2 * 130);
    CHECK(count.named == count.bytes);
  }
}

TEST_CASE("what SQLite says of a page is said of its table, its index and its row", "[store]") {
  const TempFolder folder;
  const auto file = measured_database(folder, 130);
  const std::string whole = bytes_of(file);
  const auto verdict_with = [&](std::size_t at, char byte) {
    std::string changed = whole;
    changed[at] = byte;
    write(file, changed);
    return all_lines(verdict(file));
  };
  const std::vector<test::Cell> rows = test::rows_of(whole, root_of(file, "attempt"));
  REQUIRE(rows.size() == 130);
  // The changed length takes the number's byte in, and the next one becomes the number: 10, always.
  const std::vector<std::pair<std::size_t, std::string>> named = {
      {1, "attempt 10, the first row"},
      {2, "attempt 10, the row after attempt 1"},
      {10, "attempt 10"},
      {65, "attempt 10, the row after attempt 64"},
      {130, "attempt 10, the row after attempt 129"}};
  for (const auto& [id, name] : named) {
    const std::size_t at = rows[id - 1].begin;
    const std::string findings = verdict_with(at, static_cast<char>(whole[at] ^ '\x80'));
    CHECK_THAT(findings, Contains(name + ": damaged in the file (On tree page "));
  }
  CHECK_THAT(verdict_with(rows[11].begin + 1, 2),  // 12 is 2 now
             Contains("attempt 11: out of order with a row beside it (On tree page "));
  const std::size_t page_bytes = 4096;
  const auto page_of = [&](const char* name) { return (root_of(file, name) - 1) * page_bytes; };
  write(file, whole);
  const std::size_t table = page_of("attempt"), index = page_of("attempt_ok_once"),
                    one_page = page_of("epoch");
  CHECK_THAT(verdict_with(index + 4, 0), Contains("index attempt_ok_once of attempt: damaged"));
  CHECK_THAT(verdict_with(table + 4, 0), Contains("attempt: damaged in the file"));
  CHECK_THAT(verdict_with(one_page + 7, 1), Contains("epoch, rows 1 to 2: damaged in the file"));
}

TEST_CASE("a page that leads back to itself ends no walk of verify in a circle", "[store]") {
  const TempFolder folder;
  const auto file = measured_database(folder, 130);
  std::string bytes = bytes_of(file);
  const std::uint32_t root = root_of(file, "attempt");
  const std::size_t page = (root - 1) * 4096;
  REQUIRE(bytes[page] == 5);
  bytes[page + 11] = static_cast<char>(root);  // the rightmost page
  write(file, bytes);
  CHECK_THAT(all_lines(verdict(file)), Contains("attempt: damaged in the file"));
}

TEST_CASE("a closed attempt that says it is open again is found", "[store]") {
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    Connection db = store::open(file, Access::create);
    const Id campaign = import_campaign(db, test::small_campaign(), {}).campaign_id;
    const Id session = create_session(
        db, {.campaign_id = campaign, .name = "baseline", .points = test::line_plan(1)});
    const Epoch epoch = open_epoch(db, session, SetUp::fresh, "start");
    fail_attempt(db, begin_attempt(db, session, 1, epoch.id), "beam lost");
    REQUIRE(verify(db).ok());
  }
  tamper(file, "attempt", "UPDATE attempt SET status = 'open', closed_utc = NULL");
  CHECK_THAT(all_lines(verdict(file)), Contains("attempt 1: this row"));
}

TEST_CASE("a changed value in any column of a raw table is found", "[store]") {
  const TempFolder folder;
  whole_database(folder);
  const auto file = folder.file("copy.db");
  const std::string whole = bytes_of(file);
  int n_columns = 0;
  for (const std::string table :
       {"reading", "point", "attempt", "epoch", "session", "campaign", "machine", "machine_chain",
        "drive", "campaign_fact", "exclusion", "session_event"}) {
    std::vector<std::pair<std::string, std::string>> columns;
    {
      Connection db(file, Access::read_only);
      Statement rows(db, "SELECT name, type FROM pragma_table_info(?)");
      rows << table;
      while (rows.step()) columns.emplace_back(rows.text(0), rows.text(1));
    }
    for (const auto& [column, type] : columns) {
      INFO(table << "." << column);
      const std::string value = type == "BLOB"   ? "zeroblob(32)"
                                : type == "TEXT" ? "coalesce(" + column + ", '') || ' '"
                                                 : "coalesce(" + column + ", 0) + 1";
      tamper(file, table,
             "PRAGMA ignore_check_constraints = ON; UPDATE OR IGNORE " + table + " SET " + column +
                 " = " + value + " WHERE rowid = (SELECT max(rowid) FROM " + table + ")");
      CHECK_FALSE(verdict(file).empty());
      write(file, whole);
      std::filesystem::remove(file.string() + "-wal");
      std::filesystem::remove(file.string() + "-shm");
      ++n_columns;
    }
  }
  CHECK(n_columns > 90);
  CHECK(verdict(file).empty());
}

TEST_CASE("verify names the reading that was changed", "[store]") {
  const TempFolder folder;
  whole_database(folder);
  const auto file = folder.file("copy.db");
  tamper(file, "reading", "UPDATE reading SET x_mm = x_mm + 1e-9 WHERE seq = 4");
  const auto findings = verdict(file);
  REQUIRE(findings.size() == 1);
  CHECK_THAT(findings[0], Contains("seq 4"));
}

TEST_CASE("verify finds rows that were changed, taken away or slipped in", "[store]") {
  const TempFolder folder;
  whole_database(folder);
  const auto file = folder.file("copy.db");
  struct Case {
    std::string table, sql, named;
  };
  const std::vector<Case> cases = {
      {"campaign", "UPDATE campaign SET kind = 'simulated'", "campaign 1"},
      {"machine_chain",
       "UPDATE machine_chain SET value = 734 WHERE chain = 2 AND parameter = 'R_mm'", "campaign 1"},
      {"drive", "UPDATE drive SET lead_mm = 5 WHERE drive = 1", "campaign 1"},
      {"campaign_fact", "DELETE FROM campaign_fact WHERE key = 'operator'", "campaign 1"},
      {"session",
       "UPDATE session SET compensation_job_id = 1, compensation_name = 'x' WHERE session_id = 2",
       "session 2"},
      {"point", "UPDATE point SET target_x_mm = 0 WHERE seq = 1", "session 2"},
      {"epoch", "UPDATE epoch SET reason = '' WHERE epoch_id = 2", "epoch 2"},
      {"attempt", "UPDATE attempt SET detail = 'x' WHERE attempt_id = 1", "attempt 1"},
      {"reading", "DELETE FROM reading WHERE seq = 9", "attempt 3"},  // the last one
      {"reading", "DELETE FROM reading WHERE seq = 3", "seq 4"},
      {"exclusion", "DELETE FROM exclusion", "exclusion 1"},
      {"exclusion", "UPDATE exclusion SET reason = 'y'", "exclusion 1"},
      {"job", "UPDATE job SET result_json = '[]'", "job 1"},
      {"job_point", "INSERT INTO job_point VALUES (1, 1, 1, 0, 0, 0, 0.5, 0, 0)", "job 1"},
      {"model", "UPDATE model SET name = 'better'", "model 1"},
      {"session_event", "DELETE FROM session_event", "session_event 1"},
      {"seal", "DELETE FROM seal WHERE table_name = 'model'", "model 1"},
  };
  const std::string whole = bytes_of(file);
  for (const Case& c : cases) {
    INFO(c.sql);
    write(file, whole);
    tamper(file, c.table, c.sql);
    const auto findings = verdict(file);
    REQUIRE_FALSE(findings.empty());
    CHECK_THAT(all_lines(findings), Contains(c.named));
    std::filesystem::remove(file.string() + "-wal");
    std::filesystem::remove(file.string() + "-shm");
  }
}

// An archive of strangers: whatever its owner made of its rows, a pull refuses them or gives what a
// station's file may hold; nothing crashes, and no file is left under the name that was asked for.

#include <nlohmann/json.hpp>

#include "app/archive/pull.hpp"
#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using tests::kStationA;

namespace {

/// An archive that was honest when a station pushed a campaign.
struct Stranger {
  explicit Stranger(tests::Postgres& of) : server(of), name(of.new_archive()) {
    {
      store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
      tests::add_full_campaign(db, "rail");
    }
    tests::push_all(as("robot_a"), folder.file("lab.db"), kStationA);
  }
  [[nodiscard]] std::string as(const std::string& role) const { return server.uri(name, role); }
  /// What its owner does, past every guard.
  void run(archive::Link& link, const std::string& sql) const {
    link.run(
        "SET LOCAL session_replication_role = replica; "
        "ALTER TABLE trammel.archive_row DROP CONSTRAINT archive_row_row_ids_check, DROP "
        "CONSTRAINT "
        "archive_row_n_rows_check; " +
        sql);
  }
  /// How a pull of the station ends where the owner has done that; "" where it gives a file.
  std::string pulled_after(const std::string& sql, const std::string& campaign = "") {
    archive::Link link({.uri = as("postgres"), .who = "tests"});
    link.run("BEGIN");
    run(link, sql);
    link.run("COMMIT");
    const auto to = folder.file("pulled.db");
    std::filesystem::remove(to);
    archive::Link visitor({.uri = as("visitor"), .who = "tests"});
    std::string said;
    try {
      archive::pull(visitor, {.station = kStationA, .campaign = campaign}, to);
    } catch (const Error& error) {
      said = describe(error.text());
    }
    CHECK(std::filesystem::exists(to) == said.empty());
    CHECK(!std::filesystem::exists(to.string() + ".part"));
    return said;
  }
  tests::Postgres& server;
  std::string name;
  test::TempFolder folder;
};

/// Rows of that table get these bytes, and the digest that belongs to them.
std::string with_bytes(const std::string& table, const std::string& bytes) {
  return "UPDATE trammel.archive_row SET bytes = " + bytes + " WHERE table_name = '" + table +
         "'; UPDATE trammel.archive_row SET sha256 = sha256(bytes)";
}
std::string with(const std::string& table, const std::string& column, const std::string& value) {
  return "UPDATE trammel.archive_row SET " + column + " = " + value + " WHERE table_name = '" +
         table + "'";
}

}  // namespace

TEST_CASE("a pull refuses rows that no station stores, and says which", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  struct Lie {
    std::string sql, said;
  };
  const std::string cut = "substr(bytes, 1, length(bytes) - 3)";
  const std::vector<Lie> lies = {
      {with("exclusion", "sha256", "sha256('')"), "exclusion 1"},
      {"UPDATE trammel.reading SET x_mm = x_mm + 1e-9 WHERE seq = 3", "seq 3"},
      {"UPDATE trammel.reading SET sha256 = sha256('') WHERE seq = 4", "seq 4"},
      {with("exclusion", "bytes", cut), "end in the middle of a value"},
      {with_bytes("exclusion", cut), "end in the middle of a value"},
      {with_bytes("exclusion", "bytes || '\\x6e'"), "beyond its last part"},
      {with_bytes("exclusion", "set_byte(bytes, 9, 90)"), "unknown kind"},
      {with_bytes("exclusion", "substr(bytes, 1, 9) || '\\x74ffffffffffffffff61'"),
       "end in the middle of a value"},
      {with_bytes("exclusion", "substr(bytes, 1, 9) || '\\x747fffffffffffffff61'"),
       "end in the middle of a value"},
      {with("job", "n_rows", "'{2147483647,0,0,0,0,0,0}'"), "job 1"},
      {with("job", "n_rows", "'{-1,-1,-1,-1,-1,-1,-1}'"), "job 1"},
      {with("job", "n_rows", "'{1}'"), "other parts"},
      {with("job", "n_rows", "'{}'"), "other parts"},
      {with("exclusion", "row_ids", "'{}'"), "exclusion"},
      {with("epoch", "row_ids", "'{7}'"), "epoch"},
      {with("epoch", "row_ids", "'{-7}'"), "epoch"},
      {with("session", "row_ids", "row_ids[1:1]"), "a point without a number"},
      {with("exclusion", "campaign", "'" + tests::kStationB + "'"), ""},  // not this station's
      {"DELETE FROM trammel.archive_row WHERE table_name = 'epoch'", "it names a missing row"},
      {"DELETE FROM trammel.archive_row WHERE table_name = 'campaign'", ""},
  };
  for (const Lie& lie : lies) {
    CAPTURE(lie.sql);
    Stranger stranger(*server);
    const std::string said = stranger.pulled_after(lie.sql);
    CHECK(said != "");
    CHECK_THAT(said, Contains(lie.said));
  }
}

TEST_CASE("names of a stranger's archive are names: neither SQL, nor paths, nor a terminal's codes",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  Stranger stranger(*server);
  const std::string uuid = "'); DROP TABLE trammel.station; --xxx";  // 37, one more than a uuid
  const std::string honest =
      tests::asked(stranger.as("visitor"), "SELECT campaign FROM trammel.campaign");
  const std::string as_text = "$name$" + uuid + "$name$";
  std::string renamed;
  for (const char* table :
       {"campaign_head", "campaign", "archive_row", "reading", "session", "job"}) {
    if (table == std::string("campaign_head")) {
      renamed += "ALTER TABLE trammel.campaign_head DROP CONSTRAINT campaign_head_campaign_check; ";
    }
    renamed += std::string("UPDATE trammel.") + table + " SET campaign = " + as_text + "; ";
  }
  CHECK(stranger.pulled_after(renamed, uuid) != "");
  CHECK(tests::asked(stranger.as("visitor"), "SELECT count(*) FROM trammel.station") == "1");

  Stranger other(*server);
  archive::Link link({.uri = other.as("postgres"), .who = "tests"});
  link.run("BEGIN");
  other.run(link,
            "UPDATE trammel.campaign SET name = E'../../\\x1b[31mred\\x07', machine = E'a\\nb'; "
            "UPDATE trammel.campaign_head SET moved_at = 'infinity'");
  link.run("COMMIT");
  const auto shown = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all = {"archive"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--archive", other.as("visitor")});
    const auto done = tests::run_program(all, other.folder.path());
    CHECK(done.exit_code == 0);
    CHECK_THAT(done.out + done.err, !Contains("\x1b") && !Contains("\x07"));
    return done.out;
  };
  CHECK_THAT(shown({"list"}), Contains("red"));
  CHECK_THAT(shown({"list", "--json"}), Contains("red"));
  shown({"status"});
}

// Its digest is right, so it is a row that a station may have: what reads it looks at it.
TEST_CASE("JSON of a stranger's archive that no station writes harms no one who reads it",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const auto shown_after = [&](const std::string& from, const std::string& to) {
    Stranger stranger(*server);
    const std::string before = "trammel.canonical($json$" + from + "$json$)";
    CHECK(stranger.pulled_after(
              "UPDATE trammel.archive_row SET bytes = overlay(bytes placing trammel.canonical(" +
              to + ") from position(" + before + " in bytes) for length(" + before +
              ")) WHERE table_name = 'job' AND position(" + before +
              " in bytes) > 0; UPDATE trammel.archive_row SET sha256 = sha256(bytes)") == "");
    return tests::run_program({"job", "show", "1", "--db", "pulled.db"}, stranger.folder.path());
  };
  CHECK(shown_after(R"({"a":[1],"b":0.1})", R"('{ "b":0.1, "a":[1], "a":[2] }')").exit_code == 0);
  const auto deep = shown_after(R"({"rank":12})", "repeat('[', 100000) || repeat(']', 100000)");
  CHECK(deep.exit_code == 8);
  CHECK_THAT(deep.err, Contains("nested too deeply"));
}

TEST_CASE("an answer of another form than was asked for is refused by name", "[archive]") {
  const archive::Link::Row row = {"12", std::nullopt, "12 monkeys", ""};
  CHECK(archive::number_of(row, 0) == 12);
  for (const std::size_t column : {1U, 2U, 3U, 4U}) {
    CHECK_THROWS_AS(archive::number_of(row, column), DeviceError);
  }
  CHECK_THROWS_AS(archive::text_of(row, 1), DeviceError);
  CHECK_THROWS_AS(archive::text_of(row, 4), DeviceError);
}

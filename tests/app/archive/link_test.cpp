// No connection that proves nothing, and no password where everyone can read it.

#include "app/archive/link.hpp"

#include <pwd.h>
#include <unistd.h>

#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/relay.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using archive::connection_words;

namespace {

std::string value_of(const archive::LinkOptions& options, const std::string& keyword) {
  for (const auto& [name, value] : connection_words(options)) {
    if (name == keyword) return value;
  }
  return "";
}

}  // namespace

TEST_CASE("a connection checks whose server it is, unless --insecure insists", "[archive]") {
  const std::string host = "postgresql://archive.example/fleet";
  CHECK(value_of({.uri = host}, "sslmode") == "verify-full");
  CHECK(value_of({.uri = host + "?sslmode=verify-full"}, "sslmode") == "verify-full");
  CHECK(value_of({.uri = "service=fleet"}, "sslmode") == "verify-full");
  for (const char* weaker : {"disable", "allow", "prefer", "require", "verify-ca"}) {
    const std::string uri = host + "?sslmode=" + weaker;
    CHECK_THROWS_WITH(connection_words({.uri = uri}), Contains(weaker) && Contains("--insecure"));
    CHECK(value_of({.uri = uri, .insecure = true}, "sslmode") == weaker);
  }
  CHECK(value_of({.uri = host, .who = "robot 7"}, "application_name") == "robot 7");
  CHECK(value_of({.uri = host}, "tcp_user_timeout") == "60000");
  CHECK(value_of({.uri = host + "?tcp_user_timeout=5000"}, "tcp_user_timeout") == "5000");
}

TEST_CASE("a password on the command line is refused, and not repeated", "[archive]") {
  for (const char* uri : {"postgresql://robot:hunter2@archive.example/fleet",
                          "host=archive.example password=hunter2"}) {
    try {
      static_cast<void>(connection_words({.uri = uri}));
      FAIL("taken: " << uri);
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Contains("pgpass") && !Contains("hunter2"));
    }
  }
  CHECK_THROWS_AS(connection_words({.uri = "nonsense"}), InputError);
}

TEST_CASE("a server without TLS is refused over the network, and named by its settings",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string tcp =
      "postgresql://postgres@127.0.0.1:" + std::to_string(server->port()) + "/postgres";
  CHECK_THROWS_WITH(archive::Link({.uri = tcp, .who = "tests"}), Contains("--insecure"));
  archive::Link insecure({.uri = tcp, .insecure = true, .who = "robot 7"});
  CHECK(insecure.ask("SHOW application_name")[0][0] == "robot 7");
  CHECK(insecure.ask("SHOW statement_timeout")[0][0] == "1h");
  CHECK(insecure.ask("SHOW idle_in_transaction_session_timeout")[0][0] == "2min");
}

TEST_CASE(
    "over the network, the server must have a certificate that is known here and has its name",
    "[archive]") {
  std::filesystem::path certificate;
  const auto make_certificate = [&certificate](const std::filesystem::path& folder) {
    certificate = folder / "server.crt";
    const std::string key = folder / "server.key";
    REQUIRE(tests::run_command(
                {"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                 "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                 "-addext", "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate},
                folder)
                .exit_code == 0);
    const passwd* user = getpwnam("postgres");
    if (geteuid() == 0 && user != nullptr) {
      REQUIRE(chown(key.c_str(), user->pw_uid, user->pw_gid) == 0);
    }
  };
  if (tests::run_command({"sh", "-c", "command -v openssl"}, "/").exit_code != 0) {
    tests::skip_without("openssl");
    return;
  }
  const auto server = tests::Postgres::durable(
      make_certificate, " -c ssl=on -c ssl_cert_file=../server.crt -c ssl_key_file=../server.key");
  if (server == nullptr) return;
  const auto uri = [&](const std::string& host) {
    return "postgresql://postgres@" + host + ":" + std::to_string(server->port()) +
           "/postgres?hostaddr=127.0.0.1&sslrootcert=" + certificate.string();
  };
  archive::Link link({.uri = uri("localhost"), .who = "tests"});
  CHECK(link.ask("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")[0][0] == "t");
  CHECK_THROWS_WITH(archive::Link({.uri = uri("archive.example"), .who = "tests"}),
                    Contains("archive.example"));  // another one's
  const std::string unknown = "postgresql://postgres@localhost:" + std::to_string(server->port()) +
                              "/postgres?hostaddr=127.0.0.1&sslrootcert=/nowhere";
  CHECK_THROWS_WITH(archive::Link({.uri = unknown, .who = "tests"}), Contains("--insecure"));
  // The control: unproven, it is taken.
  archive::Link unproven({.uri = uri("archive.example"), .insecure = true, .who = "tests"});
  CHECK(unproven.ask("SELECT 1")[0][0] == "1");
}

TEST_CASE("a server older than the archive's schema was tried on is refused, a newer one taken",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const tests::Relay older(server->socket_folder(), server->port(), {.version = "14"});
  CHECK_THROWS_WITH(archive::Link({.uri = older.uri("postgres", "postgres"), .who = "tests"}),
                    Contains("PostgreSQL 14") && Contains("PostgreSQL 15 or later"));
  const tests::Relay newer(server->socket_folder(), server->port(), {.version = "19"});
  archive::Link link({.uri = newer.uri("postgres", "postgres"), .who = "tests"});
  CHECK(link.ask("SELECT 1")[0][0] == "1");
}

// Canonical bytes are what digests are taken over, and values come out of them as they went in.

#include "store/canonical.hpp"

#include <cmath>

#include "store/campaign.hpp"
#include "store/reading.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;

TEST_CASE("SHA-256 of a row's canonical bytes is its seal, and begins with its key", "[store]") {
  const test::TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = import_campaign(db, test::small_campaign()).campaign_id;
  test::measured_session(db, campaign, "walk", 3);
  exclude_reading(db, campaign, 2, "a truck passed");
  int n_seen = 0;
  Statement rows(db, kSealedRowsOfCampaign);
  rows << campaign;
  while (rows.step()) {
    for (const Sealed& sealed : sealed_tables()) {
      if (sealed.table != rows.text(0)) continue;
      const CanonicalRow row = canonical_row(db, sealed, rows.integer(1));
      CAPTURE(row.table, rows.integer(1));
      CHECK(hex(sha256_of(row.bytes)) == hex(rows.blob(2)));
      CHECK(row.bytes.substr(9, row.key.size()) == row.key);
      CHECK(row.n_rows.size() == sealed.rows.size());
      CHECK(row.ids.size() ==
            (row.table == "session" ? 1U + static_cast<std::size_t>(row.n_rows[1]) : 1U));
      ++n_seen;
    }
  }
  CHECK(n_seen == test::number(db, "SELECT count(*) FROM seal"));
  Sha256 head = {};
  Statement readings(db, chained_readings_beyond());
  readings << campaign << 0;
  int n_readings = 0;
  for (; readings.step(); ++n_readings) {
    std::string link("b\0\0\0\0\0\0\0\x20", 9);
    link.append(head.begin(), head.end());
    link.append(canonical_bytes(readings, kFirstChained, kEndChained));
    head = sha256_of(link);
    CHECK(hex(readings.blob(kEndChained)) == hex(head));
  }
  CHECK(n_readings == 9);
}

TEST_CASE("values come out of canonical bytes as they went in", "[store]") {
  const test::TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  Statement row(db, "SELECT NULL, -7, 0.1, -5e-324, 'Zoë', x'0001ff', -0.0, ''");
  REQUIRE(row.step());
  const std::string bytes = canonical_bytes(row, 0, row.columns());
  CanonicalReader reader(bytes);
  CHECK(reader.next() == Value());
  CHECK(reader.next() == Value(std::int64_t{-7}));
  CHECK(reader.next() == Value(0.1));
  CHECK(reader.next() == Value(-5e-324));
  CHECK(reader.next() == Value(std::string("Zoë")));
  CHECK(reader.next() == Value(Blob{0, 1, 255}));
  CHECK_FALSE(std::signbit(std::get<double>(reader.next())));
  CHECK(reader.next() == Value(std::string()));
  CHECK(reader.at_end());
  for (std::size_t size = 0; size < bytes.size();
       ++size) {  // cut anywhere: refused, or whole values
    CanonicalReader cut(std::string_view(bytes).substr(0, size));
    try {
      while (!cut.at_end()) static_cast<void>(cut.next());
    } catch (const InputError&) {
    }
  }
  CanonicalReader unknown("x");
  CHECK_THROWS_AS(unknown.next(), InputError);
  CanonicalReader longer(
      std::string_view("t\xff\xff\xff\xff\xff\xff\xff\xff"
                       "a",
                       10));
  CHECK_THROWS_AS(longer.next(), InputError);
}

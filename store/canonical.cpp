#include "store/canonical.hpp"

#include <bit>
#include <map>
#include <utility>

#include "store/reading.hpp"

namespace trammel::store {

namespace {

/// Columns of a table's first part that are its natural key, the campaign's uuid first.
int key_columns(const std::string& table) {
  static const std::map<std::string, int> columns = {
      {"campaign", 1}, {"session", 2},   {"session_event", 3}, {"epoch", 3},     {"attempt", 4},
      {"job", 4},      {"exclusion", 2}, {"model", 2},         {"taken_over", 1}};
  return columns.at(table);
}

}  // namespace

std::string canonical_bytes(const Statement& row, int first, int end) {
  return std::move(CanonicalText().row(row, first, end).bytes);
}

CanonicalRow canonical_row(Connection& connection, const Sealed& sealed, Id id) {
  CanonicalRow made{.table = sealed.table, .key = {}, .ids = {id}, .n_rows = {}, .bytes = {}};
  CanonicalText text;
  for (std::size_t part = 0; part < sealed.rows.size(); ++part) {
    text << static_cast<int>(part);
    Statement rows(connection, sealed.rows[part]);
    rows << id;
    made.n_rows.push_back(0);
    while (rows.step()) {
      if (part == 0) made.key = canonical_bytes(rows, 0, key_columns(sealed.table));
      text.row(rows, 0, rows.columns());
      ++made.n_rows.back();
    }
  }
  made.bytes = std::move(text.bytes);
  if (sealed.table == "session") {
    Statement points(connection, "SELECT point_id FROM point WHERE session_id = ? ORDER BY seq");
    points << id;
    while (points.step()) made.ids.push_back(points.integer(0));
  }
  return made;
}

std::string chained_readings_beyond() {
  std::string sql = kChainedReadings;  // of all campaigns, along the table
  const auto exchange = [&sql](std::string_view part, std::string_view by) {
    const std::size_t at = sql.find(part);
    TRAMMEL_ASSERT(at != std::string::npos);
    sql.replace(at, part.size(), by);
  };
  exchange("NOT INDEXED ", "");
  exchange("ORDER BY reading_id",
           "WHERE reading.campaign_id = ?1 AND reading.seq > ?2 ORDER BY reading.seq");
  return sql;
}

const char* const kSealedRowsOfCampaign =
    "SELECT table_name, row_id, sha256 FROM ("
    "SELECT 'campaign' AS table_name, campaign_id AS row_id FROM campaign WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'job', job_id FROM job WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'session', session_id FROM session WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'session_event', event_id FROM session JOIN session_event USING (session_id) "
    "WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'epoch', epoch_id FROM session JOIN epoch USING (session_id) "
    "WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'attempt', attempt_id FROM session JOIN point USING (session_id) "
    "JOIN attempt USING (point_id) WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'exclusion', exclusion_id FROM exclusion WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'model', model_id FROM model WHERE campaign_id = ?1 "
    "UNION ALL SELECT 'taken_over', campaign_id FROM taken_over WHERE campaign_id = ?1) "
    "JOIN seal USING (table_name, row_id)";

std::string_view CanonicalReader::take(std::size_t size) {
  if (size > rest_.size()) {
    throw InputError({.what = "canonical bytes end in the middle of a value",
                      .got = std::to_string(rest_.size()) + " bytes",
                      .expected = std::to_string(size)});
  }
  const std::string_view taken = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return taken;
}

std::uint64_t CanonicalReader::number() {
  std::uint64_t bits = 0;
  for (const char byte : take(8)) bits = bits << 8U | static_cast<unsigned char>(byte);
  return bits;
}

Value CanonicalReader::next() {
  switch (const char kind = take(1).front()) {
    case 'n':
      return std::monostate();
    case 'i':
      return static_cast<std::int64_t>(number());
    case 'r':
      return std::bit_cast<double>(number());
    case 't':
      return std::string(take(number()));
    case 'b': {
      const std::string_view bytes = take(number());
      return Blob(bytes.begin(), bytes.end());
    }
    default:
      throw InputError({.what = "canonical bytes hold a value of an unknown kind",
                        .got = std::to_string(static_cast<unsigned char>(kind))});
  }
}

}  // namespace trammel::store

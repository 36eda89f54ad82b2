#include "store/verify.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <sstream>

#include "store/open.hpp"
#include "store/pages.hpp"
#include "store/reading.hpp"
#include "store/row_name.hpp"
#include "store/scheme.hpp"

namespace trammel::store {

namespace {

constexpr std::size_t kMostFindings = 100;

// A damaged page ends a walk with an exception: it is a finding like any other. The walk says how
// far it has come.
template <class Walk>
void guarded(CheckReport& report, std::string place, Walk walk) {
  try {
    walk(place);
  } catch (const StoreError& error) {
    report.findings.push_back(place + ": " + error.text().what + ", " + error.text().got);
  }
}

// SQLite names an index and a number, or a page; a person asks for the table's row. `pages` are
// a copy of the file: made of a damaged one only.
std::string with_row(Connection& connection, std::optional<Pages>& pages,
                     const std::string& finding) {
  static const std::regex missing("row (-?[0-9]+) missing from index ([A-Za-z0-9_]+)");
  static const std::regex on_page("[Pp]age ([0-9]{1,10})( cell ([0-9]{1,10}))?");
  std::smatch match;
  if (std::regex_match(finding, match, missing)) {
    Statement table(connection,
                    "SELECT tbl_name FROM sqlite_schema WHERE type = 'index' AND name = ?");
    table << match[2].str();
    if (table.step()) return table.text(0) + " " + match[1].str() + " (" + finding + ")";
  } else if (std::regex_search(finding, match, on_page)) {
    if (!pages) pages.emplace(connection);
    const auto cell = match[3].matched ? std::optional(std::stoll(match[3])) : std::nullopt;
    const std::string name = pages->name(std::stoll(match[1]), cell);
    // Of two rows out of order SQLite names the first, whichever is damaged.
    const bool order = finding.ends_with("out of order");
    const std::string what =
        order ? ": out of order with a row beside it" : ": damaged in the file";
    if (!name.empty()) return name + what + " (" + finding + ")";
  }
  return "SQLite: " + finding;
}

void integrity(Connection& connection, CheckReport& report) {
  std::optional<Pages> pages;
  Statement rows(connection, "PRAGMA integrity_check");
  while (rows.step()) {
    std::istringstream lines(rows.text(0));
    for (std::string line; std::getline(lines, line);) {
      const bool is_heading = line.starts_with("*** in database ");
      if (line == "ok" || is_heading) continue;
      report.findings.push_back(with_row(connection, pages, line));
    }
  }
}

void foreign_keys(Connection& connection, CheckReport& report) {
  Statement rows(connection, "PRAGMA foreign_key_check");
  while (rows.step()) {
    report.findings.push_back(rows.text(0) + " row " + rows.text(1) + ": names a row of " +
                              rows.text(2) + " that is not there");
  }
}

// Walks the table itself: through an index SQLite would read the index's copy of seq.
void chain(Connection& connection, const Scheme& scheme, CheckReport& report, std::string& place) {
  struct End {
    Sha256 head{};
    std::int64_t seq = 0;
  };
  std::map<Id, End> ends;
  std::int64_t previous = 0;
  std::string previous_name;
  Statement rows(connection, scheme.readings);
  while (rows.step()) {
    ++report.n_readings;
    End& end = ends[rows.integer(1)];
    Digest digest(scheme.order);
    digest << Bytes(end.head);
    const Sha256 expected = digest.row(rows, scheme.first, scheme.end).finish();
    const Bytes stored = rows.blob(rows.columns() - 1);
    const std::string own_name =
        "reading " + rows.text(0) + " (campaign " + rows.text(1) + ", seq " + rows.text(2) + ")";
    const std::string name = own_name + after(rows.integer(0), previous, previous_name);
    const bool is_blob = sqlite3_column_type(rows.handle(), rows.columns() - 1) == SQLITE_BLOB;
    if (!is_blob || !std::ranges::equal(stored, expected)) {
      report.findings.push_back(name + ": this row, or the one before it, is not what was stored");
    }
    if (rows.integer(2) <= end.seq) report.findings.push_back(name + ": out of order");
    // Readings are numbered one by one and none goes: the digest does not hold the number itself.
    const bool whole = is_blob && std::ranges::equal(stored, expected);
    if (whole && rows.integer(0) != previous + 1) {
      report.findings.push_back(name + ": its number in the file was changed");
    }
    // On with what is stored: then one changed row is named, and not all that follow.
    if (stored.size() == end.head.size()) std::ranges::copy(stored, end.head.begin());
    end.seq = rows.integer(2);
    place = "the row after " + own_name;
    previous = rows.integer(0);
    previous_name = own_name;
  }
}

// The one row that may be without a seal.
bool is_open_attempt(Connection& connection, const Sealed& sealed, Id id) {
  if (sealed.table != "attempt") return false;
  Statement row(connection, "SELECT 1 FROM attempt WHERE attempt_id = ? AND status = 'open'");
  row << id;
  return row.step();
}

// Every row that has a seal is compared with it, whatever it says of itself. Walks the table
// itself.
void seals(Connection& connection, const Sealed& sealed, ByteOrder order, CheckReport& report,
           std::string& place) {
  Statement ids(connection, "SELECT " + sealed.id + " FROM " + sealed.table +
                                " NOT INDEXED ORDER BY " + sealed.id);
  Statement stored(connection, "SELECT sha256 FROM seal WHERE table_name = ? AND row_id = ?");
  Id previous = 0;
  std::string previous_name;
  while (ids.step()) {
    const Id id = ids.integer(0);
    const std::string own_name = sealed.table + " " + std::to_string(id);
    const std::string name = own_name + after(id, previous, previous_name);
    place = "the row after " + own_name;
    previous = id;
    previous_name = own_name;
    guarded(report, name, [&](const std::string&) {
      stored << sealed.table << id;
      const bool has_seal = stored.step();
      if (!has_seal && is_open_attempt(connection, sealed, id)) return;
      ++report.n_sealed;
      if (!has_seal) {
        report.findings.push_back(name + ": has no seal");
      } else if (!std::ranges::equal(stored.blob(0), seal_of(connection, sealed, id, order))) {
        report.findings.push_back(name +
                                  ": this row, or one that belongs to it, is not what was "
                                  "stored");
      }
    });
    stored.reset();
  }
  Statement lost(connection,
                 "SELECT row_id FROM seal WHERE table_name = ? AND row_id NOT IN (SELECT " +
                     sealed.id + " FROM " + sealed.table + ")");
  lost << sealed.table;
  while (lost.step()) {
    report.findings.push_back(sealed.table + " " + lost.text(0) + ": sealed, and not there");
  }
}

// The end of a chain can be cut off without breaking it: the counts tell.
void counts(Connection& connection, CheckReport& report) {
  Statement rows(
      connection,
      "SELECT 'attempt', attempt_id, n_readings, (SELECT count(*) FROM reading WHERE "
      "reading.attempt_id = attempt.attempt_id) AS n FROM attempt WHERE n <> n_readings "
      "UNION ALL SELECT 'session', session_id, n_imported, (SELECT count(*) FROM reading "
      "WHERE reading.session_id = session.session_id AND attempt_id IS NULL) AS n FROM "
      "session WHERE n <> n_imported");
  while (rows.step()) {
    report.findings.push_back(rows.text(0) + " " + rows.text(1) + ": stored " + rows.text(2) +
                              " readings, there are " + rows.text(3));
  }
  // The chain is a campaign's own, and does not hold whose it is.
  Statement strangers(connection,
                      "SELECT reading_id FROM reading JOIN session USING (session_id) WHERE "
                      "reading.campaign_id <> session.campaign_id");
  while (strangers.step()) {
    report.findings.push_back("reading " + strangers.text(0) +
                              ": its session is of another campaign");
  }
}

}  // namespace

CheckReport check(Connection& connection) {
  CheckReport report;
  guarded(report, "the file", [&](const std::string&) { integrity(connection, report); });
  guarded(report, "foreign keys", [&](const std::string&) { foreign_keys(connection, report); });
  return report;
}

CheckReport verify(Connection& connection) {
  CheckReport report = check(connection);
  const Scheme& scheme = scheme_of(version_of(connection));
  guarded(report, "the first row of reading",
          [&](std::string& place) { chain(connection, scheme, report, place); });
  for (const Sealed& sealed : scheme.sealed) {
    guarded(report, "the first row of " + sealed.table,
            [&](std::string& place) { seals(connection, sealed, scheme.order, report, place); });
  }
  guarded(report, "counts", [&](const std::string&) { counts(connection, report); });
  if (report.findings.size() > kMostFindings) {
    const auto more = report.findings.size() - kMostFindings;
    report.findings.resize(kMostFindings);
    report.findings.push_back("and " + std::to_string(more) + " more");
  }
  return report;
}

std::optional<TakenOver> taken_head(Connection& connection, Id campaign_id) {
  Statement row(connection, "SELECT from_version, head FROM taken_over WHERE campaign_id = ?");
  row << campaign_id;
  if (!row.step()) return std::nullopt;
  return TakenOver{static_cast<int>(row.integer(0)), hex(row.blob(1))};
}

bool had_head(Connection& connection, std::string_view head) {
  const bool redrawn = version_of(connection) >= kRedrawn;
  Statement find(
      connection,
      std::string("SELECT 1 FROM reading WHERE hex(sha256) = upper(?1)") +
          (redrawn ? " UNION ALL SELECT 1 FROM taken_over WHERE hex(head) = upper(?1)" : ""));
  find << head;
  return find.step();
}

}  // namespace trammel::store

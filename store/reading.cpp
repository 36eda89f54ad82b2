#include "store/reading.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "store/clock.hpp"
#include "store/job_key.hpp"
#include "store/seal.hpp"
#include "store/stored_json.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

constexpr std::array<const char*, 3> kSets = {"identify", "validate", "predict"};

// Columns of a reading as jobs take it, and after them what else is stored of it.
constexpr const char* kNumbers =
    "seq, session_id, epoch, reading_set, target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, "
    "cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, time_s, "
    "temp_degc";
constexpr const char* kRest =
    ", reading_id, attempt_id, encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, raw_reply, extra_json";
enum Column {
  kSeq,
  kSessionId,
  kEpoch,
  kSet,
  kTarget,
  kCmd = kTarget + 3,
  kFrom = kCmd + 3,
  kMeasured = kFrom + 3,
  kTime = kMeasured + 3,
  kTemp,
  kReadingId,
  kAttemptId,
  kEncoder,
  kRawReply = kEncoder + 3,
  kExtra
};

// Binds a row and digests the same values.
struct Row {
  Statement& statement;
  Digest& digest;

  template <class T>
  Row& operator<<(const T& value) {
    statement << value;
    digest << value;
    return *this;
  }
  // SQLite takes NaN for NULL, and NULL is what is not there.
  static double finite(double value) {
    if (std::isfinite(value)) return value;
    throw StoreError({.what = "the database takes finite numbers alone", .got = "NaN or infinity"});
  }
  /// Of three numbers those that there are.
  Row& triple(const Eigen::Vector3d& values, const Coordinates& there) {
    for (int i = 0; i < 3; ++i) {
      if (there[static_cast<std::size_t>(i)]) {
        *this << finite(values[i]);
      } else {
        *this << std::nullopt;
      }
    }
    return *this;
  }
};

constexpr Coordinates kNone = {};
Coordinates first(int n) { return {n > 0, n > 1, n > 2}; }

Pose pose_at(const Statement& row, int column) {
  return {row.real(column), row.real(column + 1), row.real(column + 2)};
}

Displacements displacements_at(const Statement& row, int column) {
  return {row.real(column), row.real(column + 1), row.real(column + 2)};
}

// A drive or a coordinate that the machine has not is nobody's to state.
void require_absent(const Eigen::Vector3d& values, const Coordinates& there, const char* what,
                    int seq) {
  for (int i = 0; i < 3; ++i) {
    if (there[static_cast<std::size_t>(i)] || values[i] == 0) continue;
    throw InputError({.what = std::string(what) + " that the campaign's machine has not",
                      .where = {.point = "seq " + std::to_string(seq)},
                      .got = std::to_string(values[i])});
  }
}

// The CHECK on its length binds who wrote the row, not who changed the file.
Sha256 sha256_at(const Statement& row, int column) {
  const Bytes stored = row.blob(column);
  Sha256 sha256{};
  if (stored.size() != sha256.size()) {
    throw StoreError(
        {.what = "a reading's digest is not whole", .hint = "see `trammel db verify`"});
  }
  std::ranges::copy(stored, sha256.begin());
  return sha256;
}

Reading reading_at(const Statement& row) {
  Reading reading{.seq = static_cast<int>(row.integer(kSeq)),
                  .set = reading_set(row.text(kSet)),
                  .target = pose_at(row, kTarget),
                  .conditions = {.cmd_mm = displacements_at(row, kCmd),
                                 .from_mm = displacements_at(row, kFrom),
                                 .epoch = static_cast<int>(row.integer(kEpoch)),
                                 .time_s = row.optional_real(kTime),
                                 .temp_degc = row.optional_real(kTemp)},
                  .measured = {}};
  if (reading.set != ReadingSet::predict) reading.measured = pose_at(row, kMeasured);
  return reading;
}

StoredReading stored_at(const Statement& row) {
  StoredReading stored{.reading_id = row.integer(kReadingId),
                       .session_id = row.integer(kSessionId),
                       .attempt_id = row.optional_integer(kAttemptId),
                       .data = {.reading = reading_at(row)}};
  if (!row.is_null(kEncoder)) stored.data.encoder_mm = displacements_at(row, kEncoder);
  stored.data.raw_reply = row.optional_text(kRawReply);
  if (!row.is_null(kExtra)) stored.data.extra_json = stored_json(row, kExtra);
  return stored;
}

/// Calls `take(row)` for each of the campaign's readings in these sessions (empty: all), by seq.
template <class Take>
void for_each_row(Connection& connection, const std::string& columns, Id campaign_id,
                  const std::vector<Id>& sessions, const Take& take) {
  Statement rows(connection,
                 "SELECT " + columns + " FROM reading WHERE campaign_id = ? ORDER BY seq");
  rows << campaign_id;
  while (rows.step()) {
    if (sessions.empty() || std::ranges::count(sessions, rows.integer(kSessionId)) > 0) take(rows);
  }
}

}  // namespace

const char* const kChainedReadings =
    "SELECT reading_id, reading.campaign_id, reading.seq, session.name, epoch, point.seq, "
    "attempt.number, reading.reading_set, reading.target_x_mm, reading.target_y_mm, "
    "reading.target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm, "
    "x_mm, y_mm, phi_rad, encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, time_s, temp_degc, "
    "raw_reply, extra_json, sha256 FROM reading NOT INDEXED "
    "LEFT JOIN session ON session.session_id = reading.session_id "
    "LEFT JOIN attempt USING (attempt_id) LEFT JOIN point USING (point_id) ORDER BY reading_id";

const char* name_of(ReadingSet set) { return kSets[static_cast<std::size_t>(set)]; }

ReadingSet reading_set(std::string_view name) {
  const auto found = std::ranges::find(kSets, name);
  if (found == kSets.end()) {
    throw InputError({.what = "unknown set of readings",
                      .got = std::string(name),
                      .expected = "identify, validate or predict"});
  }
  return static_cast<ReadingSet>(found - kSets.begin());
}

namespace {

constexpr const char* kStoredColumns =
    "reading_id, campaign_id, session_id, attempt_id, seq, epoch, reading_set, target_x_mm, "
    "target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, "
    "from_l3_mm, x_mm, y_mm, phi_rad, encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, time_s, "
    "temp_degc, raw_reply, extra_json, sha256";

std::string insert_of(std::size_t rows) {
  const std::string row = "(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)";
  std::string sql = std::string("INSERT INTO reading (") + kStoredColumns + ") VALUES " + row;
  for (; rows > 1; --rows) sql += "," + row;
  return sql;
}

}  // namespace

Shape shape_of(Connection& connection, Id campaign_id) {
  Statement row(connection,
                "SELECT (SELECT count(*) FROM drive WHERE drive.campaign_id = "
                "machine.campaign_id), measures_x, measures_y, measures_phi FROM machine WHERE "
                "campaign_id = ?");
  row << campaign_id;
  if (!row.step()) throw NotFoundError({.what = "no such campaign"});
  return {static_cast<int>(row.integer(0)),
          {row.integer(1) != 0, row.integer(2) != 0, row.integer(3) != 0}};
}

ReadingWriter::ReadingWriter(Connection& connection, Id campaign_id)
    : connection_(connection),
      insert_(connection, insert_of(1)),
      campaign_id_(campaign_id),
      shape_(shape_of(connection, campaign_id)) {
  Statement largest(connection, "SELECT coalesce(max(reading_id), 0) FROM reading");
  if (largest.step()) end_.next_id = largest.integer(0) + 1;
  Statement last(connection,
                 "SELECT seq FROM reading WHERE campaign_id = ? ORDER BY seq DESC LIMIT 1");
  last << campaign_id;
  if (last.step()) end_.seq = static_cast<int>(last.integer(0));
  end_.head = chain_head(connection, campaign_id);
}

ReadingWriter::Belongs ReadingWriter::belongs(Id session_id, std::optional<Id> attempt_id) {
  Belongs to;
  to.session_id = session_id;
  to.attempt_id = attempt_id;
  Statement session(connection_, "SELECT name FROM session WHERE session_id = ?");
  session << session_id;
  if (session.step()) to.session = session.text(0);
  if (!attempt_id) return to;
  Statement attempt(connection_,
                    "SELECT seq, number FROM attempt JOIN point USING (point_id) WHERE "
                    "attempt_id = ?");
  attempt << *attempt_id;
  if (!attempt.step()) return to;
  to.point = attempt.integer(0);
  to.attempt = attempt.integer(1);
  return to;
}

int ReadingWriter::bind(Statement& insert, const NewReading& data, const Belongs& to) {
  if (data.extra_json) static_cast<void>(canonical_json(*data.extra_json, "extra_json"));
  const Reading& reading = data.reading;
  const int seq = reading.seq > 0 ? reading.seq : end_.seq + 1;
  const Coordinates drives = first(shape_.drives);
  const Eigen::Vector3d measured = reading.measured.value_or(Pose{}).vector();
  require_absent(reading.target.vector(), drives, "a coordinate of the target", seq);
  require_absent(reading.conditions.cmd_mm, drives, "a command of a drive", seq);
  require_absent(measured, shape_.measured, "a coordinate", seq);
  Digest digest;
  digest << Bytes(end_.head) << seq << to.session << reading.conditions.epoch << to.point
         << to.attempt;
  insert << end_.next_id << campaign_id_ << to.session_id << to.attempt_id << seq
         << reading.conditions.epoch;
  Row row{insert, digest};
  row << name_of(reading.set);
  row.triple(reading.target.vector(), drives)
      .triple(reading.conditions.cmd_mm, drives)
      .triple(reading.conditions.from_mm, drives)
      .triple(measured, reading.measured ? shape_.measured : kNone)
      .triple(data.encoder_mm.value_or(Displacements::Zero()), data.encoder_mm ? drives : kNone);
  row << reading.conditions.time_s << reading.conditions.temp_degc << data.raw_reply
      << data.extra_json;
  end_ = {.next_id = end_.next_id + 1, .seq = seq, .head = digest.finish()};
  insert << Bytes(end_.head);
  return seq;
}

int ReadingWriter::add(const NewReading& data, Id session_id, std::optional<Id> attempt_id) {
  return add(data, belongs(session_id, attempt_id));
}

int ReadingWriter::add(const NewReading& data, const Belongs& to) {
  const End before = end_;
  try {
    insert_.reset();
    const int seq = bind(insert_, data, to);
    insert_.run();
    return seq;
  } catch (...) {
    end_ = before;
    throw;
  }
}

void ReadingWriter::add_all(std::span<const NewReading> all, Id session_id) {
  static const std::string sql = insert_of(kBatch);
  Statement many(connection_, sql);
  const Belongs to = belongs(session_id, {});
  for (; all.size() >= kBatch; all = all.subspan(kBatch)) {
    const End before = end_;
    try {
      many.reset();
      for (const NewReading& data : all.first(kBatch)) bind(many, data, to);
      many.run();
    } catch (const Error&) {  // none of them is stored: one by one tells which
      end_ = before;
      break;
    }
  }
  for (const NewReading& data : all) {
    try {
      add(data, to);
    } catch (const StoreError& error) {
      ErrorText text = error.text();
      text.where.point = "seq " + std::to_string(data.reading.seq);
      throw InputError(std::move(text));
    }
  }
}

std::vector<StoredReading> readings(Connection& connection, Id campaign_id,
                                    const std::vector<Id>& sessions) {
  std::vector<StoredReading> all;
  for_each_row(connection, std::string(kNumbers) + kRest, campaign_id, sessions,
               [&](const Statement& row) { all.push_back(stored_at(row)); });
  return all;
}

std::vector<SessionReading> session_readings(Connection& connection, Id campaign_id,
                                             const std::vector<Id>& sessions) {
  std::vector<SessionReading> all;
  all.reserve(128);  // as most campaigns have
  for_each_row(connection, kNumbers, campaign_id, sessions, [&](const Statement& row) {
    all.push_back({row.integer(kSessionId), reading_at(row)});
  });
  return all;
}

Sha256 chain_head(Connection& connection, Id campaign_id) {
  Statement last(connection,
                 "SELECT sha256 FROM reading WHERE campaign_id = ? ORDER BY seq DESC LIMIT 1");
  last << campaign_id;
  return last.step() ? sha256_at(last, 0) : Sha256{};
}

Id exclude_reading(Connection& connection, Id campaign_id, int seq, std::string_view reason) {
  if (reason.find_first_not_of(" \t\r\n") == std::string_view::npos || reason.size() > 1000) {
    throw InputError({.what = "an exclusion needs a reason",
                      .where = {.field = "reason"},
                      .expected = "1 to 1000 characters"});
  }
  Transaction transaction(connection);
  Statement find(
      connection,
      "SELECT exclusion.reason FROM reading LEFT JOIN exclusion USING (campaign_id, seq) "
      "WHERE campaign_id = ? AND seq = ?");
  find << campaign_id << seq;
  const std::string point = "seq " + std::to_string(seq);
  if (!find.step()) throw NotFoundError({.what = "no such reading", .where = {.point = point}});
  if (!find.is_null(0)) {
    throw InputError({.what = "this reading is excluded already",
                      .where = {.point = point},
                      .got = find.text(0)});
  }
  Statement insert(
      connection, "INSERT INTO exclusion (campaign_id, seq, reason, created_utc) VALUES (?,?,?,?)");
  insert << campaign_id << seq << reason << utc_now();
  const Id id = insert.run();
  seal(connection, "exclusion", id);
  transaction.commit();
  return id;
}

std::vector<Exclusion> exclusions(Connection& connection, Id campaign_id) {
  std::vector<Exclusion> all;
  Statement rows(
      connection,
      "SELECT exclusion_id, seq, reason, created_utc FROM exclusion WHERE campaign_id = ? "
      "ORDER BY seq");
  rows << campaign_id;
  while (rows.step()) {
    all.push_back({rows.integer(0), static_cast<int>(rows.integer(1)), rows.text(2), rows.text(3)});
  }
  return all;
}

}  // namespace trammel::store

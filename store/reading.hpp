#pragma once
// Raw readings: added, chained, never changed. Exclusions name those that jobs leave out.

#include <map>
#include <vector>

#include "core/measure/reading.hpp"
#include "store/digest.hpp"
#include "store/statement.hpp"

namespace trammel::store {

/// A reading to store. The store gives it its seq (if 0) and its epoch (if it has an attempt).
struct NewReading {
  Reading reading = {};
  std::optional<Displacements> encoder_mm = {};
  std::optional<std::string> raw_reply = {};
  std::optional<std::string> extra_json = {};
};

struct StoredReading {
  Id reading_id = 0;
  Id session_id = 0;
  std::optional<Id> attempt_id;
  NewReading data;
};

struct Exclusion {
  Id id = 0;
  int seq = 0;
  std::string reason;
  std::string created_utc;
};

/// Adds readings of one campaign, in a transaction of the caller's, and keeps the chain's end.
class ReadingWriter {
 public:
  ReadingWriter(Connection& connection, Id campaign_id);

  /// Returns the reading's seq.
  /// @throws StoreError  the database refuses it: a number that is not finite or out of bounds
  int add(const NewReading& reading, Id session_id, std::optional<Id> attempt_id);

  /// Readings without an attempt. kBatch of them go in one statement: what SQLite does once a
  /// statement is a third of its work.
  /// @throws InputError  the reading that the database refuses, by its seq
  void add_all(std::span<const NewReading> all, Id session_id);
  static constexpr std::size_t kBatch = 32;

 private:
  struct End {
    Id next_id = 1;
    int seq = 0;
    Sha256 head{};
  };
  int bind(Statement& insert, const NewReading& reading, Id session_id, std::optional<Id> attempt);
  Connection& connection_;
  Statement insert_;
  Id campaign_id_;
  End end_;
};

/// The campaign's readings in the order of seq, of these sessions (empty: all), excluded ones too.
std::vector<StoredReading> readings(Connection& connection, Id campaign_id,
                                    const std::vector<Id>& sessions = {});

/// The same without what came with the numbers, for jobs.
struct SessionReading {
  Id session_id = 0;
  Reading reading;
};
std::vector<SessionReading> session_readings(Connection& connection, Id campaign_id,
                                             const std::vector<Id>& sessions = {});

/// The chain's end: SHA-256 over all that was read, in order. Zeros for a campaign without
/// readings.
Sha256 chain_head(Connection& connection, Id campaign_id);

/// What stands in the chain for `row`, a row of `SELECT kReadingColumns FROM reading`, after
/// `head`.
extern const char* const kReadingColumns;
Sha256 chained(const Sha256& head, const Statement& row);

/// Marks a reading to be left out by later jobs. It stays stored.
/// @throws NotFoundError  no such reading
/// @throws InputError     no reason, or excluded already
Id exclude_reading(Connection& connection, Id campaign_id, int seq, std::string_view reason);
std::vector<Exclusion> exclusions(Connection& connection, Id campaign_id);

/// "identify", "validate", "predict".
const char* name_of(ReadingSet set);
ReadingSet reading_set(std::string_view name);

}  // namespace trammel::store

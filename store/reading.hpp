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

/// How many drives a campaign's readings have, and which coordinates are measured. The rest is NULL
/// in the file, and 0 in memory.
struct Shape {
  int drives = 3;
  Coordinates measured = {true, true, true};
};
Shape shape_of(Connection& connection, Id campaign_id);

/// Adds readings of one campaign, in a transaction of the caller's, and keeps the chain's end.
class ReadingWriter {
 public:
  /// @throws InputError (of add)  a drive or a coordinate that the campaign's machine has not
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
  /// Where a reading belongs, by natural keys: they go into the digest.
  struct Belongs {
    Id session_id = 0;
    std::string session = {};
    std::optional<Id> attempt_id = {};
    std::optional<std::int64_t> point = {}, attempt = {};
  };
  Belongs belongs(Id session_id, std::optional<Id> attempt_id);
  int bind(Statement& insert, const NewReading& reading, const Belongs& to);
  int add(const NewReading& reading, const Belongs& to);
  Connection& connection_;
  Statement insert_;
  Id campaign_id_;
  Shape shape_;
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

/// The chain's end: SHA-256 over all that was read, in order, from zeros. Equal
/// readings have equal heads, whatever campaign they are of: the seal of that holds its uuid.
Sha256 chain_head(Connection& connection, Id campaign_id);

/// Readings as the chain has them: reading_id, campaign_id, then what is digested, from
/// kFirstChained to kEndChained, then sha256.
extern const char* const kChainedReadings;
inline constexpr int kFirstChained = 2, kEndChained = 27;

/// Marks a reading to be left out by later jobs. It stays stored.
/// @throws NotFoundError  no such reading
/// @throws InputError     no reason, or excluded already
Id exclude_reading(Connection& connection, Id campaign_id, int seq, std::string_view reason);
std::vector<Exclusion> exclusions(Connection& connection, Id campaign_id);

/// "identify", "validate", "predict".
const char* name_of(ReadingSet set);
ReadingSet reading_set(std::string_view name);

}  // namespace trammel::store

#pragma once
// The bytes that digests are taken over, as bytes: what leaves the file carries them.

#include <variant>
#include <vector>

#include "store/seal.hpp"

namespace trammel::store {

using Blob = std::vector<unsigned char>;
using Value = std::variant<std::monostate, std::int64_t, double, std::string, Blob>;

/// The row's columns from `first` to before `end`, as Digest takes them.
std::string canonical_bytes(const Statement& row, int first, int end);

/// A sealed row with its parts.
struct CanonicalRow {
  std::string table;
  std::string key;      // the bytes of its natural key, with which those of its values begin
  std::vector<Id> ids;  // the file's own numbers: of the row, then of its points
  std::vector<std::int32_t> n_rows;  // of each part
  std::string bytes;                 // SHA-256 of these is its seal
};

/// Of the row with this number, as it stands. Proof: canonical_test.cpp.
CanonicalRow canonical_row(Connection& connection, const Sealed& sealed, Id id);

/// kChainedReadings of the campaign ?1 beyond seq ?2, in the order of seq.
std::string chained_readings_beyond();

/// The sealed rows of a campaign: its number ?1; table, number and seal of each.
extern const char* const kSealedRowsOfCampaign;

/// Takes canonical bytes apart, value by value.
/// @throws InputError  they end within a value, or hold one of an unknown kind
class CanonicalReader {
 public:
  explicit CanonicalReader(std::string_view bytes) : rest_(bytes) {}
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  Value next();

 private:
  std::string_view take(std::size_t size);
  std::uint64_t number();
  std::string_view rest_;
};

}  // namespace trammel::store

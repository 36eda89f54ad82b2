#pragma once
// How a version of the schema digests its rows.

#include "store/seal.hpp"

namespace trammel::store {

/// The version that was redrawn: complete in itself, and made from older files by copying alone.
inline constexpr int kRedrawn = 5;

/// Until version 4 digests were taken over little-endian bytes and the file's own numbers of rows.
struct Scheme {
  ByteOrder order = ByteOrder::big;
  /// Columns 0 to 2: reading_id, campaign_id, seq. Digested: from `first` to before `end`, then
  /// sha256.
  std::string readings;
  int first = 0, end = 0;
  std::vector<Sealed> sealed;
};
const Scheme& scheme_of(int version);

}  // namespace trammel::store

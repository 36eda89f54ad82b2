#pragma once
// SHA-256 of a row with all its parts, stored once and recomputed by `db verify`.

#include <vector>

#include "store/digest.hpp"

namespace trammel::store {

/// A table whose rows are sealed, and what belongs to a row: each query takes its id as ?1. All
/// columns count but the file's own numbers of rows: they stand as the natural key of the row that
/// they name, so that a row has the same digest in every file. A later version adds tables, never a
/// column to one of these (verify_test.cpp).
struct Sealed {
  std::string table;
  std::string id;
  std::vector<std::string> rows;
};
const std::vector<Sealed>& sealed_tables();

/// Writes the seal of a row, in the transaction that wrote the row.
void seal(Connection& connection, std::string_view table, Id id);

/// What the seal of the row as it stands would be.
Sha256 seal_of(Connection& connection, const Sealed& sealed, Id id,
               ByteOrder order = ByteOrder::big);

}  // namespace trammel::store

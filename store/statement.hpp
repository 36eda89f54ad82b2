#pragma once
// One prepared statement: bind, step, read columns.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "store/connection.hpp"

namespace trammel::store {

using Id = std::int64_t;
using Bytes = std::span<const unsigned char>;

/// Prepared once per connection and text, and reused; reset and given back when it goes.
class Statement {
 public:
  Statement(Connection& connection, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// Binds the next parameter. A number that is not finite becomes NULL or infinity in SQLite,
  /// which the table's CHECK refuses.
  Statement& operator<<(std::int64_t value);
  Statement& operator<<(int value) { return *this << std::int64_t{value}; }
  Statement& operator<<(bool value) { return *this << std::int64_t{value}; }
  Statement& operator<<(double value);
  Statement& operator<<(std::string_view value);
  Statement& operator<<(const std::string& value) { return *this << std::string_view(value); }
  Statement& operator<<(const char* value) { return *this << std::string_view(value); }
  Statement& operator<<(Bytes value);
  Statement& operator<<(std::nullopt_t);
  template <class T>
  Statement& operator<<(const std::optional<T>& value) {
    return value ? *this << *value : *this << std::nullopt;
  }

  /// True while there is a row.
  [[nodiscard]] bool step();
  /// For statements without rows. Returns the rowid of an INSERT.
  Id run();
  /// Ready for the next row of parameters.
  void reset();

  [[nodiscard]] int columns() const;
  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] Bytes blob(int column) const;
  [[nodiscard]] std::optional<double> optional_real(int column) const;
  [[nodiscard]] std::optional<std::int64_t> optional_integer(int column) const;
  [[nodiscard]] std::optional<std::string> optional_text(int column) const;

  [[nodiscard]] sqlite3_stmt* handle() const { return statement_; }

 private:
  void check(int code) const;
  Connection& connection_;
  std::string sql_;
  sqlite3_stmt* statement_ = nullptr;
  int next_ = 1;
};

}  // namespace trammel::store

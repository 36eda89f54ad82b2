#pragma once
// SHA-256 over typed values, so that two different rows never give the same bytes.

#include <array>
#include <string>

#include "store/sha256.hpp"
#include "store/statement.hpp"

namespace trammel::store {

using Sha256 = std::array<unsigned char, 32>;

enum class ByteOrder { big, little };

/// Each value goes in as a type letter and its bytes: n; i and 8 bytes; r and the 8 bytes of the
/// IEEE double; t or b, 8 bytes of length and the bytes. Integers big-endian (little-endian in
/// databases before version 5). SQLite does not keep the sign of zero: -0.0 goes in as 0.0, so that
/// a value gives the same digest before and after it was stored.
class Digest {
 public:
  explicit Digest(ByteOrder order = ByteOrder::big) : order_(order) {}
  Digest& operator<<(std::nullopt_t);
  Digest& operator<<(std::int64_t value);
  Digest& operator<<(int value) { return *this << std::int64_t{value}; }
  Digest& operator<<(double value);
  Digest& operator<<(std::string_view value);
  Digest& operator<<(const std::string& value) { return *this << std::string_view(value); }
  Digest& operator<<(const char* value) { return *this << std::string_view(value); }
  Digest& operator<<(Bytes value);
  template <class T>
  Digest& operator<<(const std::optional<T>& value) {
    return value ? *this << *value : *this << std::nullopt;
  }
  /// The row's columns from `first` to before `end`, as SQLite holds them.
  Digest& row(const Statement& statement, int first, int end);
  Sha256 finish();

 private:
  void add(char type, const void* bytes, std::size_t size);
  void add_number(char type, std::uint64_t bits);
  void append(const void* bytes, std::size_t size);
  [[nodiscard]] std::array<unsigned char, 8> bytes_of(std::uint64_t value) const;
  ByteOrder order_;
  Sha256State state_ = kSha256Start;
  std::array<unsigned char, 16 * kSha256BlockBytes> buffer_;  // a reading fits
  std::size_t filled_ = 0;
  std::uint64_t n_bytes_ = 0;
};

/// 64 lower-case digits.
std::string hex(Bytes bytes);

/// Of bytes as they are: what sha256sum prints of a file.
Sha256 sha256_of(std::string_view bytes);

}  // namespace trammel::store

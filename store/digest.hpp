#pragma once
// SHA-256 over typed values, so that two different rows never give the same bytes.

#include <array>
#include <bit>
#include <string>

#include "store/sha256.hpp"
#include "store/statement.hpp"

namespace trammel::store {

using Sha256 = std::array<unsigned char, 32>;

enum class ByteOrder { big, little };

/// Puts values as canonical bytes into a sink, by `append(bytes, size)`: each as a type letter and
/// its bytes: n; i and 8 bytes; r and the 8 bytes of the IEEE double; t or b, 8 bytes of length and
/// the bytes. Integers big-endian (little-endian in databases before version 5). SQLite does not
/// keep the sign of zero: -0.0 goes in as 0.0, so that a value gives the same bytes before and
/// after it was stored.
template <class Sink>
class Canonical {
 public:
  explicit Canonical(ByteOrder order) : order_(order) {}
  Sink& operator<<(std::nullopt_t) { return put('n', "", 0); }
  Sink& operator<<(std::int64_t value) { return put('i', static_cast<std::uint64_t>(value)); }
  Sink& operator<<(int value) { return *this << std::int64_t{value}; }
  Sink& operator<<(double value) { return put('r', std::bit_cast<std::uint64_t>(value + 0.0)); }
  Sink& operator<<(std::string_view value) { return put_sized('t', value.data(), value.size()); }
  Sink& operator<<(const std::string& value) { return *this << std::string_view(value); }
  Sink& operator<<(const char* value) { return *this << std::string_view(value); }
  Sink& operator<<(Bytes value) { return put_sized('b', value.data(), value.size()); }
  template <class T>
  Sink& operator<<(const std::optional<T>& value) {
    return value ? *this << *value : *this << std::nullopt;
  }
  /// The row's columns from `first` to before `end`, as SQLite holds them.
  Sink& row(const Statement& statement, int first, int end);

 protected:
  [[nodiscard]] std::array<unsigned char, 8> bytes_of(std::uint64_t value) const {
    std::array<unsigned char, 8> bytes{};
    for (unsigned i = 0; i < 8; ++i) {
      bytes[i] =
          static_cast<unsigned char>(value >> (order_ == ByteOrder::big ? 56 - 8 * i : 8 * i));
    }
    return bytes;
  }

 private:
  Sink& put(char type, const void* bytes, std::size_t size) {
    auto& sink = static_cast<Sink&>(*this);
    sink.append(&type, 1);
    sink.append(bytes, size);
    return sink;
  }
  Sink& put(char type, std::uint64_t bits) {
    const std::array<unsigned char, 8> bytes = bytes_of(bits);
    return put(type, bytes.data(), bytes.size());
  }
  Sink& put_sized(char type, const void* bytes, std::size_t size) {
    put(type, size);
    auto& sink = static_cast<Sink&>(*this);
    sink.append(bytes, size);
    return sink;
  }
  ByteOrder order_;
};

/// SHA-256 over canonical bytes.
class Digest : public Canonical<Digest> {
 public:
  explicit Digest(ByteOrder order = ByteOrder::big) : Canonical(order) {}
  Sha256 finish();

 private:
  friend Canonical<Digest>;
  void append(const void* bytes, std::size_t size);
  Sha256State state_ = kSha256Start;
  std::array<unsigned char, 16 * kSha256BlockBytes> buffer_;  // a reading fits
  std::size_t filled_ = 0;
  std::uint64_t n_bytes_ = 0;
};

/// The canonical bytes themselves.
class CanonicalText : public Canonical<CanonicalText> {
 public:
  CanonicalText() : Canonical(ByteOrder::big) {}
  std::string bytes;

 private:
  friend Canonical<CanonicalText>;
  void append(const void* from, std::size_t size) {
    bytes.append(static_cast<const char*>(from), size);
  }
};

/// 64 lower-case digits.
std::string hex(Bytes bytes);

/// Of bytes as they are: what sha256sum prints of a file.
Sha256 sha256_of(std::string_view bytes);

}  // namespace trammel::store

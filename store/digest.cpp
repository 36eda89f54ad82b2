#include "store/digest.hpp"

#include <sqlite3.h>

#include <bit>
#include <cstring>

namespace trammel::store {

namespace {

std::array<unsigned char, 8> little_endian(std::uint64_t value) {
  std::array<unsigned char, 8> bytes{};
  for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<unsigned char>(value >> (8 * i));
  return bytes;
}

}  // namespace

Digest::Digest() { crypto_hash_sha256_init(&state_); }

void Digest::flush() {
  crypto_hash_sha256_update(&state_, buffer_.data(), filled_);
  filled_ = 0;
}

void Digest::add(char type, const void* bytes, std::size_t size) {
  constexpr std::size_t kHead = 9;  // letter and length
  if (filled_ + kHead + size > buffer_.size()) flush();
  buffer_[filled_++] = static_cast<unsigned char>(type);
  if (type == 't' || type == 'b') {
    const auto length = little_endian(size);
    std::memcpy(buffer_.data() + filled_, length.data(), length.size());
    filled_ += length.size();
  }
  if (filled_ + size > buffer_.size()) {
    flush();
    crypto_hash_sha256_update(&state_, static_cast<const unsigned char*>(bytes), size);
  } else if (size > 0) {
    std::memcpy(buffer_.data() + filled_, bytes, size);
    filled_ += size;
  }
}

Digest& Digest::operator<<(std::nullopt_t) {
  add('n', nullptr, 0);
  return *this;
}

Digest& Digest::operator<<(std::int64_t value) {
  const auto bytes = little_endian(static_cast<std::uint64_t>(value));
  add('i', bytes.data(), bytes.size());
  return *this;
}

Digest& Digest::operator<<(double value) {
  const auto bytes = little_endian(std::bit_cast<std::uint64_t>(value + 0.0));
  add('r', bytes.data(), bytes.size());
  return *this;
}

Digest& Digest::operator<<(std::string_view value) {
  add('t', value.data(), value.size());
  return *this;
}

Digest& Digest::operator<<(Bytes value) {
  add('b', value.data(), value.size());
  return *this;
}

Digest& Digest::row(const Statement& statement, int columns) {
  for (int column = 0; column < columns; ++column) {
    switch (sqlite3_column_type(statement.handle(), column)) {
      case SQLITE_INTEGER:
        *this << statement.integer(column);
        break;
      case SQLITE_FLOAT:
        *this << statement.real(column);
        break;
      case SQLITE_TEXT:
        *this << statement.text(column);
        break;
      case SQLITE_BLOB:
        *this << statement.blob(column);
        break;
      default:
        *this << std::nullopt;
    }
  }
  return *this;
}

Sha256 Digest::finish() {
  flush();
  Sha256 result{};
  crypto_hash_sha256_final(&state_, result.data());
  return result;
}

std::string hex(Bytes bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) text += {digits[byte >> 4U], digits[byte & 15U]};
  return text;
}

}  // namespace trammel::store

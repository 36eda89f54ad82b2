#include "store/digest.hpp"

#include <sodium/crypto_hash_sha256.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>

namespace trammel::store {

void Digest::append(const void* bytes, std::size_t size) {
  const auto* from = static_cast<const unsigned char*>(bytes);
  n_bytes_ += size;
  while (size > 0) {
    const std::size_t n = std::min(size, buffer_.size() - filled_);
    std::memcpy(buffer_.data() + filled_, from, n);
    filled_ += n;
    from += n;
    size -= n;
    if (filled_ < buffer_.size()) return;
    sha256_blocks(state_, buffer_.data(), buffer_.size() / kSha256BlockBytes);
    filled_ = 0;
  }
}

template <class Sink>
Sink& Canonical<Sink>::row(const Statement& statement, int first, int end) {
  for (int column = first; column < end; ++column) {
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
  return static_cast<Sink&>(*this);
}

template class Canonical<Digest>;
template class Canonical<CanonicalText>;

// The padding of FIPS 180-4, 5.1.1: a bit, zeros, the length in bits.
Sha256 Digest::finish() {
  const std::uint64_t n_bits = 8 * n_bytes_;
  constexpr std::array<unsigned char, kSha256BlockBytes> padding{0x80};
  constexpr std::size_t kLengthBytes = 8;
  const std::size_t used = (filled_ + kLengthBytes) % kSha256BlockBytes;
  append(padding.data(), kSha256BlockBytes - used);
  std::array<unsigned char, kLengthBytes> length{};
  for (unsigned i = 0; i < kLengthBytes; ++i) {
    length[i] = static_cast<unsigned char>(n_bits >> (56 - 8 * i));
  }
  append(length.data(), length.size());
  sha256_blocks(state_, buffer_.data(), filled_ / kSha256BlockBytes);
  Sha256 result{};
  for (std::size_t k = 0; k < result.size(); ++k) {
    result[k] = static_cast<unsigned char>(state_[k / 4] >> (24 - 8 * (k % 4)));
  }
  return result;
}

std::string hex(Bytes bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) text += {digits[byte >> 4U], digits[byte & 15U]};
  return text;
}

Sha256 sha256_of(std::string_view bytes) {
  Sha256 digest;
  crypto_hash_sha256(digest.data(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size());
  return digest;
}

}  // namespace trammel::store

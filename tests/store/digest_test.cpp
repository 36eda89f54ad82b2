#include "store/digest.hpp"

#include <sodium/crypto_hash_sha256.h>

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/skip.hpp"

using namespace trammel::store;

TEST_CASE("SHA-256 of nothing is the published value", "[store]") {
  CHECK(hex(Digest().finish()) ==
        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");  // FIPS 180-4
}

TEST_CASE("a digest of any length is that of libsodium in one piece", "[store]") {
  trammel::Random random(18);
  for (std::size_t size = 0; size < 2200; size += size < 200 ? 1 : 37) {
    std::string text(size, ' ');
    for (char& c : text) c = static_cast<char>(random.below(256));
    std::string whole = "t";
    for (unsigned k = 8; k-- > 0;) whole += static_cast<char>(size >> 8 * k);
    whole += text;
    Sha256 expected{};
    crypto_hash_sha256(expected.data(), reinterpret_cast<const unsigned char*>(whole.data()),
                       whole.size());
    INFO(size);
    CHECK((Digest() << text).finish() == expected);
  }
}

TEST_CASE("the CPU's own SHA-256 gives the bits of libsodium", "[store]") {
  if (!has_sha256()) {
    return trammel::tests::skip("this CPU has no instructions for SHA-256");
  }
  trammel::Random random(19);
  std::vector<unsigned char> blocks(9 * kSha256BlockBytes);
  for (int trial = 0; trial < 200; ++trial) {
    for (auto& byte : blocks) byte = static_cast<unsigned char>(random.below(256));
    const auto n = static_cast<std::size_t>(random.below(10));
    Sha256State a = kSha256Start, b = kSha256Start;
    a[3] = b[3] = static_cast<std::uint32_t>(random.below(1U << 31U));
    sha256_by_cpu(a, blocks.data(), n);
    sha256_by_libsodium(b, blocks.data(), n);
    CHECK(a == b);
    CHECK((n == 0) == (b[0] == kSha256Start[0]));
  }
}

TEST_CASE("values of different types or borders never digest alike", "[store]") {
  const auto of = [](auto... values) {
    Digest digest;
    (digest << ... << values);
    return hex(digest.finish());
  };
  CHECK(of("ab", "c") != of("a", "bc"));
  CHECK(of(1) != of(1.0));
  CHECK(of("") != of(std::nullopt));
  CHECK(of(1.0) != of(1.0 + 1e-15));
  CHECK(of(-0.0) == of(0.0));  // SQLite keeps no sign of zero
}

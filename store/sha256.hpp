#pragma once
// The compression function of SHA-256 (FIPS 180-4, 6.2.2). A laboratory's readings are all hashed:
// in the CPU's own instructions that costs a tenth.

#include <array>
#include <cstddef>
#include <cstdint>

namespace trammel::store {

using Sha256State = std::array<std::uint32_t, 8>;

/// H(0) of FIPS 180-4, 5.3.3.
constexpr Sha256State kSha256Start = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
constexpr std::size_t kSha256BlockBytes = 64;

/// Takes `n` blocks into the state. Both give the same bits (digest_test.cpp); sha256_by_cpu() is
/// only for a CPU that has_sha256().
void sha256_by_libsodium(Sha256State& state, const unsigned char* blocks, std::size_t n);
void sha256_by_cpu(Sha256State& state, const unsigned char* blocks, std::size_t n);
bool has_sha256();

/// By the CPU where it can.
void sha256_blocks(Sha256State& state, const unsigned char* blocks, std::size_t n);

}  // namespace trammel::store

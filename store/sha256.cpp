#include "store/sha256.hpp"

#include <sodium/crypto_hash_sha256.h>

#include <algorithm>

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace trammel::store {

void sha256_by_libsodium(Sha256State& state, const unsigned char* blocks, std::size_t n) {
  crypto_hash_sha256_state as_theirs{};  // at the border of a block
  std::ranges::copy(state, as_theirs.state);
  crypto_hash_sha256_update(&as_theirs, blocks, n * kSha256BlockBytes);
  std::ranges::copy(as_theirs.state, state.begin());
}

#if defined(__x86_64__)

namespace {

// FIPS 180-4, 4.2.2.
alignas(16) constexpr std::array<std::uint32_t, 64> kRound = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

const __m128i* four(const void* from) { return static_cast<const __m128i*>(from); }

}  // namespace

// Registers hold four words: the state as (F E B A) and (H G D C), as the instructions want it.
[[gnu::target("sha,sse4.1")]] void sha256_by_cpu(Sha256State& state, const unsigned char* blocks,
                                                 std::size_t n) {
  const __m128i big_endian = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
  const __m128i badc = _mm_shuffle_epi32(_mm_loadu_si128(four(&state[0])), 0xB1);
  const __m128i hgfe = _mm_shuffle_epi32(_mm_loadu_si128(four(&state[4])), 0x1B);
  __m128i feba = _mm_alignr_epi8(badc, hgfe, 8);
  __m128i hgdc = _mm_blend_epi16(hgfe, badc, 0xF0);
  for (; n > 0; --n, blocks += kSha256BlockBytes) {
    const __m128i feba_before = feba, hgdc_before = hgdc;
    __m128i w[4];
    for (int k = 0; k < 4; ++k) {
      w[k] = _mm_shuffle_epi8(_mm_loadu_si128(four(blocks + 16 * k)), big_endian);
    }
#pragma GCC unroll 16
    for (int r = 0; r < 16; ++r) {
      __m128i &oldest = w[r % 4], &newest = w[(r + 3) % 4];
      const __m128i sum = _mm_add_epi32(oldest, _mm_load_si128(four(&kRound[4U * unsigned(r)])));
      hgdc = _mm_sha256rnds2_epu32(hgdc, feba, sum);
      feba = _mm_sha256rnds2_epu32(feba, hgdc, _mm_shuffle_epi32(sum, 0x0E));
      const __m128i across = _mm_alignr_epi8(newest, w[(r + 2) % 4], 4);
      const __m128i next = _mm_add_epi32(_mm_sha256msg1_epu32(oldest, w[(r + 1) % 4]), across);
      oldest = _mm_sha256msg2_epu32(next, newest);
    }
    feba = _mm_add_epi32(feba, feba_before);
    hgdc = _mm_add_epi32(hgdc, hgdc_before);
  }
  const __m128i abef = _mm_shuffle_epi32(feba, 0x1B), ghcd = _mm_shuffle_epi32(hgdc, 0xB1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(&state[0]), _mm_blend_epi16(abef, ghcd, 0xF0));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(&state[4]), _mm_alignr_epi8(ghcd, abef, 8));
}

bool has_sha256() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  constexpr unsigned kSha = 1U << 29U;
  return __builtin_cpu_supports("sse4.1") && __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 &&
         (b & kSha) != 0;
}

#else

void sha256_by_cpu(Sha256State& state, const unsigned char* blocks, std::size_t n) {
  sha256_by_libsodium(state, blocks, n);
}
bool has_sha256() { return false; }

#endif

void sha256_blocks(Sha256State& state, const unsigned char* blocks, std::size_t n) {
  static const auto by = has_sha256() ? sha256_by_cpu : sha256_by_libsodium;
  by(state, blocks, n);
}

}  // namespace trammel::store

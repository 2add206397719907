#include "render/accel/arithmetic.h"

#if defined(__x86_64__)
#include <immintrin.h>
#else
#include <arm_neon.h>
#endif

#include <bit>
#include <cmath>
#include <string_view>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

/// FNV-1a over words instead of bytes.
class Checksum {
 public:
  void add(std::uint32_t word) { state_ = (state_ ^ word) * 0x100000001b3u; }
  void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }
  void add(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    add(static_cast<std::uint32_t>(bits));
    add(static_cast<std::uint32_t>(bits >> 32));
  }
  std::uint32_t value() const { return static_cast<std::uint32_t>(state_ ^ state_ >> 32); }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

/// Mantissas over two octaves, for rsqrt differs between even and odd exponents, in steps that let all lower
/// bits vary: tables of such instructions have 2^14 entries at most, of which each is met. Then every
/// exponent, where results overflow, underflow or are flushed to zero. A multiple of 16 values.
std::vector<float> sweep() {
  std::vector<float> values;
  for (std::uint32_t bits = 0x3f800000u; bits < 0x40800000u; bits += 251)
    values.push_back(std::bit_cast<float>(bits));
  for (std::uint32_t exponent = 0; exponent < 256; ++exponent) {
    values.push_back(std::bit_cast<float>(exponent << 23 | 0x2aaaab));
  }
  values.resize((values.size() + 15) / 16 * 16, 1.0f);
  return values;
}

/// Adds what a vector instruction makes of each value.
template <int kLanes, class Load, class Apply, class Store>
void add_all(const std::vector<float>& values, Checksum& sum, Load load, Apply apply, Store store) {
  float results[kLanes];
  for (std::size_t i = 0; i < values.size(); i += kLanes) {
    store(results, apply(load(values.data() + i)));
    for (const float result : results) sum.add(result);
  }
}

void add_approximations(Checksum& sum) {
  const std::vector<float> values = sweep();
#if defined(__x86_64__)
  const auto add8 = [&](auto apply) {
    add_all<8>(
        values, sum, [](const float* from) { return _mm256_loadu_ps(from); }, apply,
        [](float* to, __m256 v) { _mm256_storeu_ps(to, v); });
  };
  add8([](__m256 x) { return _mm256_rcp_ps(x); });
  add8([](__m256 x) { return _mm256_rsqrt_ps(x); });
#if defined(__AVX512F__)
  const auto add16 = [&](auto apply) {
    add_all<16>(
        values, sum, [](const float* from) { return _mm512_loadu_ps(from); }, apply,
        [](float* to, __m512 v) { _mm512_storeu_ps(to, v); });
  };
  add16([](__m512 x) { return _mm512_rcp14_ps(x); });
  add16([](__m512 x) { return _mm512_rsqrt14_ps(x); });
#endif
#else
  const auto add4 = [&](auto apply) {
    add_all<4>(
        values, sum, [](const float* from) { return vld1q_f32(from); }, apply,
        [](float* to, float32x4_t v) { vst1q_f32(to, v); });
  };
  add4([](float32x4_t x) { return vrecpeq_f32(x); });
  add4([](float32x4_t x) { return vrsqrteq_f32(x); });
#endif
}

/// Sums in float and double over what tables ask for: angles, exponents, colours.
void add_library(Checksum& sum) {
  for (int i = 1; i <= 256; ++i) {
    const double x = i * (1.0 / 81);  // no sums of powers of two
    const auto f = static_cast<float>(x);
    for (const double y : {std::sin(x), std::cos(x), std::tan(x), std::exp(-x), std::log(x), std::pow(x, 2.4),
                           std::atan2(x, 1.7), std::acos(x / 4), std::cbrt(x), std::hypot(x, 0.3)}) {
      sum.add(y);
    }
    for (const float y : {std::sin(f), std::cos(f), std::tan(f), std::exp(-f), std::log(f), std::pow(f, 2.4f),
                          std::atan2(f, 1.7f), std::acos(f / 4), std::cbrt(f), std::hypot(f, 0.3f)}) {
      sum.add(y);
    }
  }
}

}  // namespace

std::uint32_t arithmetic_checksum() {
  Checksum sum;
  add_approximations(sum);
  add_library(sum);
  for (const char letter : std::string_view(__VERSION__)) sum.add(static_cast<std::uint32_t>(letter));
  return sum.value();
}

}  // namespace tessera::render::TESSERA_ISA

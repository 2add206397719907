#include "image/exr/zip_block.h"

#include <libdeflate.h>

#include <cstddef>
#include <new>

namespace tessera::client {
namespace {

// Noise does not repeat: higher levels take a fourth to a half longer for 1 % at most.
constexpr int kLevel = 1;

}  // namespace

ZipBlockPacker::ZipBlockPacker() : compressor_(libdeflate_alloc_compressor(kLevel)) {
  if (compressor_ == nullptr) throw std::bad_alloc();
}

std::span<const unsigned char> ZipBlockPacker::pack(std::span<const unsigned char> block) {
  const std::size_t size = block.size(), half = (size + 1) / 2;
  if (size < 2) return block;
  halves_.resize(size), differences_.resize(size), packed_.resize(size);
  for (std::size_t i = 0; i < half; ++i) halves_[i] = block[2 * i];
  for (std::size_t i = 0; i < size / 2; ++i) halves_[half + i] = block[2 * i + 1];
  differences_[0] = halves_[0];
  for (std::size_t i = 1; i < size; ++i)
    differences_[i] = static_cast<unsigned char>(halves_[i] - halves_[i - 1] + 128);
  // One byte less than the block: else it fails, with 0.
  const std::size_t packed =
      libdeflate_zlib_compress(compressor_.get(), differences_.data(), size, packed_.data(), size - 1);
  return packed == 0 ? block : std::span<const unsigned char>(packed_).first(packed);
}

}  // namespace tessera::client

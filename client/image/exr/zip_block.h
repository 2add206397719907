// Compression of OpenEXR's ZIP blocks by libdeflate: the same bytes for readers, in a third of zlib's time.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/freer.h"

struct libdeflate_compressor;
extern "C" void libdeflate_free_compressor(libdeflate_compressor*);

namespace tessera::client {

/// Packs blocks of scanlines, one after the other. Throws std::bad_alloc.
class ZipBlockPacker {
 public:
  ZipBlockPacker();

  /// Bytes of a block as they stand in the file: those of even and of odd places apart, each less the one
  /// before, deflated [OpenEXR file layout, "ZIP"]; the block itself where that is no shorter, which is how
  /// readers tell the two apart. Valid until the next call, or until `block` is changed.
  std::span<const unsigned char> pack(std::span<const unsigned char> block);

 private:
  std::unique_ptr<libdeflate_compressor, base::Freer<libdeflate_free_compressor>> compressor_;
  std::vector<unsigned char> halves_, differences_, packed_;
};

}  // namespace tessera::client
